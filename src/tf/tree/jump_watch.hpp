#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "hgros/tf/transform_query.hpp"

namespace hgros::tf {

/// Detects that the stamps of an edge have jumped back and stay there, as when a recording starts again: for 2 s, at
/// least one each second, all stamps were more than 1 s before the newest one and of its publisher, and none was before
/// the last one. Transforms that are late, or come in one bundle out of order, are no jump.
class JumpWatch {
 public:
  using Moment = std::chrono::steady_clock::time_point;

  /// Call it with each stamp that is before the newest one. Returns whether the stamps have jumped back.
  [[nodiscard]] bool HasJumped(std::int64_t newest, std::int64_t stamp, PublisherId publisher, Moment now) noexcept {
    const bool slightly_late =
        static_cast<std::uint64_t>(newest) - static_cast<std::uint64_t>(stamp) <= kSlightlyLateNs;
    if (slightly_late || publisher != publisher_) {
      since_.reset();
      return false;
    }
    if (!since_ || stamp < last_ || now - last_came_ > kLongestPause) since_ = now;
    last_ = stamp;
    last_came_ = now;
    return now - *since_ >= kLongestLate;
  }
  /// Call it with the publisher of each other stamp, and when the edge begins again.
  void Begin(PublisherId publisher) noexcept {
    publisher_ = publisher;
    since_.reset();
  }

 private:
  static constexpr std::uint64_t kSlightlyLateNs = 1'000'000'000;
  static constexpr std::chrono::seconds kLongestPause{1};
  static constexpr std::chrono::seconds kLongestLate{2};

  PublisherId publisher_;        ///< Of the newest stamp.
  std::optional<Moment> since_;  ///< When the first of these stamps came.
  Moment last_came_;
  std::int64_t last_ = 0;
};

}  // namespace hgros::tf
