#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include <foxglove/PoseInFrame.pb.h>
#include <hgros/hgros.hpp>
#include <hgros/tf/transforms.hpp>

#include "../laser_scan.hpp"
#include "ending.hpp"
#include "messages.hpp"

namespace slam2d {

/// Gives the next scan; false at the end. Throws std::runtime_error with a sentence if its data are damaged.
using ScanReader = std::function<bool(LaserScan2&)>;

struct SourceOptions {
  double rate = 0.0;                     ///< Times real time, by the scans' stamps; 0: as fast as they are taken.
  std::optional<std::uint64_t> scans;    ///< At most so many.
  std::optional<std::uint64_t> hold_at;  ///< Waits with this scan until Release().
};

/// Publishes scans on `scan` (lossless: it waits for the matcher) and their odometry on `odometry` and as the edges
/// from `odom` to `laser`, from a thread of its own.
///
/// Threading: thread-safe once made.
/// Lifetime: to be destroyed after the ending has been decided; the destructor waits for the thread.
class SourceNode {
 public:
  static constexpr const char* kName = "source";

  SourceNode(hgros::Session& session, hgros::Transforms& transforms, ScanReader reader, const SourceOptions& options,
             Ending& ending);
  SourceNode(const SourceNode&) = delete;
  SourceNode& operator=(const SourceNode&) = delete;

  /// Begins to publish. Once.
  void Start();

  /// Waits until the source stands before the scan `hold_at`; false if it has ended before.
  [[nodiscard]] bool WaitUntilHeld();
  void Release();

  [[nodiscard]] std::uint64_t sent() const { return sent_.load(std::memory_order_relaxed); }

 private:
  enum class Hold { kNotYet, kHeld, kReleased, kNever };

  void Run();
  void ShowOdometry(const LaserScan2& scan);
  [[nodiscard]] bool NextScan(LaserScan2& scan);
  void WaitForRelease();
  /// Waits until the scan is due. Stamps that step back count as their latest predecessor.
  void Pace(double stamp_seconds);
  [[nodiscard]] bool Send(std::unique_ptr<msg::Scan> message);

  ScanReader reader_;
  const SourceOptions options_;
  hgros::Transforms& transforms_;
  Ending& ending_;
  const std::stop_token stop_;
  hgros::Publisher<msg::Scan> scans_;
  hgros::Publisher<foxglove::PoseInFrame> odometry_;
  std::atomic<std::uint64_t> sent_{0};

  double first_stamp_s_ = 0.0;
  double latest_stamp_s_ = 0.0;
  std::chrono::steady_clock::time_point first_sent_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  Hold hold_ = Hold::kNotYet;

  std::jthread thread_;
};

}  // namespace slam2d
