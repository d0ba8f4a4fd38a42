#include "source_node.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "channels.hpp"
#include "frames.hpp"
#include "pose_message.hpp"

namespace slam2d {

SourceNode::SourceNode(hgros::Session& session, hgros::Transforms& transforms, ScanReader reader,
                       const SourceOptions& options, Ending& ending)
    : reader_(std::move(reader)),
      options_(options),
      transforms_(transforms),
      ending_(ending),
      stop_(ending.token()),
      scans_(session.Advertise<msg::Scan>(kScan)),
      odometry_(session.Advertise<foxglove::PoseInFrame>(kOdometry)) {}

void SourceNode::Start() {
  thread_ = std::jthread([this] {
    try {
      Run();
    } catch (const std::exception& error) {  // from the reader
      ending_.Fail(error.what(), kBadInput);
    }
    const std::scoped_lock lock(mutex_);
    if (hold_ == Hold::kNotYet) hold_ = Hold::kNever;
    changed_.notify_all();
  });
}

bool SourceNode::NextScan(LaserScan2& scan) {
  return !stop_.stop_requested() && (!options_.scans || sent() < *options_.scans) && reader_(scan);
}

void SourceNode::Run() {
  (void)transforms_.ToStaticTF(kBaseFrame, kLaserFrame, RigidOf(kBaseLaser));
  LaserScan2 scan;
  while (NextScan(scan)) {
    if (scan.sequence == options_.hold_at) WaitForRelease();
    if (options_.rate > 0.0) Pace(scan.stamp_seconds);
    if (stop_.stop_requested()) return;
    auto message = std::make_unique<msg::Scan>();
    Write(scan, *message);
    if (!Send(std::move(message))) return;
    sent_.fetch_add(1, std::memory_order_relaxed);
    ShowOdometry(scan);
  }
  if (stop_.stop_requested()) return;
  auto end = std::make_unique<msg::Scan>();
  end->set_sequence(sent());
  end->set_end_of_log(true);
  (void)Send(std::move(end));  // the end is already decided if it fails
}

// For whoever looks: what is refused, such as a stamp long past, changes nothing in the graph.
void SourceNode::ShowOdometry(const LaserScan2& scan) {
  Show(odometry_, PoseMessage(scan.odometry, scan.stamp_seconds, "odometry"));
  const Pose2 T_odom_base = scan.odometry * Inverse(kBaseLaser);
  (void)transforms_.ToTF(TimeOf(scan.stamp_seconds), kOdomFrame, kBaseFrame, RigidOf(T_odom_base));
}

bool SourceNode::Send(std::unique_ptr<msg::Scan> message) {
  const hgros::PublishStatus status =
      scans_.Wait(std::move(message), std::chrono::steady_clock::time_point::max(), stop_);
  if (status == hgros::PublishStatus::kOk) return true;
  ending_.Fail("source: a scan could not be published: " + std::string(hgros::ToString(status)) + ".");
  return false;
}

void SourceNode::Pace(double stamp_seconds) {
  if (sent() == 0) {
    first_stamp_s_ = latest_stamp_s_ = stamp_seconds;
    first_sent_ = std::chrono::steady_clock::now();
  }
  latest_stamp_s_ = std::max(latest_stamp_s_, stamp_seconds);
  const std::chrono::duration<double> after((latest_stamp_s_ - first_stamp_s_) / options_.rate);
  const auto due = first_sent_ + std::chrono::duration_cast<std::chrono::steady_clock::duration>(after);
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop_, due, [] { return false; });
}

void SourceNode::WaitForRelease() {
  std::unique_lock lock(mutex_);
  hold_ = Hold::kHeld;
  changed_.notify_all();
  changed_.wait(lock, stop_, [this] { return hold_ == Hold::kReleased; });
}

bool SourceNode::WaitUntilHeld() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop_, [this] { return hold_ != Hold::kNotYet; });
  return hold_ == Hold::kHeld;
}

void SourceNode::Release() {
  const std::scoped_lock lock(mutex_);
  hold_ = Hold::kReleased;
  changed_.notify_all();
}

}  // namespace slam2d
