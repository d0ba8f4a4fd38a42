#include "mapper.hpp"

#include <cmath>

namespace slam2d {

MapDelta Mapper::Add(const LaserScan2& scan, const ScanMatch& match) {
  if (T_map_drawn_) {
    const Pose2 motion = Inverse(*T_map_drawn_) * match.T_map_laser;
    const bool still =
        Distance(motion) < map_.options().min_translation_m && std::abs(motion.theta) < map_.options().min_rotation_rad;
    if (still || !match.drawable) return map_.Skip(scan.sequence);
  }
  T_map_drawn_ = match.T_map_laser;
  return map_.Integrate(scan, match.T_map_laser);
}

}  // namespace slam2d
