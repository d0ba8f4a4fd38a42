#include "viewer/data/points/scan_reader.hpp"

#include <cmath>
#include <cstddef>

#include "hgros/tf/transform_cloud.hpp"
#include "viewer/data/points/far_points.hpp"
#include "viewer/data/stamp.hpp"

namespace hgros::viewer {

std::string ReadScan(const foxglove::LaserScan& scan, PointBatch& batch) {
  const auto count = static_cast<std::size_t>(scan.ranges_size());
  const auto intensities = static_cast<std::size_t>(scan.intensities_size());
  if (intensities != 0 && intensities != count) {
    return "The scan has " + std::to_string(count) + " ranges but " + std::to_string(intensities) + " intensities.";
  }
  if (!std::isfinite(scan.start_angle()) || !std::isfinite(scan.end_angle())) {
    return "The scan's angles are not finite numbers.";
  }
  PointBatch read;
  read.frame = scan.frame_id();
  read.stamp = StampOf(scan.timestamp());
  read.T_frame_points = tf::PoseIn(scan);
  read.fields = intensities != 0 ? std::vector<std::string>{"intensity", "range"} : std::vector<std::string>{"range"};
  read.scalar_name = read.fields.front();
  read.positions.reserve(count);
  read.scalars.reserve(count);
  const double step = count > 1 ? (scan.end_angle() - scan.start_angle()) / static_cast<double>(count - 1) : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double range = scan.ranges(static_cast<int>(i));
    if (!std::isfinite(range) || range <= 0) {
      ++read.left_out;
      continue;
    }
    const double angle = scan.start_angle() + static_cast<double>(i) * step;
    read.positions.emplace_back(static_cast<float>(range * std::cos(angle)),
                                static_cast<float>(range * std::sin(angle)), 0.0F);
    read.scalars.push_back(static_cast<float>(intensities != 0 ? scan.intensities(static_cast<int>(i)) : range));
  }
  LeaveOutFar(read);
  batch = std::move(read);
  return {};
}

}  // namespace hgros::viewer
