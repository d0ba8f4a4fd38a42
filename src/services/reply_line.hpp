#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "hgros/base/log.hpp"
#include "hgros/graph/session_outlet.hpp"

namespace hgros {

struct CallMessage;

// Sends the replies of one service to one caller in another session. Replies that the caller cannot take yet (its
// subscription has not arrived, or its credit is used up) wait here. Their order is not guaranteed.
//
// Thread safety: all functions. Flush() by one thread at a time.
class ReplyLine {
 public:
  ReplyLine(std::shared_ptr<SessionOutlet> outlet, const TypeInfo& type, std::shared_ptr<Log> log, std::string service,
            std::function<void()> flush_soon)
      : outlet_(std::move(outlet)),
        type_(type),
        log_(std::move(log)),
        service_(std::move(service)),
        flush_soon_(std::move(flush_soon)) {}

  static constexpr std::size_t kMaxWaiting = 65536;

  // False if the reply was dropped: too many are waiting, or the line is closed.
  bool Send(std::shared_ptr<const CallMessage> reply);
  void Flush();
  // Call it when the caller is gone. Returns the number of replies that were waiting.
  std::size_t Close();
  [[nodiscard]] const std::shared_ptr<SessionOutlet>& outlet() const noexcept { return outlet_; }

 private:
  [[nodiscard]] PublishStatus Pass(const std::shared_ptr<const CallMessage>& reply);
  // False if the reply must wait. A reply that can never be written is replaced by a refusal.
  [[nodiscard]] bool TrySend(std::shared_ptr<const CallMessage>& reply);

  const std::shared_ptr<SessionOutlet> outlet_;
  const TypeInfo& type_;
  const std::shared_ptr<Log> log_;
  const std::string service_;
  const std::function<void()> flush_soon_;
  std::mutex mutex_;
  std::deque<std::shared_ptr<const CallMessage>> waiting_;
  bool closed_ = false;
};

}  // namespace hgros
