#include "source_node.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "../app/channels.hpp"
#include "../app/frames.hpp"
#include "../app/pose_message.hpp"

namespace slam2d {
namespace {

constexpr double kLongestWaitNs = 3.6e12;

}  // namespace

SourceNode::SourceNode(hgros::Session& session, hgros::Transforms& transforms, ScanReader reader,
                       const SourceOptions& options, NodeParams<SourceTuning>& params, Ending& ending, Console& console)
    : reader_(std::move(reader)),
      options_(options),
      transforms_(transforms),
      ending_(ending),
      stop_(ending.token()),
      scans_(session.Advertise<msg::Scan>(kScan)),
      odometry_(session.Advertise<foxglove::PoseInFrame>(kOdometry)),
      rate_(params.Now().rate),
      published_clock_(session, clock_),
      rate_set_(params.server().OnChange(kTunedSource.prefix,
                                         [this, &params](const hgros::ParamEvent&) {
                                           const std::scoped_lock lock(mutex_);
                                           rate_ = params.Now().rate;
                                           changed_.notify_all();
                                         })),
      offered_(session, params.server(), kTunedSource.offered, console.log()) {
  const std::scoped_lock lock(mutex_);
  rate_ = params.Now().rate;  // It may have changed before the subscription.
}

void SourceNode::Start() {
  thread_ = std::jthread([this] {
    try {
      Run();
    } catch (const std::exception& error) {  // thrown by the reader
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
    AdvanceTo(TimeOf(scan.stamp_seconds));
    if (stop_.stop_requested()) return;
    auto message = std::make_unique<msg::Scan>();
    Write(scan, *message);
    if (!Send(std::move(message))) return;
    sent_.fetch_add(1, std::memory_order_relaxed);
    ShowOdometry(scan);
  }
  if (stop_.stop_requested()) return;
  clock_->Pause();
  auto end = std::make_unique<msg::Scan>();
  end->set_sequence(sent());
  end->set_end_of_log(true);
  (void)Send(std::move(end));  // If it fails, the ending has already been decided.
}

// For viewers only. A refused transform, such as one with a stamp long past, changes nothing in the graph.
void SourceNode::ShowOdometry(const LaserScan2& scan) {
  Show(odometry_, PoseMessage(scan.odometry, scan.stamp_seconds, kOdomFrame));
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

void SourceNode::AdvanceTo(hgros::Time stamp) {
  std::unique_lock lock(mutex_);
  if (sent() == 0) clock_->JumpTo(stamp);
  while (!stop_.stop_requested()) {
    const hgros::Duration left = stamp - clock_->Now();
    const double rate = rate_;
    if (rate == 0.0) {
      if (!clock_->paused()) clock_->Pause();
      if (left > hgros::Duration::zero()) clock_->Step(left);
      return;
    }
    if (rate != clock_->rate()) clock_->SetRate(rate);
    if (clock_->paused()) clock_->Resume();
    if (left <= hgros::Duration::zero()) return;
    const std::chrono::duration<double, std::nano> due(
        std::min(static_cast<double>(left.count()) / rate, kLongestWaitNs));
    changed_.wait_for(lock, stop_, std::chrono::ceil<std::chrono::nanoseconds>(due), [&] { return rate_ != rate; });
  }
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
