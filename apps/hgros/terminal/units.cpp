#include "terminal/units.hpp"

#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <span>

namespace hgros::cli {
namespace {

std::string ThreeDigits(double value) {
  const double size = std::abs(value);
  if (value == 0) return "0";
  return size < 9.995   ? fmt::format("{:.2f}", value)
         : size < 99.95 ? fmt::format("{:.1f}", value)
                        : fmt::format("{:.0f}", value);
}

// `value` in the largest of the units, which are `step` apart, in which it is at least 1.
std::string InUnits(double value, double step, std::span<const char* const> units) {
  std::size_t unit = 0;
  while (unit + 1 < units.size() && std::abs(value) >= step * 0.9995) {
    value /= step;
    ++unit;
  }
  return ThreeDigits(value) + " " + units[unit];
}

}  // namespace

std::string RateText(double hertz, bool exact) {
  if (exact) return fmt::format("{:.6f}", hertz);
  constexpr const char* kUnits[] = {"Hz", "kHz", "MHz"};
  return InUnits(hertz, 1000, kUnits);
}

std::string BytesText(double bytes, bool exact) {
  if (exact) return fmt::format("{:.0f}", bytes);
  constexpr const char* kUnits[] = {"B", "kB", "MB", "GB", "TB"};
  if (std::abs(bytes) < 1000 && bytes == std::floor(bytes)) return fmt::format("{:.0f} B", bytes);
  return InUnits(bytes, 1000, kUnits);
}

std::string BandwidthText(double bytes_per_second, bool exact) {
  if (exact) return fmt::format("{:.0f}", bytes_per_second);
  return BytesText(std::round(bytes_per_second), false) + "/s";
}

std::string DurationText(std::int64_t nanoseconds, bool exact) {
  if (exact) return fmt::format("{}", nanoseconds);
  constexpr const char* kUnits[] = {"ns", "us", "ms", "s"};
  if (std::abs(nanoseconds) < 1000) return fmt::format("{} ns", nanoseconds);
  return InUnits(static_cast<double>(nanoseconds), 1000, kUnits);
}

std::string TimeOfDay(std::int64_t nanoseconds) {
  const std::time_t seconds = nanoseconds / 1'000'000'000;
  tm local{};
  localtime_r(&seconds, &local);
  return fmt::format("{:02}:{:02}:{:02}.{:03}", local.tm_hour, local.tm_min, local.tm_sec,
                     nanoseconds / 1'000'000 % 1000);
}

}  // namespace hgros::cli
