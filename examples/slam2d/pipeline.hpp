#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "laser_scan.hpp"
#include "mapper.hpp"
#include "occupancy_map.hpp"
#include "scan_matcher.hpp"

namespace slam2d {

/// 64-bit FNV-1a over the map's version and its tiles with their indices and values, in ascending order
/// (http://www.isthe.com/chongo/tech/comp/fnv/). Equal maps have equal hashes on every machine.
[[nodiscard]] std::uint64_t HashMap(const OccupancyMap& map);

/// Likewise over the bits of sequence, stamp and pose of every match. Equal only if libm and the compiler round the
/// same way.
[[nodiscard]] std::uint64_t HashTrajectory(std::span<const ScanMatch> trajectory);

/// The whole front end in one thread: matcher, mapper, and the delta back to the matcher, scan by scan. The same parts
/// in several processes must produce the same map and trajectory.
class Pipeline {
 public:
  explicit Pipeline(const MatcherOptions& matcher_options = {}, const MapOptions& map_options = {})
      : matcher_(matcher_options, map_options), mapper_(map_options) {}

  /// Processes the next scan and returns its match.
  const ScanMatch& Add(const LaserScan2& scan);

  [[nodiscard]] const OccupancyMap& map() const { return mapper_.map(); }
  [[nodiscard]] const ScanMatcher& matcher() const { return matcher_; }
  [[nodiscard]] const std::vector<ScanMatch>& trajectory() const { return trajectory_; }

 private:
  ScanMatcher matcher_;
  Mapper mapper_;
  std::vector<ScanMatch> trajectory_;
};

}  // namespace slam2d
