#pragma once

#include <cstdint>
#include <string_view>

#include "hgros/base/export.hpp"

namespace hgros {

/// What led to a message: the message that was being handled when it was published, and the beginning of their chain. A
/// chain begins with a message that is published outside all callbacks, for example by a timer.
///
/// Messages published inside a callback carry their cause by themselves, through all transports. Code that publishes
/// later or from another thread keeps Cause::Here() of the callback and sets it with a CauseScope.
struct HGROS_EXPORT Cause {
  std::uint64_t message = 0;  ///< MessageInfo::key of that message; 0: none, so the message begins a chain.
  std::int64_t began_ns = 0;  ///< CLOCK_MONOTONIC of this host when the chain began; 0: unknown.
  std::uint32_t origin = 0;   ///< OriginOf() the channel of the message that began the chain.

  /// The cause of messages that this thread publishes now: inside a callback the message that it handles; empty outside
  /// callbacks and scopes.
  [[nodiscard]] static Cause Here() noexcept;
  /// A number for a channel's name; never 0. docs/wire-protocol.md defines it.
  [[nodiscard]] static std::uint32_t OriginOf(std::string_view channel) noexcept;
};

/// While it lives, messages that this thread publishes have this cause. Scopes nest; an empty cause begins chains.
/// Lifetime: a local variable; ends on its own thread, the last one first.
class HGROS_EXPORT CauseScope {
 public:
  explicit CauseScope(const Cause& cause) noexcept;
  CauseScope(const CauseScope&) = delete;
  CauseScope& operator=(const CauseScope&) = delete;
  ~CauseScope();

 private:
  const Cause cause_;
  const Cause* const outer_;
};

}  // namespace hgros
