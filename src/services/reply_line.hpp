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

// The way of replies from one service to one caller of another session. What the caller cannot take yet, because its
// subscription is still on its way or its credit is used up, waits here, in no promised order.
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

  // False if it was dropped: too many wait, or the line is closed.
  bool Send(std::shared_ptr<const CallMessage> reply);
  void Flush();
  // Its caller is gone. How many replies waited for it.
  std::size_t Close();
  [[nodiscard]] const std::shared_ptr<SessionOutlet>& outlet() const noexcept { return outlet_; }

 private:
  [[nodiscard]] bool TrySend(const std::shared_ptr<const CallMessage>& reply);

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
