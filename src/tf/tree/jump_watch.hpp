#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace hgros::tf {

/// Detects that the stamps of an edge have jumped back and stay there, as when a recording starts again: for 2 s, all
/// stamps were more than 1 s before the newest one, and none was before the last one. Transforms that are late, or come
/// in one bundle out of order, are no jump.
class JumpWatch {
 public:
  using Moment = std::chrono::steady_clock::time_point;

  /// Call it with each stamp that is before the newest one. Returns whether the stamps have jumped back.
  [[nodiscard]] bool HasJumped(std::int64_t newest, std::int64_t stamp, Moment now) noexcept {
    if (static_cast<std::uint64_t>(newest) - static_cast<std::uint64_t>(stamp) <= kSlightlyLateNs) {
      Reset();
      return false;
    }
    if (!since_ || stamp < last_) since_ = now;
    last_ = stamp;
    return now - *since_ >= kLongestLate;
  }
  /// Call it with each other stamp, and when the edge begins again.
  void Reset() noexcept { since_.reset(); }

 private:
  static constexpr std::uint64_t kSlightlyLateNs = 1'000'000'000;
  static constexpr std::chrono::seconds kLongestLate{2};

  std::optional<Moment> since_;  ///< When the first of these stamps came.
  std::int64_t last_ = 0;
};

}  // namespace hgros::tf
