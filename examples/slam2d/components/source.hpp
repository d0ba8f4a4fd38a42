#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include <foxglove/PoseInFrame.pb.h>
#include <hgros/clock/derived_clocks.hpp>
#include <hgros/component/component.hpp>
#include <hgros/session/clock_publisher.hpp>
#include <hgros/tf/transforms.hpp>

#include "../app/messages.hpp"
#include "../laser_scan.hpp"

namespace slam2d {

/// Returns the next scan through its argument; false at the end. Throws std::runtime_error if its data is damaged.
using ScanReader = std::function<bool(LaserScan2&)>;

/// Publishes the scans of a log on `scan` (lossless: it waits for the matcher) and their odometry on `odometry` and as
/// the edges from `odom` to `laser`, from its own thread. Also publishes a clock with the log's time. The clock steps
/// from scan to scan, or it runs at the rate `rate` and each scan is published when the clock reaches its stamp. After
/// the last scan comes a message that marks the end. The source has finished when the writer has.
class Source {
 public:
  explicit Source(hgros::Context& context);

  void Activate();
  void Deactivate();

 private:
  void Run(const std::stop_token& stop);
  void Play(const std::stop_token& stop);
  void ShowOdometry(const LaserScan2& scan);
  /// Moves the clock to the stamp, or waits until the clock reaches it. Returns at once for an earlier stamp.
  void AdvanceTo(hgros::Time stamp, const std::stop_token& stop);
  void Send(std::unique_ptr<msg::Scan> message, const std::stop_token& stop);

  hgros::Context& context_;
  const ScanReader reader_;
  hgros::Transforms& transforms_;
  hgros::Publisher<msg::Scan> scans_;
  hgros::Publisher<foxglove::PoseInFrame> odometry_;
  std::uint64_t sent_ = 0;

  const std::shared_ptr<hgros::SimulatedClock> clock_ = hgros::SimulatedClock::Paused();
  const std::unique_ptr<hgros::ClockPublisher> published_clock_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  double rate_;  // Guarded by mutex_.
  const hgros::Listening rate_set_;

  std::jthread thread_;
};

}  // namespace slam2d
