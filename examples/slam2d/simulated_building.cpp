#include "simulated_building.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>

namespace slam2d {
namespace {

constexpr double kDoor_m = 1.1;

void AddWall(Point2 a, Point2 b, std::vector<Wall>& walls) { walls.push_back({a, b}); }

void AddBox(double x, double y, double width, double height, std::vector<Wall>& walls) {
  AddWall({x, y}, {x + width, y}, walls);
  AddWall({x + width, y}, {x + width, y + height}, walls);
  AddWall({x + width, y + height}, {x, y + height}, walls);
  AddWall({x, y + height}, {x, y}, walls);
}

// A wall along x with door openings that begin at `doors`, ascending.
void AddRow(double y, double from_x, double to_x, std::initializer_list<double> doors, std::vector<Wall>& walls) {
  for (const double door : doors) {
    AddWall({from_x, y}, {door, y}, walls);
    from_x = door + kDoor_m;
  }
  AddWall({from_x, y}, {to_x, y}, walls);
}

void AddColumn(double x, double from_y, double to_y, std::initializer_list<double> doors, std::vector<Wall>& walls) {
  for (const double door : doors) {
    AddWall({x, from_y}, {x, door}, walls);
    from_y = door + kDoor_m;
  }
  AddWall({x, from_y}, {x, to_y}, walls);
}

// Outer walls; offices 3 m deep along the south and north; the ring of corridors around a core of two rooms.
std::vector<Wall> BuildWalls() {
  std::vector<Wall> walls;
  AddBox(0.0, 0.0, 20.0, 14.0, walls);
  AddRow(3.0, 0.0, 20.0, {1.6, 6.2, 11.7, 16.9}, walls);
  AddRow(11.0, 0.0, 20.0, {2.4, 8.1, 13.2, 17.6}, walls);
  for (const double x : {4.6, 9.8, 15.1}) AddColumn(x, 0.0, 3.0, {}, walls);
  for (const double x : {5.5, 10.4, 15.9}) AddColumn(x, 11.0, 14.0, {}, walls);
  AddRow(4.9, 2.2, 17.7, {7.4}, walls);
  AddRow(9.1, 2.2, 17.7, {13.0}, walls);
  AddColumn(2.2, 4.9, 9.1, {6.3}, walls);
  AddColumn(17.7, 4.9, 9.1, {}, walls);
  AddColumn(10.9, 4.9, 9.1, {}, walls);
  // Desks, shelves and columns. The corridors are not quite straight either.
  AddBox(0.4, 0.3, 1.6, 0.7, walls);
  AddBox(3.4, 1.6, 0.9, 1.2, walls);
  AddBox(5.2, 0.4, 1.8, 0.8, walls);
  AddBox(8.8, 0.2, 0.8, 1.9, walls);
  AddBox(10.3, 0.5, 0.8, 1.4, walls);
  AddBox(13.5, 0.3, 1.4, 0.8, walls);
  AddBox(18.6, 0.4, 0.9, 1.7, walls);
  AddBox(0.3, 12.7, 1.5, 0.9, walls);
  AddBox(4.3, 11.9, 0.7, 1.3, walls);
  AddBox(6.1, 12.9, 1.7, 0.8, walls);
  AddBox(11.2, 12.6, 1.5, 0.8, walls);
  AddBox(16.5, 12.8, 1.9, 0.7, walls);
  AddBox(3.4, 5.6, 1.4, 0.8, walls);
  AddBox(8.9, 7.4, 1.2, 0.9, walls);
  AddBox(12.3, 5.7, 0.9, 1.6, walls);
  AddBox(15.4, 6.6, 1.1, 1.1, walls);
  AddBox(2.2, 4.5, 0.4, 0.4, walls);
  AddBox(10.2, 3.0, 0.5, 0.25, walls);
  AddBox(14.6, 9.1, 0.7, 0.3, walls);
  AddBox(0.0, 8.2, 0.3, 0.9, walls);
  AddBox(19.7, 5.4, 0.3, 0.8, walls);
  return walls;
}

// Around the corridors, with visits to two offices and a core room, back to the start.
std::vector<Point2> BuildRoute() {
  return {{2.9, 3.9},   {6.75, 3.9},  {6.75, 2.3},   {6.8, 3.9},   {12.25, 3.9},
          {18.7, 4.0},  {18.8, 10.1}, {13.55, 10.1}, {13.55, 8.3}, {13.6, 10.1},
          {8.65, 10.1}, {8.65, 11.9}, {8.6, 10.1},   {1.2, 10.0},  {1.1, 4.0}};
}

}  // namespace

double SeededNoise::Uniform() { return static_cast<double>(bits_() >> 11U) * 0x1.0p-53; }

double SeededNoise::Normal() {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += Uniform();
  return sum;
}

SimulatedBuilding::SimulatedBuilding(const SimulationOptions& options)
    : options_(options), noise_(options.seed), walls_(BuildWalls()), route_(BuildRoute()) {
  T_building_laser_ = T_odometry_laser_ = {route_[0].x, route_[0].y, 0.0};
}

double SimulatedBuilding::Range(const Point2& from, double angle_rad, double max_range_m) const {
  const double dx = std::cos(angle_rad);
  const double dy = std::sin(angle_rad);
  double nearest = max_range_m;
  for (const Wall& wall : walls_) {
    // from + t d = a + u (b - a), solved by cross products.
    const double ex = wall.b.x - wall.a.x;
    const double ey = wall.b.y - wall.a.y;
    const double det = dx * ey - dy * ex;
    if (det == 0.0) continue;
    const double ax = wall.a.x - from.x;
    const double ay = wall.a.y - from.y;
    const double t = (ax * ey - ay * ex) / det;
    const double u = (ax * dy - ay * dx) / det;
    if (t >= 0.0 && t < nearest && u >= 0.0 && u <= 1.0) nearest = t;
  }
  return nearest;
}

void SimulatedBuilding::Advance() {
  const Point2& goal = route_[next_corner_];
  const double dx = goal.x - T_building_laser_.x;
  const double dy = goal.y - T_building_laser_.y;
  const double distance = std::hypot(dx, dy);
  const double off = WrapAngle(std::atan2(dy, dx) - T_building_laser_.theta);
  const double max_turn = options_.turn_rate_rad_per_s * options_.scan_period_s;
  const double turn = std::clamp(off, -max_turn, max_turn);
  // It turns almost in place, so that it keeps clear of the door frames.
  const double full = options_.speed_m_per_s * options_.scan_period_s;
  const double step = std::min(distance, std::abs(off) > 0.3 ? 0.1 * full : full);
  if (distance - step < 0.05) next_corner_ = (next_corner_ + 1) % route_.size();

  const Pose2 motion{step * std::cos(0.5 * turn), step * std::sin(0.5 * turn), turn};
  const double measured_step = step * (1.0 + options_.odometry_noise_per_m * noise_.Normal());
  const double measured_turn = turn * (1.0 + options_.odometry_noise_per_rad * noise_.Normal()) +
                               step * options_.odometry_heading_bias_rad_per_m;
  const Pose2 measured{measured_step * std::cos(0.5 * measured_turn), measured_step * std::sin(0.5 * measured_turn),
                       measured_turn};
  T_building_laser_ = T_building_laser_ * motion;
  T_odometry_laser_ = T_odometry_laser_ * measured;
}

bool SimulatedBuilding::Next(LaserScan2& scan) {
  if (next_sequence_ >= options_.scans) return false;
  if (next_sequence_ > 0) Advance();
  scan.sequence = next_sequence_++;
  scan.stamp_seconds = static_cast<double>(scan.sequence) * options_.scan_period_s;
  scan.start_angle_rad = -0.5 * std::numbers::pi;
  scan.angle_step_rad = std::numbers::pi / static_cast<double>(options_.beams);
  scan.max_range_m = options_.max_range_m;
  scan.odometry = T_odometry_laser_;
  scan.ranges_m.resize(options_.beams);
  for (std::size_t i = 0; i < options_.beams; ++i) {
    const double angle = T_building_laser_.theta + scan.start_angle_rad + static_cast<double>(i) * scan.angle_step_rad;
    const double range = Range({T_building_laser_.x, T_building_laser_.y}, angle, options_.max_range_m);
    const double noisy = range + options_.range_noise_m * noise_.Normal();
    scan.ranges_m[i] = static_cast<float>(range < options_.max_range_m ? std::max(0.0, noisy) : range);
  }
  return true;
}

}  // namespace slam2d
