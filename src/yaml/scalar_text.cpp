#include "hgros/yaml/scalar_text.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace hgros::scalar {
namespace {

template <class T>
std::optional<T> Whole(std::string_view text, int base) {
  T number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (text.empty() || fault != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

bool IsOneOf(std::string_view text, std::initializer_list<std::string_view> words) {
  for (const std::string_view word : words) {
    if (text == word) return true;
  }
  return false;
}

}  // namespace

std::optional<bool> Boolean(std::string_view text) {
  if (IsOneOf(text, {"true", "True", "TRUE"})) return true;
  if (IsOneOf(text, {"false", "False", "FALSE"})) return false;
  return std::nullopt;
}

std::optional<std::uint64_t> Unsigned(std::string_view text) {
  if (text.starts_with("0x")) return Whole<std::uint64_t>(text.substr(2), 16);
  if (text.starts_with("0o")) return Whole<std::uint64_t>(text.substr(2), 8);
  if (text.starts_with('+')) text.remove_prefix(1);
  return Whole<std::uint64_t>(text, 10);
}

std::optional<std::int64_t> Integer(std::string_view text) {
  if (text.starts_with('-')) return Whole<std::int64_t>(text, 10);
  const std::optional<std::uint64_t> number = Unsigned(text);
  if (!number || *number > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) return std::nullopt;
  return static_cast<std::int64_t>(*number);
}

std::optional<double> Number(std::string_view text) {
  if (IsOneOf(text, {".nan", ".NaN", ".NAN"})) return std::numeric_limits<double>::quiet_NaN();
  const bool negative = text.starts_with('-');
  std::string_view digits = text;
  if (negative || text.starts_with('+')) digits.remove_prefix(1);
  if (IsOneOf(digits, {".inf", ".Inf", ".INF"})) return negative ? -INFINITY : INFINITY;
  if (digits.starts_with("0x") || digits.starts_with("0o")) {
    const std::optional<std::uint64_t> number = digits == text ? Unsigned(text) : std::nullopt;
    return number ? std::optional(static_cast<double>(*number)) : std::nullopt;
  }
  if (digits.empty() || digits.find_first_not_of("0123456789.eE+-") != std::string_view::npos) return std::nullopt;
  double number = 0;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (end != digits.data() + digits.size() || digits[0] == '-') return std::nullopt;
  if (fault == std::errc::result_out_of_range) {
    const bool tiny = digits.find("e-") != std::string_view::npos || digits.find("E-") != std::string_view::npos;
    number = tiny ? 0.0 : INFINITY;
  } else if (fault != std::errc()) {
    return std::nullopt;
  }
  return negative ? -number : number;
}

bool IsPlainString(std::string_view text) {
  return !IsOneOf(text, {"", "~", "null", "Null", "NULL"}) && !Boolean(text) && !Number(text);
}

std::string FromNumber(double number) {
  if (std::isnan(number)) return ".nan";
  if (std::isinf(number)) return number > 0 ? ".inf" : "-.inf";
  std::array<char, 40> buffer{};
  const double size = std::abs(number);
  const auto format = size == 0 || (size >= 1e-4 && size < 1e16) ? std::chars_format::fixed  // 300000.0, not 3e+05.
                                                                 : std::chars_format::scientific;
  const auto [end, fault] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number, format);
  std::string text(buffer.data(), end);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

}  // namespace hgros::scalar
