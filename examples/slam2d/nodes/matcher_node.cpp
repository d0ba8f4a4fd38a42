#include "matcher_node.hpp"

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "../app/channels.hpp"
#include "../app/frames.hpp"
#include "../app/parameters.hpp"
#include "../app/pose_message.hpp"

namespace slam2d {

MatcherNode::MatcherNode(hgros::Session& session, hgros::Transforms& transforms, NodeParams<MatcherOptions>& params,
                         Ending& ending, Console& console)
    : transforms_(transforms),
      params_(params),
      ending_(ending),
      stop_(ending.token()),
      matches_(session.Advertise<msg::MatchedScan>(kPreChannel)),
      trajectory_(session.Advertise<foxglove::PoseInFrame>(kTrajectory)),
      matcher_(params.Now(), MapOptions{}),
      map_subscription_(session.FromAny<msg::MapUpdate>(
          kNextChannel, hgros::Invoke::kSerial,
          [this](const msg::MapUpdate& message) { ending_.Guard("matcher", [&] { TakeMap(message); }); },
          {.name = "matcher/map", .queue = hgros::Queue::KeepAll(kLoopDepth), .executor = hgros::Executor::Inline()})),
      scan_subscription_(session.FromAny<msg::Scan>(
          kScan, hgros::Invoke::kSerial,
          [this](const msg::Scan& message) { ending_.Guard("matcher", [&] { TakeScan(message); }); },
          {.name = kName, .queue = hgros::Queue::KeepAll(kScanDepth), .executor = hgros::Executor::Dedicated()})),
      offered_(session, params.server(), kTunedMatcher.offered, console.log()) {}

void MatcherNode::TakeMap(const msg::MapUpdate& message) {
  if (message.end_of_log()) return;
  const MapDelta delta = Read(message);
  const std::scoped_lock lock(mutex_);
  if (delta.version != updates_) {
    throw std::runtime_error("the map after scan " + std::to_string(delta.version) +
                             " arrived, but the map after scan " + std::to_string(updates_) + " is next.");
  }
  if (message.has_layout()) matcher_.SetMap(Read(message.layout()));
  matcher_.Apply(delta);
  ++updates_;
  map_changed_.notify_all();
}

void MatcherNode::TakeScan(const msg::Scan& message) {
  auto matched = std::make_unique<msg::MatchedScan>();
  ScanMatch match;
  {
    std::unique_lock lock(mutex_);
    if (!map_changed_.wait(lock, stop_, [&] { return updates_ >= message.sequence(); })) return;
    if (!message.end_of_log()) {
      if (const auto options = params_.News()) matcher_.SetOptions(*options);
      match = matcher_.Match(Read(message));
      Write(match, *matched->mutable_match());
    }
  }
  *matched->mutable_scan() = message;
  if (const hgros::PublishStatus status = matches_(std::move(matched)); status != hgros::PublishStatus::kOk) {
    throw std::runtime_error("a matched scan could not be published: " + std::string(hgros::ToString(status)) + ".");
  }
  if (message.end_of_log()) return;
  matched_.fetch_add(1, std::memory_order_relaxed);
  ShowMatch(match, Read(message.odometry()));
}

void MatcherNode::ShowMatch(const ScanMatch& match, const Pose2& T_odom_laser) {
  Show(trajectory_, PoseMessage(match.T_map_laser, match.stamp_seconds, kMapFrame));
  (void)transforms_.ToTF(TimeOf(match.stamp_seconds), kMapFrame, kOdomFrame,
                         RigidOf(match.T_map_laser * Inverse(T_odom_laser)));
}

}  // namespace slam2d
