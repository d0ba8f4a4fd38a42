#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "hgros/base/log.hpp"
#include "hgros/graph/session_outlet.hpp"

namespace hgros {

struct CallMessage;

// How many bytes of one service may wait. A single message may wait at any size.
struct ServiceRoom {
  std::size_t caller_bytes = 64U << 20;    // Replies to one caller.
  std::size_t service_bytes = 128U << 20;  // Replies to all callers, and apart from them requests of all callers.
  std::atomic<std::size_t> reply_bytes{0};

  // 64 MiB for a caller, or an eighth of the free memory if that is less; twice that for the service.
  [[nodiscard]] static std::shared_ptr<ServiceRoom> OfFreeMemory();
};

// The memory that a request or a reply takes.
[[nodiscard]] std::size_t BytesOf(const CallMessage& call);

// Sends the replies of one service to one caller in another session. Replies that the caller cannot take yet (its
// subscription has not arrived, or its credit is used up) wait here, until their calls have timed out. Their order is
// not guaranteed. A reply for which there is no room is replaced by a short refusal.
//
// Thread safety: all functions. Flush() by one thread at a time.
class ReplyLine {
 public:
  using Moment = std::chrono::steady_clock::time_point;
  struct Means {
    std::function<void()> flush_soon;
    std::function<void(Moment)> flush_at;
    // Why the caller takes no replies; a sentence. `subscribed`: it has subscribed to them.
    std::function<std::string(bool subscribed)> why;
  };
  // `caller`: its name, for the log.
  ReplyLine(std::shared_ptr<SessionOutlet> outlet, const TypeInfo& type, std::shared_ptr<Log> log, std::string service,
            std::string caller, std::shared_ptr<ServiceRoom> room, Means means);
  ReplyLine(const ReplyLine&) = delete;
  ReplyLine& operator=(const ReplyLine&) = delete;
  ~ReplyLine() { (void)Close(); }

  static constexpr std::size_t kMaxWaiting = 65536;

  // False if the reply was dropped: too much waits, or the line is closed. `due`: when the call has timed out.
  bool Send(std::shared_ptr<const CallMessage> reply, std::optional<Moment> due = std::nullopt);
  // Sends what it can. Returns the number of replies that it has dropped because their calls have timed out.
  std::size_t Flush();
  // The caller no longer waits for this call. True if its reply was waiting.
  bool Withdraw(std::uint64_t call);
  // Call it when the caller is gone. Returns the number of replies that were waiting.
  std::size_t Close();
  [[nodiscard]] const std::shared_ptr<SessionOutlet>& outlet() const noexcept { return outlet_; }

 private:
  struct Waiting {
    std::shared_ptr<const CallMessage> reply;
    std::optional<Moment> due;
    std::size_t bytes = 0;
  };
  [[nodiscard]] PublishStatus Pass(const std::shared_ptr<const CallMessage>& reply);
  // False if the reply must wait. A reply that can never be written is replaced by a refusal.
  [[nodiscard]] bool TrySend(std::shared_ptr<const CallMessage>& reply);
  // True if it is queued, otherwise it is unchanged.
  [[nodiscard]] bool TryQueue(Waiting& reply);
  void SayDropped(const std::string& when);
  // Under mutex_.
  [[nodiscard]] bool HasRoomFor(const Waiting& reply) const;
  void Count(const Waiting& reply);
  void Discount(const Waiting& reply);
  // The time for the next look at what is overdue, if it must be asked for now.
  [[nodiscard]] std::optional<Moment> NextLook(std::optional<Moment> due, Moment now);
  std::deque<Waiting> TakeOverdue(Moment now);

  const std::shared_ptr<SessionOutlet> outlet_;
  const TypeInfo& type_;
  const std::shared_ptr<Log> log_;
  const std::string service_;
  const std::string caller_;
  const std::shared_ptr<ServiceRoom> room_;
  const Means means_;
  std::mutex mutex_;
  std::deque<Waiting> waiting_;
  std::size_t bytes_ = 0;
  std::optional<Moment> looks_at_;  // Flush() is asked for at this time.
  std::optional<Moment> said_at_;
  bool closed_ = false;
};

}  // namespace hgros
