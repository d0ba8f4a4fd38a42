#pragma once

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <deque>
#include <string>
#include <thread>

namespace hgros::resilience {

/// Two hosts, 10.196.0.1 and 10.196.0.2, and a cable between them that delays each frame, and may limit the rate.
/// Unlike a relay it acknowledges nothing: what the other host has not got stays in the sender's kernel. Needs root.
class SlowCable {
 public:
  /// `bits_per_second`: 0 for no limit.
  SlowCable(std::chrono::milliseconds each_way, double bits_per_second);
  SlowCable(const SlowCable&) = delete;
  SlowCable& operator=(const SlowCable&) = delete;
  ~SlowCable();
  /// From now on every frame is lost.
  void Cut() { cut_ = true; }

  const std::string left = "hgta" + std::to_string(getpid());
  const std::string right = "hgtb" + std::to_string(getpid());
  bool ready = false;

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Frame {
    Time due;
    std::string bytes;
  };
  struct Lane {
    int from = -1;
    int to = -1;
    Time free{};  // When its rate allows the next frame.
    std::deque<Frame> frames;
  };

  void Run();
  void Read(Lane& lane, Time now) const;
  static void Write(Lane& lane, Time now);

  const std::chrono::milliseconds each_way_;
  const double bits_per_second_;
  std::atomic<bool> cut_{false};
  Lane lanes_[2];  // Only the thread uses them.
  int stop_[2] = {-1, -1};
  std::thread thread_;
};

}  // namespace hgros::resilience
