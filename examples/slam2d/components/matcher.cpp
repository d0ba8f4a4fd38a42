#include "matcher.hpp"

#include <chrono>
#include <stdexcept>
#include <string>
#include <utility>

#include "../app/channels.hpp"
#include "../app/fail.hpp"
#include "../app/frames.hpp"
#include "../app/pose_message.hpp"

namespace slam2d {
namespace {

constexpr std::chrono::seconds kSendAgainAfter{1};
constexpr int kWaitsBeforeItSays = 5;

}  // namespace

Matcher::Matcher(hgros::Context& context)
    : context_(context),
      transforms_(context.transforms()),
      matches_(context.Advertise<msg::MatchedScan>(kPreChannel)),
      trajectory_(context.Advertise<foxglove::PoseInFrame>(kTrajectory)),
      tuned_(context),
      matcher_(tuned_.Now(), MapOptions{}) {
  context.FromAny<msg::MapState>(
      kMapState, hgros::Invoke::kSerial,
      FailOnException<msg::MapState>(context, [this](const msg::MapState& message) { TakeState(message); }),
      {.name = {}, .queue = hgros::Queue::KeepAll(kLoopDepth), .executor = hgros::Executor::Inline()});
  context.FromAny<msg::MapUpdate>(
      kNextChannel, hgros::Invoke::kSerial,
      FailOnException<msg::MapUpdate>(context, [this](const msg::MapUpdate& message) { TakeMap(message); }),
      {.name = {}, .queue = hgros::Queue::KeepAll(kLoopDepth), .executor = hgros::Executor::Inline()});
  context.FromAny<msg::Scan>(
      kScan, hgros::Invoke::kSerial,
      FailOnException<msg::Scan>(context, [this](const msg::Scan& message) { TakeScan(message); }),
      {.name = {}, .queue = hgros::Queue::KeepAll(kScanDepth), .executor = hgros::Executor::Dedicated()});
  context.FromAny<msg::Done>(kDone, hgros::Invoke::kSerial, [this](const msg::Done&) { context_.Finish(); });
}

void Matcher::Deactivate() { stop_.request_stop(); }

// Its map comes with its first update, on the same channel as the others: between channels there is no order.
void Matcher::TakeState(const msg::MapState& /*message*/) {
  const std::scoped_lock lock(mutex_);
  begun_ = true;
  map_changed_.notify_all();
}

void Matcher::TakeMap(const msg::MapUpdate& message) {
  if (message.end_of_log()) return;
  const MapDelta delta = Read(message);
  const std::scoped_lock lock(mutex_);
  // It has been sent again. But one that is whole may be of another mapper, which goes on with an older map.
  const bool again = delta.version < updates_;
  if (again && !(message.whole() && delta.version + 1 == updates_)) return;
  if (delta.version > updates_) {
    throw std::runtime_error("The map after scan " + std::to_string(delta.version) +
                             " arrived, but the map after scan " + std::to_string(updates_) + " is next.");
  }
  if (message.whole()) {
    OccupancyMap map(Read(message.layout()));
    map.Apply(delta);
    matcher_.SetMap(map);
  } else {
    matcher_.Apply(delta);
  }
  if (!again) ++updates_;
  map_changed_.notify_all();
}

bool Matcher::WaitForMap(std::uint64_t scans) {
  std::unique_lock lock(mutex_);
  const auto ready = [&] { return begun_ && updates_ >= scans; };
  for (int waits = 1; !map_changed_.wait_for(lock, stop_.get_token(), kSendAgainAfter, ready); ++waits) {
    if (stop_.stop_requested()) return false;
    if (waits == kWaitsBeforeItSays) {
      std::string text = begun_ ? "It waits for the map after the last scan." : "It waits for a mapper.";
      text.append(" Does one run, and do the channels ").append(kPreChannel).append(", ").append(kNextChannel);
      text.append(" and ").append(kMapState).append(" pass between the two?");
      context_.log().Write(hgros::LogLevel::kWarning, text);
    }
    if (!begun_ || sent_ == nullptr) continue;
    lock.unlock();
    RequireOk(matches_(*sent_), "A matched scan");
    lock.lock();
  }
  return true;
}

void Matcher::TakeScan(const msg::Scan& message) {
  if (!WaitForMap(message.sequence())) return;
  auto matched = std::make_unique<msg::MatchedScan>();
  ScanMatch match;
  if (!message.end_of_log()) {
    const std::scoped_lock lock(mutex_);
    if (const auto options = tuned_.News()) matcher_.SetOptions(*options);
    match = matcher_.Match(Read(message));
    Write(match, *matched->mutable_match());
  }
  *matched->mutable_scan() = message;
  RequireOk(matches_(*matched), "A matched scan");
  sent_ = std::move(matched);
  if (!message.end_of_log()) ShowMatch(match, Read(message.odometry()));
}

void Matcher::ShowMatch(const ScanMatch& match, const Pose2& T_odom_laser) {
  Show(trajectory_, PoseMessage(match.T_map_laser, match.stamp_seconds, kMapFrame));
  (void)transforms_.ToTF(TimeOf(match.stamp_seconds), kMapFrame, kOdomFrame,
                         RigidOf(match.T_map_laser * Inverse(T_odom_laser)));
}

}  // namespace slam2d

HGROS_COMPONENT(slam2d::Matcher, "slam2d/Matcher")
