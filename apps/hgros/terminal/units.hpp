#pragma once

#include <cstdint>
#include <string>

namespace hgros::cli {

/// Numbers for people, with three digits: "10.0 Hz", "1.5 MB" (powers of 1000), "2.3 ms". `exact`: all digits, without
/// a unit: Hz, bytes or bytes per second, ns.
[[nodiscard]] std::string RateText(double hertz, bool exact);
[[nodiscard]] std::string BytesText(double bytes, bool exact);
[[nodiscard]] std::string BandwidthText(double bytes_per_second, bool exact);
[[nodiscard]] std::string DurationText(std::int64_t nanoseconds, bool exact);
/// The time of day here, such as "14:05:33.125", from nanoseconds since 1970.
[[nodiscard]] std::string TimeOfDay(std::int64_t nanoseconds);

enum class Unit { kNanoseconds, kBytes };
/// A bound of a histogram, in the unit that suits `largest` and with the digits that tell bounds `step` apart.
[[nodiscard]] std::string BoundText(double value, double step, double largest, Unit unit, bool exact);

}  // namespace hgros::cli
