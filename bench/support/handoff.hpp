#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include "hgros/clock/time.hpp"
#include "support/samples.hpp"

namespace hgros::bench {

/// The time when a callback began. The callback sets it, and the measuring thread waits for it.
class Arrival {
 public:
  void Note() {
    at_.store(MonotonicNow(), std::memory_order_release);
    at_.notify_one();
  }
  std::int64_t Wait() {
    at_.wait(0, std::memory_order_acquire);
    return at_.exchange(0, std::memory_order_acq_rel);
  }

 private:
  std::atomic<std::int64_t> at_{0};
};

/// One-way latencies in ns: from just before `send` until the time in `arrival`. The pauses are long enough for every
/// thread to fall asleep.
template <class Send>
Samples MeasureLatency(int count, std::chrono::microseconds pause, Arrival& arrival, Send send) {
  Samples samples;
  for (int i = 0; i < count; ++i) {
    std::this_thread::sleep_for(pause);
    const std::int64_t start = MonotonicNow();
    send();
    samples.Add(static_cast<double>(arrival.Wait() - start));
  }
  return samples;
}

}  // namespace hgros::bench
