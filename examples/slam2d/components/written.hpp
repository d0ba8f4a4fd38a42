#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "../app/messages.hpp"
#include "../relations_error.hpp"

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
  std::optional<RelationsError> relations;
};

/// The report for people: what was written, line by line.
[[nodiscard]] std::vector<std::string> LinesOf(const Written& written);

}  // namespace slam2d
