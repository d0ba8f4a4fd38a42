#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace hgros::viewer {

/// A number with three significant digits and its unit: "1.25 MB/s", "340 B/s".
[[nodiscard]] std::string ByteRateText(double bytes_per_second);
/// "1 message", "0 messages".
[[nodiscard]] std::string Counted(std::uint64_t count, std::string_view one, std::string_view several);
/// "12.5 Hz", "0.05 Hz", "0 Hz".
[[nodiscard]] std::string RateText(double per_second);
/// "340 us", "1.25 ms", "12.5 s", "3 min".
[[nodiscard]] std::string DurationText(std::chrono::nanoseconds duration);

}  // namespace hgros::viewer
