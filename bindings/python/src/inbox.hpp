#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "arrival.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/graph/handed_over.hpp"
#include "hgros/graph/queue.hpp"
#include "of_process.hpp"
#include "ready_list.hpp"

namespace hgros::python {

/// The bounded queue between a thread of the library and one of Python.
///
/// A keep-last queue drops its oldest and counts it. A lossless one lets the pushing thread wait, which must therefore
/// be a dedicated thread of a node; the node's own queue then fills up and holds back publishers. It takes little out
/// of that queue: at most kLosslessRoom messages and about kLosslessBytes.
///
/// Thread safety: all functions. Push() never takes the GIL. In a forked child Close() does nothing, and what Python
/// calls besides throws Error.
class Inbox : public OfProcess {
 public:
  static constexpr std::size_t kLosslessRoom = 64;
  static constexpr std::size_t kLosslessBytes = std::size_t{1} << 20;

  /// `ready` gets `key` when the inbox has something.
  Inbox(std::shared_ptr<ReadyList> ready, int key) : ready_(std::move(ready)), key_(key) {}

  /// Before this, nothing is dropped and nobody waits: a node tells its queue only when it has been made.
  void SetQueue(const Queue& queue);
  void Push(Arrival arrival);
  /// The node that fills the inbox, which counts what is dropped.
  void SetNode(const HandedOver& node);
  /// The node counts the message that Begin() names as handled once Finish() is called, or as refused in Skip().
  /// With the GIL.
  void Begin(const MessageInfo& info) { handled_ = Handled{info, MonotonicNow()}; }
  void Finish(bool failed);
  void Skip();
  /// At most `most`, the oldest first; none if there is none.
  [[nodiscard]] std::vector<Arrival> Take(std::size_t most);
  /// The oldest; empty if there is none. `more` tells whether others wait, for which the list does not get the key.
  [[nodiscard]] std::optional<Arrival> TakeOne(bool& more);
  /// As TakeOne(), but leaves a message whose schema is not that of the last call of IsNew(): `other` tells that.
  [[nodiscard]] std::optional<Arrival> TakeKnown(bool& more, bool& other);
  /// Whether `schema` is not that of the last call. For the one thread that takes.
  [[nodiscard]] bool IsNew(const std::shared_ptr<const MessageSchema>& schema) {
    return std::exchange(last_schema_, schema) != schema;
  }
  /// Of the thread that takes: callbacks that have begun, and whose message was the last one if it could not be
  /// decoded.
  void CountCallback() noexcept { ++ran_; }
  void NoteUndecoded(std::uint64_t publisher) noexcept { undecoded_ = publisher; }
  [[nodiscard]] std::uint64_t ran() const noexcept { return ran_; }
  [[nodiscard]] std::optional<std::uint64_t> TakeUndecoded() noexcept { return std::exchange(undecoded_, {}); }
  /// Drops what waits, without counting it.
  void Clear();
  /// Ends all waiting. Nothing can be pushed or taken any more.
  void Close();

  [[nodiscard]] std::uint64_t dropped() const;
  [[nodiscard]] std::size_t queued() const;

 private:
  [[nodiscard]] bool HasRoomLocked() const noexcept;
  template <class Fits>
  [[nodiscard]] std::optional<Arrival> TakeOneIf(Fits fits, bool& more, bool& other);

  const std::shared_ptr<ReadyList> ready_;
  const int key_;
  mutable std::mutex mutex_;
  std::shared_ptr<const MessageSchema> last_schema_;
  std::condition_variable room_;
  std::deque<Arrival> arrivals_;
  std::size_t bytes_ = 0;
  std::optional<Queue> queue_;
  HandedOver node_;
  struct Handled {
    MessageInfo info;
    std::int64_t start_ns;
  };
  std::optional<Handled> handled_;
  std::uint64_t dropped_ = 0;
  std::uint64_t ran_ = 0;
  std::optional<std::uint64_t> undecoded_;  // The publisher.
  bool announced_ = false;                  // The list has our key.
  bool closed_ = false;
};

}  // namespace hgros::python
