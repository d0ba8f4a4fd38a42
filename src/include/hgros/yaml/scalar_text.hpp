#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

// The meaning of a scalar in YAML's core schema, from its text without quotes.
namespace hgros::scalar {

[[nodiscard]] std::optional<bool> Boolean(std::string_view text);
// Decimal, or hexadecimal and octal such as 0x1f and 0o17; empty if it is not an integer or too large.
[[nodiscard]] std::optional<std::int64_t> Integer(std::string_view text);
[[nodiscard]] std::optional<std::uint64_t> Unsigned(std::string_view text);
// Also .inf, -.inf and .nan.
[[nodiscard]] std::optional<double> Number(std::string_view text);
// Not empty, not null, not a boolean and not a number.
[[nodiscard]] bool IsPlainString(std::string_view text);

// The shortest text that gives the same number again, with an exponent only for very large and very small ones.
[[nodiscard]] std::string FromNumber(double number);

}  // namespace hgros::scalar
