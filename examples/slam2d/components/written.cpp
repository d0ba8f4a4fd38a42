#include "written.hpp"

#include <cinttypes>
#include <cstdarg>
#include <cstdio>
#include <numbers>

namespace slam2d {
namespace {

[[gnu::format(printf, 1, 2)]] std::string Formatted(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

}  // namespace

std::vector<std::string> LinesOf(const Written& written) {
  const double log_seconds = written.log_time.last_seconds() - written.log_time.first_seconds();
  std::vector<std::string> lines{
      "map         " + written.map_file.string() +
          Formatted(", %.1f m x %.1f m, cells of %.2f m", written.width_m, written.height_m, written.cell_size_m),
      "odometry    " + written.odometry_file.string() + ", with the path by odometry alone in red",
      "trajectory  " + written.trajectory_file.string() + Formatted(", %" PRIu64 " poses", written.scans)};
  if (written.seconds > 0.0) {
    lines.push_back(Formatted("speed       %.2f s, %.0f scans/s", written.seconds,
                              static_cast<double>(written.scans) / written.seconds));
    lines.push_back(Formatted("log time    %.1f s .. %.1f s, at %.4g times real time", written.log_time.first_seconds(),
                              written.log_time.last_seconds(), log_seconds / written.seconds));
  }
  lines.push_back(
      Formatted("hashes      map %016" PRIx64 ", trajectory %016" PRIx64, written.map_hash, written.trajectory_hash));
  if (const auto& error = written.relations) {
    constexpr double kDegrees = 180.0 / std::numbers::pi;
    lines.push_back(Formatted(
        "relations   %zu compared, %zu without poses: %.4f m +- %.4f m (at most %.3f m), %.3f deg +- %.3f deg",
        error->relations, error->unmatched, error->mean_translation_m, error->std_translation_m,
        error->max_translation_m, error->mean_rotation_rad * kDegrees, error->std_rotation_rad * kDegrees));
  }
  return lines;
}

}  // namespace slam2d
