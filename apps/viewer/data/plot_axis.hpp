#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace hgros::viewer {

/// Round numbers along an axis, and how they are written.
struct AxisTicks {
  std::vector<double> at;
  std::vector<std::string> text;
};

/// At most `most` ticks in [lo, hi], at multiples of 1, 2 or 5 times a power of ten.
[[nodiscard]] AxisTicks TicksFor(double lo, double hi, std::size_t most);

/// What an axis shows of values from `lo` to `hi`: some room around them, also if they are all the same.
struct AxisRange {
  double lo = 0;
  double hi = 1;
};
[[nodiscard]] AxisRange RangeAround(double lo, double hi);

/// The unit of a field by the names that the open schemas give it ("pose.position.x" is metres); empty: unknown.
[[nodiscard]] std::string_view UnitOfField(std::string_view path);

}  // namespace hgros::viewer
