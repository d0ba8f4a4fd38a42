#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include <foxglove/Grid.pb.h>
#include <hgros/component/component.hpp>
#include <hgros/tf/transforms.hpp>

#include "../app/messages.hpp"
#include "../occupancy_map.hpp"
#include "../pose2.hpp"
#include "../relations_error.hpp"
#include "../scan_matcher.hpp"
#include "written.hpp"

namespace slam2d {

/// Follows `next_channel` with a replica of the map. Publishes it on `map` about once a second, and tells how far it
/// is. At the end of the log, and if it is ended before, it writes the files and reports them; at the end of the log it
/// also publishes `done`. A call of `save_map` makes it write them at any time.
class Writer {
 public:
  explicit Writer(hgros::Context& context);

  void Deactivate();

 private:
  void Take(const msg::MapUpdate& message);
  void TakeEnd();
  void ShowMap();
  void ShowProgress();
  [[nodiscard]] msg::MapSaved SaveMap();
  /// Writes the current state: map.png with the corrected path, odometry.png with the path of odometry as well, and
  /// trajectory.tum. Throws std::runtime_error with a sentence.
  [[nodiscard]] Written WriteFiles();
  void Report(const Written& written);

  hgros::Context& context_;
  hgros::Transforms& transforms_;
  const std::filesystem::path folder_;
  const std::vector<Relation> relations_;
  hgros::Publisher<foxglove::Grid> maps_;
  hgros::Publisher<msg::Done> done_;

  std::mutex mutex_;
  OccupancyMap map_;
  std::vector<ScanMatch> trajectory_;
  std::vector<Pose2> odometry_;
  bool finished_ = false;
  std::chrono::steady_clock::time_point first_;
  std::chrono::steady_clock::time_point latest_;
  std::chrono::steady_clock::time_point shown_;
  std::chrono::steady_clock::time_point told_;
  std::size_t told_scans_ = 0;
};

}  // namespace slam2d
