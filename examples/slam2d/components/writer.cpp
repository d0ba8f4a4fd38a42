#include "writer.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <utility>

#include "../app/channels.hpp"
#include "../app/fail.hpp"
#include "../app/frames.hpp"
#include "../app/map_message.hpp"
#include "../app/pose_message.hpp"
#include "../map_image.hpp"
#include "../pipeline.hpp"
#include "../trajectory_file.hpp"

namespace slam2d {
namespace {

// Wall clock time, so that a fast replay does not publish more often.
constexpr std::chrono::seconds kShowEvery{1};
constexpr std::chrono::seconds kTellEvery{5};

std::vector<Relation> OpenRelations(hgros::Context& context) {
  const auto file = context.Declare(
      "relations", std::string(),
      {.description = "file of verified relative poses to compare with; empty: none", .read_only = true});
  return file.empty() ? std::vector<Relation>() : ReadRelations(file);
}

}  // namespace

Writer::Writer(hgros::Context& context)
    : context_(context),
      transforms_(context.transforms()),
      folder_(context.Declare("out", "slam2d_out",
                              {.description = "folder for the files; made if it does not exist", .read_only = true})),
      relations_(OpenRelations(context)),
      maps_(context.Advertise<foxglove::Grid>(kMap, {.latched = 1})),
      done_(context.Advertise<msg::Done>(kDone, {.latched = 1})) {
  context.FromAny<msg::MapUpdate>(
      kNextChannel, hgros::Invoke::kSerial,
      FailOnException<msg::MapUpdate>(context, [this](const msg::MapUpdate& message) { Take(message); }),
      {.name = {}, .queue = hgros::Queue::KeepAll(kLoopDepth), .executor = {}});
  context.Serve<msg::SaveMap, msg::MapSaved>(kSaveMap, [this](const msg::SaveMap&) { return SaveMap(); });
  (void)transforms_.tree();  // From now on the tree follows the robot.
}

void Writer::Deactivate() {
  {
    const std::scoped_lock lock(mutex_);
    if (std::exchange(finished_, true) || trajectory_.empty()) return;
  }
  context_.log().Write(hgros::LogLevel::kInfo, "The robot ends before the log does. This is the map so far:");
  Report(WriteFiles());
}

void Writer::Take(const msg::MapUpdate& message) {
  if (message.end_of_log()) return TakeEnd();
  const std::scoped_lock lock(mutex_);
  latest_ = std::chrono::steady_clock::now();
  if (trajectory_.empty()) {
    first_ = shown_ = told_ = latest_;
  } else if (message.version() < map_.version() || (message.version() == map_.version() && !message.whole())) {
    return;  // It has been sent again.
  }
  if (message.whole()) map_ = OccupancyMap(Read(message.layout()));
  map_.Apply(Read(message));
  if (!trajectory_.empty() && message.version() <= trajectory_.back().sequence) return;  // Drawn again.
  trajectory_.push_back(Read(message.match()));
  odometry_.push_back(Read(message.odometry()));
  if (latest_ - told_ >= kTellEvery) ShowProgress();
  if (latest_ - shown_ < kShowEvery) return;
  shown_ = latest_;
  ShowMap();
}

void Writer::TakeEnd() {
  {
    const std::scoped_lock lock(mutex_);
    if (std::exchange(finished_, true)) return;
  }
  const Written written = WriteFiles();
  Report(written);
  {
    const std::scoped_lock lock(mutex_);
    ShowMap();
  }
  msg::Done done;
  done.set_scans(written.scans);
  done.set_map_hash(written.map_hash);
  done.set_trajectory_hash(written.trajectory_hash);
  RequireOk(done_(done), "The end");
  context_.Finish(std::to_string(written.scans) + " scans are in the map.");
}

msg::MapSaved Writer::SaveMap() {
  {
    const std::scoped_lock lock(mutex_);
    if (trajectory_.empty()) throw std::runtime_error("There is no map yet: no scan has been drawn.");
  }
  const Written written = WriteFiles();
  msg::MapSaved saved;
  saved.set_scans(written.scans);
  *saved.mutable_log_time() = written.log_time;
  saved.set_map_hash(written.map_hash);
  saved.set_map_file(std::filesystem::absolute(written.map_file).string());
  saved.set_trajectory_file(std::filesystem::absolute(written.trajectory_file).string());
  if (const auto T_map_laser = transforms_.FromTF(kMapFrame, kLaserFrame)) {
    Write(PlanarOf(T_map_laser->T_target_source), *saved.mutable_robot());
  }
  return saved;
}

void Writer::ShowMap() {
  if (!trajectory_.empty()) Show(maps_, GridMessage(map_, trajectory_.back().stamp_seconds));
}

void Writer::ShowProgress() {
  const double seconds = std::chrono::duration<double>(latest_ - std::exchange(told_, latest_)).count();
  const std::size_t scans = trajectory_.size() - std::exchange(told_scans_, trajectory_.size());
  char text[128];
  std::snprintf(text, sizeof text, "scan %zu, %.0f scans/s, log time %.1f s", trajectory_.size(),
                static_cast<double>(scans) / seconds, trajectory_.back().stamp_seconds);
  context_.log().Write(hgros::LogLevel::kInfo, text);
}

void Writer::Report(const Written& written) {
  for (const std::string& line : LinesOf(written)) context_.log().Write(hgros::LogLevel::kInfo, line);
}

Written Writer::WriteFiles() {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) {
    throw std::runtime_error("The folder " + folder_.string() + " cannot be created: " + error.message() + ".");
  }
  const std::scoped_lock lock(mutex_);
  PathOverlay corrected{{}, kCorrectedRgb};
  for (const ScanMatch& match : trajectory_) corrected.T_map_laser.push_back(match.T_map_laser);
  const PathOverlay both[] = {{odometry_, kOdometryRgb}, corrected};

  Written written;
  written.map_file = folder_ / "map.png";
  written.odometry_file = folder_ / "odometry.png";
  written.trajectory_file = folder_ / "trajectory.tum";
  const double cell_size = map_.options().cell_size_m;
  const MapImage extent = RenderMap(map_);
  written.width_m = extent.width * cell_size;
  written.height_m = extent.height * cell_size;
  written.cell_size_m = cell_size;
  WritePng(RenderMap(map_, {&corrected, 1}, kScreenEdgePixels), written.map_file);
  WritePng(RenderMap(map_, both, kScreenEdgePixels), written.odometry_file);
  WriteTrajectory(trajectory_, written.trajectory_file);
  written.scans = trajectory_.size();
  written.map_hash = HashMap(map_);
  written.trajectory_hash = HashTrajectory(trajectory_);
  if (!trajectory_.empty()) {
    const auto [first, last] = std::ranges::minmax(trajectory_, {}, &ScanMatch::stamp_seconds);
    written.log_time.set_first_seconds(first.stamp_seconds);
    written.log_time.set_last_seconds(last.stamp_seconds);
  }
  written.seconds = std::chrono::duration<double>(latest_ - first_).count();
  if (!relations_.empty()) written.relations = CompareWithRelations(trajectory_, relations_);
  return written;
}

}  // namespace slam2d

HGROS_COMPONENT(slam2d::Writer, "slam2d/Writer")
