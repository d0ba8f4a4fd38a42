#include "source.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "../app/channels.hpp"
#include "../app/fail.hpp"
#include "../app/frames.hpp"
#include "../app/pose_message.hpp"
#include "../carmen_log.hpp"
#include "../simulated_building.hpp"

namespace slam2d {
namespace {

constexpr double kLongestWaitNs = 3.6e12;
constexpr int kSimulatedScans = 1500;

ScanReader OpenSource(hgros::Context& context) {
  const auto log =
      context.Declare("log", "",
                      {.description = "CARMEN log to play, plain or gzip; empty: a drive through a simulated building",
                       .read_only = true});
  const int scans = context.Declare("scans", 0,
                                    {.description = "stop after this number of scans; 0: the whole log, or " +
                                                    std::to_string(kSimulatedScans) + " simulated ones",
                                     .least = 0,
                                     .most = 999'999'999,
                                     .read_only = true});
  if (log.empty()) {
    SimulationOptions simulation;
    simulation.scans = static_cast<std::size_t>(scans == 0 ? kSimulatedScans : scans);
    return
        [building = std::make_shared<SimulatedBuilding>(simulation)](LaserScan2& scan) { return building->Next(scan); };
  }
  return [reader = std::make_shared<CarmenLogReader>(log), left = scans == 0 ? -1 : scans](LaserScan2& scan) mutable {
    if (left == 0) return false;
    --left;
    std::optional<LaserScan2> next = reader->Next();
    if (next) scan = std::move(*next);
    return next.has_value();
  };
}

}  // namespace

Source::Source(hgros::Context& context)
    : context_(context),
      reader_(OpenSource(context)),
      transforms_(context.transforms()),
      scans_(context.Advertise<msg::Scan>(kScan)),
      odometry_(context.Advertise<foxglove::PoseInFrame>(kOdometry)),
      published_clock_(context.PublishClock(clock_)),
      rate_(context.Declare(
          "rate", 0.0,
          {.description = "times real time, by the log's stamps; 0: as fast as possible", .least = 0, .most = 1e6})),
      rate_set_(context.params().OnChange("rate", [this](const hgros::ParamEvent& event) {
        const std::scoped_lock lock(mutex_);
        rate_ = event.after.Get<double>("rate");
        changed_.notify_all();
      })) {
  context.FromAny<msg::Done>(kDone, hgros::Invoke::kSerial, [this](const msg::Done&) { context_.Finish(); });
}

void Source::Activate() {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void Source::Deactivate() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void Source::Run(const std::stop_token& stop) {
  try {
    Play(stop);
  } catch (const std::exception& error) {
    if (!stop.stop_requested()) context_.Fail(error.what());
  }
}

void Source::Play(const std::stop_token& stop) {
  (void)transforms_.ToStaticTF(kBaseFrame, kLaserFrame, RigidOf(kBaseLaser));
  LaserScan2 scan;
  while (!stop.stop_requested() && reader_(scan)) {
    AdvanceTo(TimeOf(scan.stamp_seconds), stop);
    if (stop.stop_requested()) return;
    auto message = std::make_unique<msg::Scan>();
    Write(scan, *message);
    Send(std::move(message), stop);
    ++sent_;
    ShowOdometry(scan);
  }
  if (stop.stop_requested()) return;
  clock_->Pause();
  auto end = std::make_unique<msg::Scan>();
  end->set_sequence(sent_);
  end->set_end_of_log(true);
  Send(std::move(end), stop);
}

// For viewers only. A refused transform, such as one with a stamp long past, changes nothing in the graph.
void Source::ShowOdometry(const LaserScan2& scan) {
  Show(odometry_, PoseMessage(scan.odometry, scan.stamp_seconds, kOdomFrame));
  const Pose2 T_odom_base = scan.odometry * Inverse(kBaseLaser);
  (void)transforms_.ToTF(TimeOf(scan.stamp_seconds), kOdomFrame, kBaseFrame, RigidOf(T_odom_base));
}

void Source::Send(std::unique_ptr<msg::Scan> message, const std::stop_token& stop) {
  RequireOk(scans_.Wait(std::move(message), std::chrono::steady_clock::time_point::max(), stop), "A scan");
}

void Source::AdvanceTo(hgros::Time stamp, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (sent_ == 0) clock_->JumpTo(stamp);
  while (!stop.stop_requested()) {
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
    changed_.wait_for(lock, stop, std::chrono::ceil<std::chrono::nanoseconds>(due), [&] { return rate_ != rate; });
  }
}

}  // namespace slam2d

HGROS_COMPONENT(slam2d::Source, "slam2d/Source")
