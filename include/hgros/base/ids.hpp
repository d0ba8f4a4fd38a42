#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"

namespace hgros {

/// Identifies a session worldwide; random, never reused. Zero means no session.
struct HGROS_EXPORT SessionId {
  std::uint64_t value = 0;

  [[nodiscard]] static SessionId Random();
  /// 16 lower-case hexadecimal digits.
  [[nodiscard]] std::string ToString() const;
  /// Reads the output of ToString(); zero for any other text.
  [[nodiscard]] static SessionId FromString(std::string_view text) noexcept;
  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 takes its 0 for one
  auto operator<=>(const SessionId&) const = default;
};

/// The sender of a message and its number. Repeated messages are recognized by these three.
struct MessageId {
  std::uint64_t publisher = 0;    ///< The publishing session's id.
  std::uint64_t incarnation = 0;  ///< Distinguishes restarts of the publisher; grows with each start.
  std::uint64_t sequence = 0;     ///< Counts the publisher's messages on one channel from 1, without gaps.
  auto operator<=>(const MessageId&) const = default;
};

/// A random 64-bit number from the kernel; never zero. Thread-safe.
[[nodiscard]] HGROS_EXPORT std::uint64_t RandomId();

}  // namespace hgros

template <>
struct std::hash<hgros::SessionId> {
  std::size_t operator()(const hgros::SessionId& id) const noexcept { return static_cast<std::size_t>(id.value); }
};
