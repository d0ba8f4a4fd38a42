#include "slam_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace hgros::bench::slam_run {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kHalfLength = 32;  // of the yard, meters
constexpr double kHalfWidth = 22;
constexpr std::size_t kRings = 40;
constexpr double kLowest = -28 * kPi / 180;  // of the rings
constexpr double kHighest = 2 * kPi / 180;

struct Pillar {
  double x;
  double y;
  double radius;
  float tone;
};

// On two ovals, inside and outside of the path.
const std::array<Pillar, 30>& Pillars() {
  static const auto pillars = [] {
    std::array<Pillar, 30> made{};
    for (std::size_t i = 0; i < made.size(); ++i) {
      const double angle = 2 * kPi * (static_cast<double>(i) + 0.3) / static_cast<double>(made.size());
      const double scale = i % 2 == 0 ? 1.25 : 0.6;
      made[i] = {scale * 21 * std::cos(angle), scale * 14 * std::sin(angle), 0.4 + 0.1 * static_cast<double>(i % 7),
                 static_cast<float>(30 + 2 * i)};
    }
    return made;
  }();
  return pillars;
}

struct Hit {
  double range;
  float tone;
};

// The hit along a level ray.
Hit Nearest(double x, double y, double angle) {
  const double dx = std::cos(angle);
  const double dy = std::sin(angle);
  Hit hit{1e9, 0};
  if (dx != 0) hit = {((dx > 0 ? kHalfLength : -kHalfLength) - x) / dx, 95};
  const double across = dy != 0 ? ((dy > 0 ? kHalfWidth : -kHalfWidth) - y) / dy : 1e9;
  if (across < hit.range) hit = {across, 80};
  for (const Pillar& pillar : Pillars()) {
    const double to_x = pillar.x - x;
    const double to_y = pillar.y - y;
    const double along = to_x * dx + to_y * dy;
    const double beside = to_x * dy - to_y * dx;
    const double half = pillar.radius * pillar.radius - beside * beside;
    if (along <= 0 || half <= 0) continue;
    const double range = along - std::sqrt(half);
    if (range > 0 && range < hit.range) hit = {range, pillar.tone};
  }
  return hit;
}

}  // namespace

Pose PoseAt(double seconds) {
  const auto at = [](double s) {
    const double angle = s / 18;
    const double weave = 1 + 0.05 * std::sin(6 * angle);
    return std::array<double, 2>{21 * weave * std::cos(angle), 14 * weave * std::sin(angle)};
  };
  const auto here = at(seconds);
  const auto next = at(seconds + 0.01);
  return {here[0], here[1], 0.3, std::atan2(next[1] - here[1], next[0] - here[0])};
}

std::vector<float> ScanFrom(const Pose& base, std::size_t points, std::size_t turn) {
  std::minstd_rand random(static_cast<unsigned>(turn + 1));
  std::uniform_real_distribution<double> unit(0, 1);
  const double x = base.x + kLidar.x * std::cos(base.yaw);
  const double y = base.y + kLidar.x * std::sin(base.yaw);
  const double height = base.z + kLidar.z;
  const std::size_t columns = points / kRings;
  std::vector<float> scan;
  scan.reserve(4 * kRings * columns);
  for (std::size_t column = 0; column < columns; ++column) {
    const double azimuth = 2 * kPi * (static_cast<double>(column) + unit(random)) / static_cast<double>(columns);
    const Hit hit = Nearest(x, y, base.yaw + azimuth);
    for (std::size_t ring = 0; ring < kRings; ++ring) {
      const double slope =
          std::tan(kLowest + (kHighest - kLowest) * static_cast<double>(ring) / static_cast<double>(kRings - 1));
      const double to_ground = slope < 0 ? -height / slope : 1e9;
      const double range = std::min(hit.range, to_ground) + 0.03 * (unit(random) - 0.5);
      scan.push_back(static_cast<float>(range * std::cos(azimuth)));
      scan.push_back(static_cast<float>(range * std::sin(azimuth)));
      scan.push_back(static_cast<float>(range * slope));
      scan.push_back(to_ground < hit.range ? 15.0F : hit.tone);
    }
  }
  return scan;
}

}  // namespace hgros::bench::slam_run
