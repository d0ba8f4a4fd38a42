#include "terminal/units.hpp"

#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <span>

namespace hgros::cli {
namespace {

constexpr const char* kBytes[] = {"B", "kB", "MB", "GB", "TB"};
constexpr const char* kTimes[] = {"ns", "us", "ms", "s"};

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
  if (std::abs(bytes) < 1000 && bytes == std::floor(bytes)) return fmt::format("{:.0f} B", bytes);
  return InUnits(bytes, 1000, kBytes);
}

std::string BandwidthText(double bytes_per_second, bool exact) {
  if (exact) return fmt::format("{:.0f}", bytes_per_second);
  return BytesText(std::round(bytes_per_second), false) + "/s";
}

std::string DurationText(std::int64_t nanoseconds, bool exact) {
  if (exact) return fmt::format("{}", nanoseconds);
  if (nanoseconds > -1000 && nanoseconds < 1000) return fmt::format("{} ns", nanoseconds);
  return InUnits(static_cast<double>(nanoseconds), 1000, kTimes);
}

std::string BoundText(double value, double step, double largest, Unit unit, bool exact) {
  if (exact) return fmt::format("{:.0f}", value);
  if (step <= 0) return unit == Unit::kBytes ? BytesText(value, false) : DurationText(std::llround(value), false);
  const std::span<const char* const> names =
      unit == Unit::kBytes ? std::span<const char* const>(kBytes) : std::span<const char* const>(kTimes);
  std::size_t chosen = 0;
  for (; chosen + 1 < names.size() && largest >= 1000; ++chosen) {
    value /= 1000;
    step /= 1000;
    largest /= 1000;
  }
  const int digits = step >= 1 ? 0 : static_cast<int>(std::ceil(-std::log10(step) - 1e-9));
  return fmt::format("{:.{}f} {}", value, digits, names[chosen]);
}

std::string TimeOfDay(std::int64_t nanoseconds) {
  const std::time_t seconds = nanoseconds / 1'000'000'000;
  tm local{};
  localtime_r(&seconds, &local);
  return fmt::format("{:02}:{:02}:{:02}.{:03}", local.tm_hour, local.tm_min, local.tm_sec,
                     nanoseconds / 1'000'000 % 1000);
}

}  // namespace hgros::cli
