#include "messages.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace slam2d {

void Write(const Pose2& pose, msg::Pose& message) {
  message.set_x(pose.x);
  message.set_y(pose.y);
  message.set_theta(pose.theta);
}

Pose2 Read(const msg::Pose& message) { return {message.x(), message.y(), message.theta()}; }

void Write(const LaserScan2& scan, msg::Scan& message) {
  message.set_sequence(scan.sequence);
  message.set_stamp_seconds(scan.stamp_seconds);
  message.set_start_angle_rad(scan.start_angle_rad);
  message.set_angle_step_rad(scan.angle_step_rad);
  message.set_max_range_m(scan.max_range_m);
  message.mutable_ranges_m()->Assign(scan.ranges_m.begin(), scan.ranges_m.end());
  Write(scan.odometry, *message.mutable_odometry());
}

LaserScan2 Read(const msg::Scan& message) {
  LaserScan2 scan;
  scan.sequence = message.sequence();
  scan.stamp_seconds = message.stamp_seconds();
  scan.start_angle_rad = message.start_angle_rad();
  scan.angle_step_rad = message.angle_step_rad();
  scan.max_range_m = message.max_range_m();
  scan.ranges_m.assign(message.ranges_m().begin(), message.ranges_m().end());
  scan.odometry = Read(message.odometry());
  return scan;
}

void Write(const ScanMatch& match, msg::Match& message) {
  message.set_sequence(match.sequence);
  message.set_stamp_seconds(match.stamp_seconds);
  Write(match.T_map_laser, *message.mutable_pose());
  message.set_score(match.score);
  message.set_drawable(match.drawable);
  message.mutable_covariance()->Assign(match.covariance.begin(), match.covariance.end());
}

ScanMatch Read(const msg::Match& message) {
  ScanMatch match;
  match.sequence = message.sequence();
  match.stamp_seconds = message.stamp_seconds();
  match.T_map_laser = Read(message.pose());
  match.score = message.score();
  match.drawable = message.drawable();
  if (static_cast<std::size_t>(message.covariance_size()) != match.covariance.size()) {
    throw std::invalid_argument("The covariance of a match does not have six numbers.");
  }
  std::ranges::copy(message.covariance(), match.covariance.begin());
  return match;
}

void Write(const MapDelta& delta, msg::MapUpdate& message) {
  message.set_version(delta.version);
  for (const MapDelta::TileChanges& change : delta.tiles) {
    message.add_tile_x(change.tile.x);
    message.add_tile_y(change.tile.y);
    message.add_tile_count(change.count);
  }
  message.mutable_cells()->Assign(delta.cells.begin(), delta.cells.end());
  message.mutable_values()->resize(delta.values.size());
  if (!delta.values.empty()) std::memcpy(message.mutable_values()->data(), delta.values.data(), delta.values.size());
}

void Write(const MapOptions& options, msg::MapLayout& message) {
  message.set_cell_size_m(options.cell_size_m);
  message.set_min_value(options.min_value);
  message.set_max_value(options.max_value);
}

MapOptions Read(const msg::MapLayout& message) {
  MapOptions options;
  options.cell_size_m = message.cell_size_m();
  options.min_value = message.min_value();
  options.max_value = message.max_value();
  if (!(options.cell_size_m >= 0.001) || options.min_value >= 0 || options.max_value <= 0) {
    throw std::invalid_argument("The layout of a map has an invalid cell size or value range.");
  }
  return options;
}

MapDelta Read(const msg::MapUpdate& message) {
  if (message.tile_x_size() != message.tile_y_size() || message.tile_x_size() != message.tile_count_size()) {
    throw std::invalid_argument("A map update does not have one place and one count for each tile.");
  }
  MapDelta delta;
  delta.version = message.version();
  std::uint32_t first = 0;
  for (int i = 0; i < message.tile_x_size(); ++i) {
    delta.tiles.push_back({{message.tile_x(i), message.tile_y(i)}, first, message.tile_count(i)});
    first += message.tile_count(i);
  }
  delta.cells.reserve(static_cast<std::size_t>(message.cells_size()));
  for (const std::uint32_t cell : message.cells()) {
    if (cell > std::numeric_limits<std::uint16_t>::max()) {
      throw std::invalid_argument("A map update has a cell outside its tile.");
    }
    delta.cells.push_back(static_cast<std::uint16_t>(cell));
  }
  delta.values.resize(message.values().size());
  if (!delta.values.empty()) std::memcpy(delta.values.data(), message.values().data(), delta.values.size());
  return delta;
}

}  // namespace slam2d
