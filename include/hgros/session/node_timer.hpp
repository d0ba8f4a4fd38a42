#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/clock/timer_queue.hpp"
#include "hgros/graph/executor.hpp"
#include "hgros/graph/queue.hpp"
#include "hgros/graph/subscription.hpp"

namespace hgros {

/// Options of a new timer. The configuration of the node with the timer's name overrides queue and executor.
struct NodeTimerOptions {
  Missed missed = Missed::kSkip;
  std::optional<Duration> first = {};  ///< Time to the first turn; empty: one period.
  /// The queue of turns that come while the callback runs. Default: the latest turn, with Missed::kCatchUp the latest
  /// 1024.
  std::optional<Queue> queue = {};
  Executor executor = {};  ///< Inline: the thread of the session's timers. Keep such a callback short.
};

/// Keeps a timer of a session running; move-only. The callback is a serial node of the data graph on the channel
/// "timer/NAME": it runs and is counted like any node.
///
/// Lifetime: as Subscription. Destroying it stops new calls at once. Outside callbacks it waits for the running call;
/// inside any callback of the same session it does not. It may outlive its session and then does nothing.
class HGROS_EXPORT NodeTimer {
 public:
  NodeTimer() = default;
  /// For the session. `name` is released when the timer ends.
  NodeTimer(Timer firing, Subscription node, std::shared_ptr<const void> name)
      : name_(std::move(name)), node_(std::move(node)), firing_(std::move(firing)) {}

  /// Ends the timer and waits for the running call, inside other callbacks too. Returns false without waiting inside
  /// this timer's own callback.
  bool Join();
  /// Ends the timer as the destructor does.
  void Reset();

  [[nodiscard]] bool active() const { return node_.active(); }
  [[nodiscard]] std::string name() const { return node_.name(); }
  [[nodiscard]] NodeSnapshot stats() const { return node_.stats(); }

 private:
  // The last one ends first.
  std::shared_ptr<const void> name_;
  Subscription node_;
  Timer firing_;
};

}  // namespace hgros
