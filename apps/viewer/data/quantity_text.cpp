#include "viewer/data/quantity_text.hpp"

#include <cmath>
#include <cstdio>

namespace hgros::viewer {
namespace {

std::string ThreeDigits(double value, const char* unit) {
  const double size = std::abs(value);
  const int places = size >= 99.95 ? 0 : size >= 9.995 ? 1 : 2;
  char text[64];
  std::snprintf(text, sizeof text, "%.*f %s", value == 0 ? 0 : places, value, unit);
  return text;
}

}  // namespace

std::string ByteRateText(double bytes_per_second) {
  if (bytes_per_second < 1000) {
    char text[64];
    std::snprintf(text, sizeof text, "%.0f B/s", bytes_per_second);
    return text;
  }
  if (bytes_per_second < 1e6) return ThreeDigits(bytes_per_second / 1e3, "kB/s");
  if (bytes_per_second < 1e9) return ThreeDigits(bytes_per_second / 1e6, "MB/s");
  return ThreeDigits(bytes_per_second / 1e9, "GB/s");
}

std::string RateText(double per_second) { return ThreeDigits(per_second, "Hz"); }

std::string DurationText(std::chrono::nanoseconds duration) {
  const auto ns = static_cast<double>(duration.count());
  const double size = std::abs(ns);
  if (size < 1e6) {
    char text[64];
    std::snprintf(text, sizeof text, "%.0f us", ns / 1e3);
    return text;
  }
  if (size < 1e9) return ThreeDigits(ns / 1e6, "ms");
  if (size < 120e9) return ThreeDigits(ns / 1e9, "s");
  char text[64];
  std::snprintf(text, sizeof text, "%.0f min", ns / 60e9);
  return text;
}

std::string Counted(std::uint64_t count, std::string_view one, std::string_view several) {
  return std::to_string(count) + " " + std::string(count == 1 ? one : several);
}

}  // namespace hgros::viewer
