#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>

namespace hgros::zmq {

/// What has not arrived at the peers, as far as this side knows.
struct Arriving {
  bool any = false;
  std::uint64_t progress = 0;  ///< Another number than before: something has moved.
};

/// The wait at the end of a transport, until everything has arrived.
/// Thread safety: thread-safe.
class ArrivalWait {
 public:
  /// Returns when `look` finds nothing, after `linger` without progress, or after `at_most`.
  void Await(std::chrono::milliseconds linger, std::chrono::milliseconds at_most,
             const std::function<Arriving()>& look);
  /// The leading thread has read what has come.
  void NoteRound();

 private:
  std::mutex mutex_;
  std::condition_variable read_;
  std::uint64_t rounds_ = 0;
};

}  // namespace hgros::zmq
