#pragma once

#include <atomic>
#include <chrono>
#include <compare>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "component/component_guard.hpp"
#include "component/number_gaps.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/graph/node_queue.hpp"
#include "hgros/graph/queue.hpp"
#include "hgros/graph/subscription.hpp"
#include "hgros/internal/graph/callback.hpp"

namespace hgros {

// The publisher of messages.
struct MessageSender {
  std::uint64_t id;
  std::uint64_t incarnation;
  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 takes its 0 for one
  auto operator<=>(const MessageSender&) const = default;
};
inline MessageSender SenderOf(const MessageId& id) { return {id.publisher, id.incarnation}; }

// The messages of one input of a component that can be saved. They pass on to the callback, or wait here while the
// component moves to another place. Knows how far the callback has come with each publisher.
//
// Those that have waited are handled by the threads of the subscription as well: each has it called once without a
// message. So the queue's limits hold for a callback that is slower than its publishers, and nobody waits for it.
//
// Thread safety: all functions. Next, LetPass and Pass belong to the thread that moves the component.
class InputGate {
 public:
  struct Waiting {
    AnyMessage message;
    MessageInfo info;
  };
  // How far the callback has come with one publisher.
  struct Position {
    MessageInfo last;   // Without the rest of what is known of the message.
    NumberGaps gaps{};  // By MessageInfo::number; also of messages that were not sent here.
  };
  InputGate(std::string node, const TypeInfo& type, Invoke invoke, Queue queue, AnyCallback callback,
            std::shared_ptr<ComponentGuard> guard);

  [[nodiscard]] const std::string& node() const noexcept { return node_; }
  [[nodiscard]] const TypeInfo& type() const noexcept { return type_; }
  // Whether it also wants messages that a later one of the same publisher has overtaken on the way. A serial input that
  // keeps only the newest does not.
  [[nodiscard]] bool takes_late() const;
  // How many wait at most.
  [[nodiscard]] std::size_t most() const;
  // It is subscribed. The session's configuration may have set another queue.
  void Join(const Subscription& subscription);

  // When many wait: as many as the queue holds if it is lossless, otherwise very many. kWaits: the others wait in the
  // queue of the subscription, so that the publisher's limits hold here, too; without a queue, the thread that brings
  // one more waits. kDropsOldest: they are not needed, because the other place of the component has them as well.
  enum class Full { kWaits, kDropsOldest };

  // A message of the input, or none; in the callback of its subscription.
  void Take(const AnyMessage& message, const MessageInfo& info);
  // From now on messages wait, and `wake` is called for each.
  void Hold(std::function<void()> wake, Full full);
  // The oldest that waits.
  [[nodiscard]] std::optional<Waiting> Next();
  // Whether Next has more now or in a moment: some may wait in the queue of the subscription.
  [[nodiscard]] bool has_more() const;
  // While others wait: this one is to be handled, after those of earlier calls. Without a queue it is handled at once,
  // and what the callback throws is thrown.
  void LetPass(Waiting message);
  // Whether few of those are left.
  [[nodiscard]] bool has_room() const;
  // Calls `pass` for those that wait, which calls LetPass, and lets messages pass again. Meanwhile the subscription
  // brings few more: they wait in its queue. Without a queue, a thread that brings one waits, but at most 100 ms,
  // because the callback may wait for such a thread. With `skip_handled`, messages up to the position of their
  // publisher are dropped from then on, but not those in its gaps: they were handled in another place.
  void Pass(const std::function<void(Waiting)>& pass, bool skip_handled);
  // The component ends. If messages wait, they are dropped, and those that come as well.
  void Close();

  // While messages wait: what they reach from now on.
  void Replace(AnyCallback callback) { callback_ = std::move(callback); }
  // Of each publisher, here or in another place.
  [[nodiscard]] std::vector<Position> Positions() const;
  void NotePosition(const MessageInfo& last);

 private:
  enum class State { kPasses, kHolds, kClosed };
  struct Dropped {
    std::optional<Waiting> message{};
    NodeQueue counts{};  // Where it is counted, without the lock; none if the other place has the message.
  };

  // The lock is held.
  static void Note(std::vector<Position>& positions, const MessageInfo& info);
  // How many may wait.
  [[nodiscard]] std::size_t Most() const noexcept;
  [[nodiscard]] bool TakesLate() const noexcept { return invoke_ == Invoke::kConcurrent || queue_.lossless(); }
  // Lets messages wait in the queue of the subscription. False: it has none.
  bool TrySuspend();
  void SuspendIfFull();
  // Messages come again.
  void Continue();
  // Whether it was handled in another place.
  [[nodiscard]] bool Skips(const MessageInfo& info) const;
  // Lets it wait, and perhaps drops the oldest that waits.
  void Keep(Waiting message, Dropped& dropped);
  // The first that may pass. Empty: there is none, or it was dropped because so many newer ones follow.
  [[nodiscard]] std::optional<Waiting> TakePassing(Dropped& dropped);
  // Without the lock.
  void Call(const Waiting& message);

  const std::string node_;
  const TypeInfo& type_;
  const Invoke invoke_;
  AnyCallback callback_;
  const std::shared_ptr<ComponentGuard> guard_;

  mutable std::mutex mutex_;
  Queue queue_;
  NodeQueue node_queue_;
  std::condition_variable room_;
  State state_ = State::kPasses;
  std::function<void()> wake_;
  Full full_ = Full::kWaits;
  std::deque<Waiting> waiting_;
  bool suspended_ = false;                                  // More wait in the queue of the subscription.
  std::deque<Waiting> passing_;                             // To be handled before all others.
  std::chrono::steady_clock::time_point catches_up_until_;  // Until then, all of these are.
  std::optional<std::thread::id> drains_;                   // Which thread handles them until none waits.
  std::vector<Position> skipped_;                           // Up to where messages were handled in another place.
  std::vector<Position> positions_;
};

}  // namespace hgros
