#pragma once

#include <cstdint>
#include <vector>

#include "hgros/base/export.hpp"

namespace hgros {

/// Which thread runs a subscription's callback. A value; immutable.
class HGROS_EXPORT Executor {
 public:
  enum class Kind : std::uint8_t {
    kTbb,        ///< The graph's work-stealing workers: the default, for callbacks of any length.
    kInline,     ///< The thread that delivers: the publisher's own, or a receiving one. Lowest latency; keep it short.
    kDedicated,  ///< A thread of its own; runs one callback at a time, also for Invoke::kConcurrent.
    kPolled,     ///< The program's own threads, whenever they call Subscription::RunWaiting().
  };

  /// Work stealing.
  Executor() = default;
  [[nodiscard]] static Executor Tbb();
  [[nodiscard]] static Executor Inline();
  /// `cpus`: CPU numbers the thread may run on, empty for all. `fifo_priority`: 1 to 99 requests SCHED_FIFO, 0 the
  /// ordinary scheduler. If the system refuses, that is logged once and the thread runs without it.
  [[nodiscard]] static Executor Dedicated(std::vector<int> cpus = {}, int fifo_priority = 0);

  /// Messages wait in the queue until the program runs the callback itself, for example in a loop that also waits for
  /// other descriptors: see Subscription::RunWaiting(). Only for subscriptions. The configuration does not replace it.
  [[nodiscard]] static Executor Polled();

  [[nodiscard]] Kind kind() const noexcept { return kind_; }
  [[nodiscard]] const std::vector<int>& cpus() const noexcept { return cpus_; }
  [[nodiscard]] int fifo_priority() const noexcept { return fifo_priority_; }
  bool operator==(const Executor&) const = default;

 private:
  Kind kind_ = Kind::kTbb;
  std::vector<int> cpus_;
  int fifo_priority_ = 0;
};

}  // namespace hgros
