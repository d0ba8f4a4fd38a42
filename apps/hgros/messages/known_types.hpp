#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace google::protobuf {
class Descriptor;
class Message;
}  // namespace google::protobuf

namespace hgros::cli {

/// Times and durations of protobuf, which are written as one text as in protobuf's JSON: "2026-11-23T11:50:33.25Z" and
/// "1.5s".
enum class KnownType { kNone, kTimestamp, kDuration };
[[nodiscard]] KnownType KnownTypeOf(const google::protobuf::Descriptor& type);

[[nodiscard]] std::string TimestampText(std::int64_t seconds, std::int64_t nanos);
[[nodiscard]] std::string DurationText(std::int64_t seconds, std::int64_t nanos);
/// The text of a message whose type is a known one.
[[nodiscard]] std::string TextOfKnown(KnownType kind, const google::protobuf::Message& message);

struct SecondsAndNanos {
  std::int64_t seconds = 0;
  std::int32_t nanos = 0;
};
/// Reads the texts above, "now" for a time, and numbers of seconds. Empty: it is none.
[[nodiscard]] std::optional<SecondsAndNanos> ReadKnown(KnownType kind, std::string_view text);

}  // namespace hgros::cli
