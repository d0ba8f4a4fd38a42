#include "trajectory_file.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string>

#include "replace_file.hpp"

namespace slam2d {
namespace {

void Append(double value, std::string& line) {
  std::array<char, 40> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  line.append(digits.data(), end);
}

}  // namespace

void WriteTrajectory(std::span<const ScanMatch> trajectory, const std::filesystem::path& path) {
  ReplaceFile(path, "The trajectory", [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    std::string line;
    for (const ScanMatch& match : trajectory) {
      line.clear();
      Append(match.stamp_seconds, line);
      line += ' ';
      Append(match.T_map_laser.x, line);
      line += ' ';
      Append(match.T_map_laser.y, line);
      line += " 0 0 0 ";
      Append(std::sin(0.5 * match.T_map_laser.theta), line);
      line += ' ';
      Append(std::cos(0.5 * match.T_map_laser.theta), line);
      line += '\n';
      file << line;
    }
    file.close();
    if (!file) throw std::runtime_error("The trajectory " + path.string() + " cannot be written.");
  });
}

}  // namespace slam2d
