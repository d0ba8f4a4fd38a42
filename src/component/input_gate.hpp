#pragma once

#include <atomic>
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
// Thread safety: all functions. Next, Handle and Pass belong to the thread that moves the component.
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
  // `takes_late`: also wants messages that a later one of the same publisher has overtaken on the way. A serial input
  // that keeps only the newest does not.
  InputGate(std::string node, const TypeInfo& type, bool takes_late, AnyCallback callback,
            std::shared_ptr<ComponentGuard> guard);

  [[nodiscard]] const std::string& node() const noexcept { return node_; }
  [[nodiscard]] const TypeInfo& type() const noexcept { return type_; }
  [[nodiscard]] bool takes_late() const noexcept { return takes_late_; }
  // Known only when it is subscribed: the session's configuration may set another queue.
  void SetTakesLate(bool takes_late) noexcept { takes_late_ = takes_late; }

  // When very many wait. kWaits: the others wait in the queue of the subscription, so that the publisher's limits hold
  // here, too; without a queue, the thread that brings one more waits. kDropsOldest: they are not needed, because the
  // other place of the component has them as well.
  enum class Full { kWaits, kDropsOldest };

  // A message of the input; in the callback of its subscription.
  void Take(const AnyMessage& message, const MessageInfo& info);
  // From now on messages wait, and `wake` is called for each.
  void Hold(std::function<void()> wake, Full full);
  // The oldest that waits.
  [[nodiscard]] std::optional<Waiting> Next();
  // Calls `handle` for those that wait, and lets messages pass again. Meanwhile the subscription brings few more,
  // because a publisher can be faster than `handle`: they wait in its queue. Without a queue, a thread that brings one
  // waits, but at most 100 ms, because `handle` may wait for such a thread. With `skip_handled`, messages up to the
  // position of their publisher are dropped from then on, but not those in its gaps: they were handled in another
  // place.
  void Pass(const std::function<void(Waiting)>& handle, bool skip_handled);
  // The component ends. If messages wait, they are dropped, and those that come as well.
  void Close();

  // While messages wait: what they reach from now on.
  void Replace(AnyCallback callback) { callback_ = std::move(callback); }
  // Calls the callback on this thread. Its exception is thrown.
  void Handle(const Waiting& waiting);
  // Of each publisher, here or in another place.
  [[nodiscard]] std::vector<Position> Positions() const;
  void NotePosition(const MessageInfo& last);

 private:
  enum class State { kPasses, kHolds, kClosed };

  void Note(const MessageInfo& info);
  // Lets messages wait in the queue of the subscription; in its callback. False: it has none. The lock is held.
  [[nodiscard]] bool TrySuspend();
  // Messages come again; the lock is held.
  void Continue();
  // Whether it was handled in another place.
  [[nodiscard]] bool Skips(const MessageInfo& info) const;

  const std::string node_;
  const TypeInfo& type_;
  std::atomic<bool> takes_late_;
  AnyCallback callback_;
  const std::shared_ptr<ComponentGuard> guard_;

  mutable std::mutex mutex_;
  std::condition_variable room_;
  State state_ = State::kPasses;
  std::function<void()> wake_;
  Full full_ = Full::kWaits;
  std::deque<Waiting> waiting_;
  std::function<void(bool)> suspend_;      // Set while more wait in the queue of the subscription.
  std::optional<std::thread::id> drains_;  // Which thread handles them until none waits.
  std::vector<Position> skipped_;          // Up to where messages were handled in another place.
  std::vector<Position> positions_;
};

}  // namespace hgros
