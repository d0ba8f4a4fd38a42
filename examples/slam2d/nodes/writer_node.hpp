#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <foxglove/Grid.pb.h>
#include <hgros/hgros.hpp>
#include <hgros/tf/transforms.hpp>

#include "../app/ending.hpp"
#include "../app/messages.hpp"
#include "../occupancy_map.hpp"
#include "../pose2.hpp"
#include "../scan_matcher.hpp"

namespace slam2d {

/// The files that the writer has written, and their contents in numbers.
struct Written {
  std::filesystem::path map_file;
  std::filesystem::path odometry_file;
  std::filesystem::path trajectory_file;
  std::uint64_t scans = 0;
  std::uint64_t map_hash = 0;
  std::uint64_t trajectory_hash = 0;
  double width_m = 0.0;
  double height_m = 0.0;
  double cell_size_m = 0.0;
  double seconds = 0.0;  ///< From the first update to the last.
  msg::LogTime log_time;
};

/// Follows `next_channel` with a replica of the map. Publishes it on `map` about once a second. At the end of the log
/// it writes the files and publishes `done`. A call of `save_map` makes it write them at any time.
///
/// Threading: thread-safe.
class WriterNode {
 public:
  static constexpr const char* kName = "writer";

  /// `folder` must exist.
  WriterNode(hgros::Session& session, hgros::Transforms& transforms, std::filesystem::path folder, Ending& ending);

  [[nodiscard]] std::uint64_t scans() const;
  [[nodiscard]] std::vector<ScanMatch> trajectory() const;
  /// Set once the files have been written at the end of the log.
  [[nodiscard]] std::optional<Written> written() const;
  /// Writes the current state: map.png with the corrected path, odometry.png with the path of odometry as well, and
  /// trajectory.tum. Throws std::runtime_error with a sentence.
  Written WriteFiles();

 private:
  void Take(const msg::MapUpdate& message);
  void ShowMap();
  [[nodiscard]] msg::MapSaved SaveMap();

  hgros::Transforms& transforms_;
  const std::filesystem::path folder_;
  Ending& ending_;
  hgros::Publisher<foxglove::Grid> maps_;
  hgros::Publisher<msg::Done> done_;

  mutable std::mutex mutex_;
  OccupancyMap map_;
  std::vector<ScanMatch> trajectory_;
  std::vector<Pose2> odometry_;
  std::optional<Written> written_;
  std::chrono::steady_clock::time_point first_;
  std::chrono::steady_clock::time_point latest_;
  std::chrono::steady_clock::time_point shown_;

  hgros::Subscription subscription_;
  hgros::Service save_map_;
};

}  // namespace slam2d
