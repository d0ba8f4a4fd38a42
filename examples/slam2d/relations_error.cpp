#include "relations_error.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>

namespace slam2d {
namespace {

using PoseByStamp = std::map<double, Pose2>;

std::optional<Pose2> Nearest(const PoseByStamp& poses, double stamp, double tolerance) {
  auto best = poses.lower_bound(stamp);
  if (best != poses.begin() && (best == poses.end() || stamp - std::prev(best)->first < best->first - stamp)) --best;
  if (best == poses.end() || std::abs(best->first - stamp) > tolerance) return std::nullopt;
  return best->second;
}

}  // namespace

std::vector<Relation> ReadRelations(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) {
    throw std::runtime_error("The relations " + path.string() + " cannot be opened: " + std::strerror(errno) +
                             ". Name a file with one relation per line.");
  }
  std::vector<Relation> relations;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    Relation r;
    double z = 0.0;
    double roll = 0.0;
    double pitch = 0.0;
    if (!(words >> r.stamp_1_seconds >> r.stamp_2_seconds >> r.T_1_2.x >> r.T_1_2.y >> z >> roll >> pitch >>
          r.T_1_2.theta)) {
      throw std::runtime_error(path.string() + ":" + std::to_string(number) +
                               ": a relation needs eight numbers, stamp1 stamp2 x y z roll pitch yaw.");
    }
    relations.push_back(r);
  }
  return relations;
}

RelationsError CompareWithRelations(std::span<const ScanMatch> trajectory, std::span<const Relation> relations,
                                    double tolerance_seconds) {
  PoseByStamp poses;
  for (const ScanMatch& match : trajectory) poses.emplace(match.stamp_seconds, match.T_map_laser);
  RelationsError error;
  double translation2 = 0.0;
  double rotation2 = 0.0;
  for (const Relation& relation : relations) {
    const auto T_map_1 = Nearest(poses, relation.stamp_1_seconds, tolerance_seconds);
    const auto T_map_2 = Nearest(poses, relation.stamp_2_seconds, tolerance_seconds);
    if (!T_map_1 || !T_map_2) {
      ++error.unmatched;
      continue;
    }
    const Pose2 off = Inverse(relation.T_1_2) * (Inverse(*T_map_1) * *T_map_2);
    const double translation = Distance(off);
    const double rotation = std::abs(off.theta);
    ++error.relations;
    error.mean_translation_m += translation;
    error.mean_rotation_rad += rotation;
    error.max_translation_m = std::max(error.max_translation_m, translation);
    translation2 += translation * translation;
    rotation2 += rotation * rotation;
  }
  if (error.relations == 0) return error;
  const auto n = static_cast<double>(error.relations);
  error.mean_translation_m /= n;
  error.mean_rotation_rad /= n;
  const double mean_t = error.mean_translation_m;
  const double mean_r = error.mean_rotation_rad;
  error.std_translation_m = std::sqrt(std::max(0.0, translation2 / n - mean_t * mean_t));
  error.std_rotation_rad = std::sqrt(std::max(0.0, rotation2 / n - mean_r * mean_r));
  return error;
}

}  // namespace slam2d
