#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace hgros::viewer {

/// Round numbers along an axis, and their texts.
struct AxisTicks {
  std::vector<double> at;
  std::vector<std::string> text;
};

/// At most `most` ticks in [lo, hi], at multiples of 1, 2 or 5 times a power of ten.
[[nodiscard]] AxisTicks TicksFor(double lo, double hi, std::size_t most);

/// The range of an axis for values from `lo` to `hi`, with a margin, also if all values are equal.
struct AxisRange {
  double lo = 0;
  double hi = 1;
};
[[nodiscard]] AxisRange RangeAround(double lo, double hi);

/// The unit of a field, from its name in the open schemas ("pose.position.x" is in meters). Empty: unknown.
[[nodiscard]] std::string_view UnitOfField(std::string_view path);

}  // namespace hgros::viewer
