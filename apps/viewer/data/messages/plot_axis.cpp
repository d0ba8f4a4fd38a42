#include "viewer/data/messages/plot_axis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace hgros::viewer {
namespace {

/// The path without its last step.
std::string_view Parent(std::string_view path) {
  const std::size_t dot = path.rfind('.');
  return dot == std::string_view::npos ? std::string_view() : path.substr(0, dot);
}

/// The last step, without its index.
std::string_view Leaf(std::string_view path) {
  const std::string_view last = path.substr(path.rfind('.') + 1);
  return last.substr(0, last.find('['));
}

}  // namespace

AxisTicks TicksFor(double lo, double hi, std::size_t most) {
  AxisTicks ticks;
  const double span = hi - lo;
  if (!std::isfinite(span) || span <= 0 || most == 0) return ticks;
  double step = std::pow(10, std::floor(std::log10(span / static_cast<double>(most))));
  for (const double factor : {1.0, 2.0, 5.0, 10.0, 20.0}) {
    if (std::floor(hi / (step * factor)) - std::ceil(lo / (step * factor)) + 1 <= static_cast<double>(most)) {
      step *= factor;
      break;
    }
  }
  const double largest = std::max(std::abs(lo), std::abs(hi));
  if (!(step > largest * 1e-13)) return ticks;  // Finer than the precision of the numbers.
  const int places = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  const bool plain = largest < 1e7 && places <= 7;
  for (double n = std::ceil(lo / step); n * step <= hi && ticks.at.size() < most; ++n) {
    const double value = n == 0 ? 0 : n * step;
    char text[48];
    if (plain) {
      std::snprintf(text, sizeof text, "%.*f", places, value);
    } else {
      const int digits = static_cast<int>(std::ceil(std::log10(largest / step)));
      std::snprintf(text, sizeof text, "%.*g", std::clamp(digits + 1, 2, 15), value);
    }
    ticks.at.push_back(value);
    ticks.text.emplace_back(text);
  }
  return ticks;
}

AxisRange RangeAround(double lo, double hi) {
  if (!(lo <= hi)) return {};
  const double room = hi > lo ? 0.08 * (hi - lo) : lo == 0 ? 1 : 0.1 * std::abs(lo);
  return {lo - room, hi + room};
}

std::string_view UnitOfField(std::string_view path) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 12> kUnits = {{
      {"position", "m"},
      {"translation", "m"},
      {"size", "m"},
      {"ranges", "m"},
      {"timestamp", "s"},
      {"start_angle", "rad"},
      {"end_angle", "rad"},
      {"latitude", "deg"},
      {"longitude", "deg"},
      {"altitude", "m"},
      {"linear_velocity", "m/s"},
      {"angular_velocity", "rad/s"},
  }};
  const std::string_view leaf = Leaf(path);
  const bool component = leaf == "x" || leaf == "y" || leaf == "z";
  const std::string_view named = component ? Leaf(Parent(path)) : leaf;
  const auto* const found = std::ranges::find(kUnits, named, &std::pair<std::string_view, std::string_view>::first);
  return found == kUnits.end() ? std::string_view() : found->second;
}

}  // namespace hgros::viewer
