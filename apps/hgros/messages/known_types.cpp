#include "messages/known_types.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <ctime>

#include "hgros/clock/time.hpp"

namespace hgros::cli {
namespace {

constexpr std::int64_t kNanosPerSecond = 1'000'000'000;
constexpr std::int64_t kFirstSecond = -62'135'596'800;  // 0001-01-01T00:00:00Z
constexpr std::int64_t kLastSecond = 253'402'300'799;   // 9999-12-31T23:59:59Z

// ".25" for 250 million nanoseconds; empty for 0.
std::string Fraction(std::int64_t nanos) {
  if (nanos == 0) return {};
  std::string digits = fmt::format(".{:09}", nanos);
  digits.erase(digits.find_last_not_of('0') + 1);
  return digits;
}

std::optional<std::int32_t> NanosOf(std::string_view digits) {
  if (digits.empty() || digits.size() > 9) return std::nullopt;
  std::int32_t nanos = 0;
  const auto [stopped, error] = std::from_chars(digits.data(), digits.data() + digits.size(), nanos);
  if (error != std::errc() || stopped != digits.data() + digits.size() || nanos < 0) return std::nullopt;
  for (std::size_t i = digits.size(); i < 9; ++i) nanos *= 10;
  return nanos;
}

std::optional<SecondsAndNanos> ReadDate(std::string_view text) {
  tm date{};
  const std::string copy(text);
  const char* rest = strptime(copy.c_str(), "%Y-%m-%dT%H:%M:%S", &date);
  if (rest == nullptr) return std::nullopt;
  SecondsAndNanos time{timegm(&date), 0};
  std::string_view left(rest);
  if (left.starts_with('.')) {
    const std::size_t end = left.find_first_not_of("0123456789", 1);
    const std::optional<std::int32_t> nanos = NanosOf(left.substr(1, end == std::string_view::npos ? end : end - 1));
    if (!nanos) return std::nullopt;
    time.nanos = *nanos;
    left.remove_prefix(std::min(end, left.size()));
  }
  if (left == "Z") return time;
  return std::nullopt;
}

std::optional<SecondsAndNanos> ReadSeconds(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  const std::size_t dot = text.find('.');
  const std::string_view whole = text.substr(0, dot);
  if (whole.starts_with('-')) return std::nullopt;
  SecondsAndNanos time;
  const std::string with_sign = (negative ? "-" : "") + std::string(whole);  // The smallest has no positive form.
  const char* end = with_sign.data() + with_sign.size();
  const auto [stopped, error] = std::from_chars(with_sign.data(), end, time.seconds);
  if (error != std::errc() || stopped != end) return std::nullopt;
  if (dot != std::string_view::npos) {
    const std::optional<std::int32_t> nanos = NanosOf(text.substr(dot + 1));
    if (!nanos) return std::nullopt;
    time.nanos = negative ? -*nanos : *nanos;
  }
  return time;
}

// "5 s -1 ns", as values are written that are neither a time nor a duration.
std::optional<SecondsAndNanos> ReadParts(std::string_view text) {
  constexpr std::string_view kBetween = " s ";
  constexpr std::string_view kEnd = " ns";
  const std::size_t between = text.find(kBetween);
  if (between == std::string_view::npos || !text.ends_with(kEnd)) return std::nullopt;
  const std::string_view first = text.substr(0, between);
  std::string_view second = text.substr(between + kBetween.size());
  second.remove_suffix(std::min(second.size(), kEnd.size()));
  SecondsAndNanos time;
  const auto reads = [](std::string_view digits, auto& number) {
    const auto [stopped, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    return error == std::errc() && stopped == digits.data() + digits.size();
  };
  if (!reads(first, time.seconds) || !reads(second, time.nanos)) return std::nullopt;
  return time;
}

std::int64_t NumberIn(const google::protobuf::Message& message, const char* name) {
  const google::protobuf::FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(name);
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  return field->cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_INT64 ? reflection.GetInt64(message, field)
                                                                               : reflection.GetInt32(message, field);
}

}  // namespace

KnownType KnownTypeOf(const google::protobuf::Descriptor& type) {
  using google::protobuf::FieldDescriptor;
  const bool time = type.full_name() == "google.protobuf.Timestamp";
  if (!time && type.full_name() != "google.protobuf.Duration") return KnownType::kNone;
  const FieldDescriptor* seconds = type.FindFieldByName("seconds");  // A publisher may call anything by that name.
  const FieldDescriptor* nanos = type.FindFieldByName("nanos");
  if (type.field_count() != 2 || seconds == nullptr || nanos == nullptr || seconds->is_repeated() ||
      nanos->is_repeated() || seconds->cpp_type() != FieldDescriptor::CPPTYPE_INT64 ||
      nanos->cpp_type() != FieldDescriptor::CPPTYPE_INT32) {
    return KnownType::kNone;
  }
  return time ? KnownType::kTimestamp : KnownType::kDuration;
}

std::string TimestampText(std::int64_t seconds, std::int64_t nanos) {
  if (seconds < kFirstSecond || seconds > kLastSecond || nanos < 0 || nanos >= kNanosPerSecond) {
    return fmt::format("{} s {} ns", seconds, nanos);  // Not a time; shown as it is.
  }
  tm date{};
  const time_t time = seconds;
  gmtime_r(&time, &date);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}{}Z", date.tm_year + 1900, date.tm_mon + 1, date.tm_mday,
                     date.tm_hour, date.tm_min, date.tm_sec, Fraction(nanos));
}

std::string DurationText(std::int64_t seconds, std::int64_t nanos) {
  const bool mixed = (seconds > 0 && nanos < 0) || (seconds < 0 && nanos > 0);
  if (mixed || std::abs(nanos) >= kNanosPerSecond) return fmt::format("{} s {} ns", seconds, nanos);
  const char* sign = seconds < 0 || nanos < 0 ? "-" : "";
  const std::uint64_t size =
      seconds < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(seconds) : static_cast<std::uint64_t>(seconds);
  return fmt::format("{}{}{}s", sign, size, Fraction(std::abs(nanos)));
}

std::string TextOfKnown(KnownType kind, const google::protobuf::Message& message) {
  const std::int64_t seconds = NumberIn(message, "seconds");
  const std::int64_t nanos = NumberIn(message, "nanos");
  return kind == KnownType::kTimestamp ? TimestampText(seconds, nanos) : DurationText(seconds, nanos);
}

std::optional<SecondsAndNanos> ReadKnown(KnownType kind, std::string_view text) {
  if (const std::optional<SecondsAndNanos> parts = ReadParts(text)) return parts;
  if (kind == KnownType::kDuration) {
    if (text.ends_with('s')) text.remove_suffix(1);
    return ReadSeconds(text);
  }
  if (text == "now") {
    const std::int64_t now = WallNow().nanoseconds;
    return SecondsAndNanos{now / kNanosPerSecond, static_cast<std::int32_t>(now % kNanosPerSecond)};
  }
  const std::optional<SecondsAndNanos> date = ReadDate(text);
  if (date) return date;
  std::optional<SecondsAndNanos> time = ReadSeconds(text);
  if (time && (time->seconds <= kFirstSecond || time->seconds > kLastSecond)) return std::nullopt;
  if (time && time->nanos < 0) *time = {time->seconds - 1, time->nanos + static_cast<std::int32_t>(kNanosPerSecond)};
  return time;
}

}  // namespace hgros::cli
