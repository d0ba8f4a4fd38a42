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
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/graph/session_outlet.hpp"

namespace hgros {

struct CallMessage;
class ReplyLine;

// How many bytes of one service may wait. A single message may wait at any size.
struct ServiceRoom {
  // A caller that has not subscribed for this time is the first to lose replies when there is no room.
  std::chrono::milliseconds fresh = std::chrono::seconds(2);
  // After this time without a subscription, a reply is replaced by a refusal.
  std::chrono::milliseconds away = std::chrono::seconds(30);
  std::size_t caller_bytes = 64U << 20;    // Replies to one caller.
  std::size_t service_bytes = 128U << 20;  // Replies to all callers, and apart from them requests of all callers.
  std::atomic<std::size_t> reply_bytes{0};
  std::mutex mutex;               // Locked before the mutex of a line.
  std::vector<ReplyLine*> lines;  // Under mutex.

  // 64 MiB for a caller, or an eighth of the free memory if that is less; twice that for the service.
  [[nodiscard]] static std::shared_ptr<ServiceRoom> OfFreeMemory();
};

// The memory that a request or a reply takes.
[[nodiscard]] std::size_t BytesOf(const CallMessage& call);

// Sends the replies of one service to one caller in another session. Replies that the caller cannot take yet (its
// subscription has not arrived, or its credit is used up) wait here, until their calls have timed out. Their order is
// not guaranteed. A reply for which there is no room is replaced by a short refusal. If the room of all callers is used
// up, callers that hold more, or that have not subscribed for a while, lose their oldest replies to this one.
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
  ~ReplyLine();

  static constexpr std::size_t kMaxWaiting = 65536;

  // False if the reply was dropped: too much waits, or the line is closed. `due`: when the call has timed out.
  bool Send(std::shared_ptr<const CallMessage> reply, std::optional<Moment> due = std::nullopt);
  // Sends what it can. Returns the number of replies that were dropped since the last time, without those that Send()
  // has reported: their calls have timed out, other callers needed the room, or the caller does not subscribe.
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
    std::size_t bytes = 0;  // 0: a refusal.
    Moment since = std::chrono::steady_clock::now();
  };
  // What a reply is short of.
  enum class Lack { kNothing, kRoomOfCaller, kRoomOfAll, kLine };
  // How much a line is to blame for a full room.
  struct Blame {
    bool away = false;  // It has not subscribed for a while.
    std::size_t bytes = 0;
    auto operator<=>(const Blame&) const = default;  // NOLINT(modernize-use-nullptr): clang-tidy 14 takes its 0 for one
  };
  [[nodiscard]] PublishStatus Pass(const std::shared_ptr<const CallMessage>& reply);
  // False if the reply must wait. A reply that can never be written is replaced by a refusal.
  [[nodiscard]] bool TrySend(std::shared_ptr<const CallMessage>& reply);
  // kNothing: it is queued, otherwise it is unchanged.
  [[nodiscard]] Lack TryQueue(Waiting& reply);
  // Takes room from the line that is most to blame. False if that is this one.
  [[nodiscard]] bool TakeRoom(const Waiting& reply);
  // `waited`: long enough for a subscription to arrive.
  void SayDropped(const std::string& when, bool waited);
  // The oldest replies, at least `bytes` if there are so many. Refusals wait in their place.
  [[nodiscard]] std::vector<Waiting> GiveUp(std::size_t bytes);
  [[nodiscard]] Blame BlameOf(std::size_t more);
  // Under mutex_.
  [[nodiscard]] Lack LackFor(const Waiting& reply) const;
  // How long the oldest reply has waited without a subscription.
  [[nodiscard]] std::chrono::nanoseconds AwayFor(Moment now) const;
  // Puts a refusal in its place.
  [[nodiscard]] Waiting Refuse(Waiting& reply, const std::string& why);
  void Count(const Waiting& reply);
  void Discount(const Waiting& reply);
  // The time for the next look at what is overdue, if it must be asked for now.
  [[nodiscard]] std::optional<Moment> NextLook(Moment due, Moment now);
  // When the call has timed out, or the reply has waited too long for a subscription.
  [[nodiscard]] Moment EndOf(const Waiting& reply) const;
  // Replies whose calls have timed out.
  std::deque<Waiting> TakeOverdue(Moment now);
  // Replies that have waited too long for a subscription.
  std::vector<Waiting> TakeUnsubscribed(Moment now);

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
  std::size_t given_up_ = 0;             // Since the last Flush().
  std::atomic<Moment> subscribed_at_{};  // The last time at which a subscribed caller took no reply.
  std::optional<Moment> looks_at_;       // Flush() is asked for at this time.
  std::optional<Moment> said_at_;
  bool closed_ = false;
};

}  // namespace hgros
