#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>

#include <foxglove/PoseInFrame.pb.h>
#include <hgros/component/component.hpp>
#include <hgros/tf/transforms.hpp>

#include "../app/messages.hpp"
#include "../scan_matcher.hpp"
#include "tuned.hpp"

namespace slam2d {

/// Takes scans and the map's updates. Publishes matched scans on `pre_channel`, their poses on `trajectory`, and the
/// origin of odometry as the edge from `map` to `odom`.
///
/// A scan waits inside its callback (on its own thread) until the map after the previous scan has arrived. The two are
/// joined by sequence, so the result does not depend on timing. The scans behind it fill the queue, which makes the
/// source wait. A matched scan without an answer is sent again: its mapper may have been killed, or was not yet
/// connected. The mapper takes it once. A changed parameter takes effect between two scans.
class Matcher {
 public:
  explicit Matcher(hgros::Context& context);

  void Deactivate();

 private:
  void TakeScan(const msg::Scan& message);
  void TakeMap(const msg::MapUpdate& message);
  void TakeState(const msg::MapState& message);
  /// True once the map after `scans` scans has arrived; false if the component ends first.
  [[nodiscard]] bool WaitForMap(std::uint64_t scans);
  void ShowMatch(const ScanMatch& match, const Pose2& T_odom_laser);

  hgros::Context& context_;
  hgros::Transforms& transforms_;
  std::stop_source stop_;
  hgros::Publisher<msg::MatchedScan> matches_;
  hgros::Publisher<foxglove::PoseInFrame> trajectory_;
  std::unique_ptr<const msg::MatchedScan> sent_;  // The last one. Used by TakeScan only.
  Tuned<MatcherOptions> tuned_;                   // Likewise.

  std::mutex mutex_;
  std::condition_variable_any map_changed_;
  ScanMatcher matcher_;
  bool begun_ = false;         // There is a mapper.
  std::uint64_t updates_ = 0;  // The replica is the map after scan updates_ - 1.
};

}  // namespace slam2d
