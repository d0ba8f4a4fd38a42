#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <stop_token>

#include <foxglove/PoseInFrame.pb.h>
#include <hgros/hgros.hpp>
#include <hgros/params/param_service.hpp>
#include <hgros/tf/transforms.hpp>

#include "../app/console.hpp"
#include "../app/ending.hpp"
#include "../app/messages.hpp"
#include "../scan_matcher.hpp"
#include "node_params.hpp"

namespace slam2d {

/// Takes scans and the map's updates. Publishes matched scans on `pre_channel`, their poses on `trajectory`, and the
/// origin of odometry as the edge from `map` to `odom`.
///
/// A scan waits inside its callback (on its own thread) until the map after the previous scan has arrived. The two are
/// joined by sequence, so the result does not depend on timing. The scans behind it fill the queue, which makes the
/// source wait. A changed parameter takes effect between two scans.
///
/// Lifetime: destroy it after the ending has been decided.
class MatcherNode {
 public:
  static constexpr const char* kName = "matcher";

  /// `params` must outlive the node.
  MatcherNode(hgros::Session& session, hgros::Transforms& transforms, NodeParams<MatcherOptions>& params,
              Ending& ending, Console& console);

  [[nodiscard]] std::uint64_t matched() const { return matched_.load(std::memory_order_relaxed); }

 private:
  void TakeScan(const msg::Scan& message);
  void TakeMap(const msg::MapUpdate& message);
  void ShowMatch(const ScanMatch& match, const Pose2& T_odom_laser);

  hgros::Transforms& transforms_;
  NodeParams<MatcherOptions>& params_;
  Ending& ending_;
  const std::stop_token stop_;
  hgros::Publisher<msg::MatchedScan> matches_;
  hgros::Publisher<foxglove::PoseInFrame> trajectory_;
  std::atomic<std::uint64_t> matched_{0};

  std::mutex mutex_;
  std::condition_variable_any map_changed_;
  ScanMatcher matcher_;
  std::uint64_t updates_ = 0;  // The replica is the map after scan updates_ - 1.

  hgros::Subscription map_subscription_;
  hgros::Subscription scan_subscription_;
  hgros::ParamService offered_;
};

}  // namespace slam2d
