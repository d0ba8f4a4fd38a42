#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include <foxglove/PoseInFrame.pb.h>
#include <hgros/clock/derived_clocks.hpp>
#include <hgros/hgros.hpp>
#include <hgros/params/param_service.hpp>
#include <hgros/session/clock_publisher.hpp>
#include <hgros/tf/transforms.hpp>

#include "../app/console.hpp"
#include "../app/ending.hpp"
#include "../app/messages.hpp"
#include "../app/parameters.hpp"
#include "../laser_scan.hpp"

namespace slam2d {

/// Returns the next scan through its argument; false at the end. Throws std::runtime_error if its data is damaged.
using ScanReader = std::function<bool(LaserScan2&)>;

struct SourceOptions {
  std::optional<std::uint64_t> scans = {};    ///< Maximum number of scans.
  std::optional<std::uint64_t> hold_at = {};  ///< Waits with this scan until Release().
};

/// Publishes scans on `scan` (lossless: it waits for the matcher) and their odometry on `odometry` and as the edges
/// from `odom` to `laser`, from its own thread. Also publishes a clock with the log's time. The clock steps from scan
/// to scan, or it runs at the rate `slam.source.rate` and each scan is published when the clock reaches its stamp.
///
/// Threading: thread-safe after construction.
/// Lifetime: destroy it after the ending has been decided; the destructor waits for the thread.
class SourceNode {
 public:
  static constexpr const char* kName = "source";

  /// `params` must outlive the node.
  SourceNode(hgros::Session& session, hgros::Transforms& transforms, ScanReader reader, const SourceOptions& options,
             NodeParams<SourceTuning>& params, Ending& ending, Console& console);
  SourceNode(const SourceNode&) = delete;
  SourceNode& operator=(const SourceNode&) = delete;

  /// Begins to publish. Call it once.
  void Start();

  /// Waits until the source holds before the scan `hold_at`. False if it has ended first.
  [[nodiscard]] bool WaitUntilHeld();
  void Release();

  [[nodiscard]] std::uint64_t sent() const { return sent_.load(std::memory_order_relaxed); }

 private:
  enum class Hold { kNotYet, kHeld, kReleased, kNever };

  void Run();
  void ShowOdometry(const LaserScan2& scan);
  [[nodiscard]] bool NextScan(LaserScan2& scan);
  void WaitForRelease();
  /// Moves the clock to the stamp, or waits until the clock reaches it. Returns at once for an earlier stamp.
  void AdvanceTo(hgros::Time stamp);
  [[nodiscard]] bool Send(std::unique_ptr<msg::Scan> message);

  ScanReader reader_;
  const SourceOptions options_;
  hgros::Transforms& transforms_;
  Ending& ending_;
  const std::stop_token stop_;
  hgros::Publisher<msg::Scan> scans_;
  hgros::Publisher<foxglove::PoseInFrame> odometry_;
  std::atomic<std::uint64_t> sent_{0};

  const std::shared_ptr<hgros::SimulatedClock> clock_ = hgros::SimulatedClock::Paused();

  std::mutex mutex_;
  std::condition_variable_any changed_;
  Hold hold_ = Hold::kNotYet;
  double rate_;

  const hgros::ClockPublisher published_clock_;
  hgros::Listening rate_set_;
  hgros::ParamService offered_;

  std::jthread thread_;
};

}  // namespace slam2d
