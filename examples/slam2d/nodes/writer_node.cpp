#include "writer_node.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "../app/channels.hpp"
#include "../app/frames.hpp"
#include "../app/pose_message.hpp"
#include "../map_image.hpp"
#include "../pipeline.hpp"
#include "../trajectory_file.hpp"

namespace slam2d {
namespace {

// Wall clock time, so that a fast replay does not publish more often.
constexpr std::chrono::seconds kShowEvery{1};

// -1: unknown. Otherwise the probability that the cell is occupied, in percent.
char Percent(std::int8_t value, const MapOptions& options) {
  if (value == 0) return -1;
  return static_cast<char>(100 * (value - options.min_value) / (options.max_value - options.min_value));
}

std::unique_ptr<foxglove::Grid> GridMessage(const OccupancyMap& map, double stamp_seconds) {
  int min_x = std::numeric_limits<int>::max();
  int min_y = min_x;
  int max_x = std::numeric_limits<int>::min();
  int max_y = max_x;
  for (const auto& [index, tile] : map.tiles()) {
    min_x = std::min(min_x, index.x);
    min_y = std::min(min_y, index.y);
    max_x = std::max(max_x, index.x);
    max_y = std::max(max_y, index.y);
  }
  const auto columns = static_cast<std::size_t>(max_x - min_x + 1) * kTileEdgeCells;
  const auto rows = static_cast<std::size_t>(max_y - min_y + 1) * kTileEdgeCells;
  std::string cells(columns * rows, -1);
  for (const auto& [index, tile] : map.tiles()) {
    const auto left = static_cast<std::size_t>(index.x - min_x) * kTileEdgeCells;
    const auto bottom = static_cast<std::size_t>(index.y - min_y) * kTileEdgeCells;
    for (std::size_t cell = 0; cell < tile.size(); ++cell) {
      cells[(bottom + cell / kTileEdgeCells) * columns + left + cell % kTileEdgeCells] =
          Percent(tile[cell], map.options());
    }
  }

  const double cell_size = map.options().cell_size_m;
  auto grid = std::make_unique<foxglove::Grid>();
  const auto corner = PoseMessage({min_x * kTileEdgeCells * cell_size, min_y * kTileEdgeCells * cell_size, 0.0},
                                  stamp_seconds, kMapFrame);
  *grid->mutable_timestamp() = corner->timestamp();
  grid->set_frame_id(corner->frame_id());
  *grid->mutable_pose() = corner->pose();
  grid->set_column_count(static_cast<std::uint32_t>(columns));
  grid->mutable_cell_size()->set_x(cell_size);
  grid->mutable_cell_size()->set_y(cell_size);
  grid->set_row_stride(static_cast<std::uint32_t>(columns));
  grid->set_cell_stride(1);
  foxglove::PackedElementField& field = *grid->add_fields();
  field.set_name("occupancy");
  field.set_type(foxglove::PackedElementField::INT8);
  grid->set_data(std::move(cells));
  return grid;
}

}  // namespace

WriterNode::WriterNode(hgros::Session& session, hgros::Transforms& transforms, std::filesystem::path folder,
                       Ending& ending)
    : transforms_(transforms),
      folder_(std::move(folder)),
      ending_(ending),
      maps_(session.Advertise<foxglove::Grid>(kMap, {.latched = 1})),
      done_(session.Advertise<msg::Done>(kDone, {.latched = 1})),
      subscription_(session.FromAny<msg::MapUpdate>(
          kNextChannel, hgros::Invoke::kSerial,
          [this](const msg::MapUpdate& message) { ending_.Guard("writer", [&] { Take(message); }); },
          {.name = kName, .queue = hgros::Queue::KeepAll(kLoopDepth), .executor = {}})),
      save_map_(
          session.Serve<msg::SaveMap, msg::MapSaved>(kSaveMap, [this](const msg::SaveMap&) { return SaveMap(); })) {
  (void)transforms_.tree();  // From now on the tree follows the robot.
}

void WriterNode::Take(const msg::MapUpdate& message) {
  if (!message.end_of_log()) {
    const std::scoped_lock lock(mutex_);
    if (message.version() != trajectory_.size()) {
      throw std::runtime_error("the map after scan " + std::to_string(message.version()) +
                               " arrived, but the map after scan " + std::to_string(trajectory_.size()) + " is next.");
    }
    latest_ = std::chrono::steady_clock::now();
    if (trajectory_.empty()) first_ = shown_ = latest_;
    if (message.has_layout()) map_ = OccupancyMap(Read(message.layout()));
    map_.Apply(Read(message));
    trajectory_.push_back(Read(message.match()));
    odometry_.push_back(Read(message.odometry()));
    if (latest_ - shown_ < kShowEvery) return;
    shown_ = latest_;
    ShowMap();
    return;
  }
  msg::Done done;
  try {
    const Written written = WriteFiles();
    done.set_scans(written.scans);
    *done.mutable_log_time() = written.log_time;
    done.set_map_hash(written.map_hash);
    done.set_trajectory_hash(written.trajectory_hash);
    const std::scoped_lock lock(mutex_);
    written_ = written;
    ShowMap();
  } catch (const std::exception& error) {
    done.set_error(error.what());
  }
  if (const hgros::PublishStatus status = done_(std::make_unique<msg::Done>(done));
      status != hgros::PublishStatus::kOk) {
    throw std::runtime_error("the end could not be published: " + std::string(hgros::ToString(status)) + ".");
  }
}

msg::MapSaved WriterNode::SaveMap() {
  if (scans() == 0) throw std::runtime_error("there is no map yet: no scan has been drawn.");
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

void WriterNode::ShowMap() {
  if (!trajectory_.empty()) Show(maps_, GridMessage(map_, trajectory_.back().stamp_seconds));
}

std::uint64_t WriterNode::scans() const {
  const std::scoped_lock lock(mutex_);
  return trajectory_.size();
}

std::vector<ScanMatch> WriterNode::trajectory() const {
  const std::scoped_lock lock(mutex_);
  return trajectory_;
}

std::optional<Written> WriterNode::written() const {
  const std::scoped_lock lock(mutex_);
  return written_;
}

Written WriterNode::WriteFiles() {
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
  return written;
}

}  // namespace slam2d
