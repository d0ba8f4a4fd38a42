#pragma once

#include <cstddef>
#include <cstdint>

#include "hgros/base/export.hpp"

namespace hgros {

/// The queue of a subscription, for messages that arrive faster than its callback handles them. A value; immutable.
class HGROS_EXPORT Queue {
 public:
  enum class Kind : std::uint8_t {
    kKeepLast,  ///< The newest `depth` wait; older ones are dropped and counted.
    kKeepAll,   ///< Lossless: nothing is dropped; publishing returns PublishStatus::kFull while there is no room.
                ///< A remote subscriber that is silent for the peer timeout is gone and no longer blocks publishers.
  };
  static constexpr std::size_t kDefaultDepth = 16;
  static constexpr std::size_t kUnlimitedBytes = SIZE_MAX;

  /// The newest 16.
  Queue() = default;
  /// The newest `depth` messages; throws Error if it is 0.
  [[nodiscard]] static Queue KeepLast(std::size_t depth);
  /// Only the newest: KeepLast(1).
  [[nodiscard]] static Queue Latest();
  /// Lossless with room for `messages` messages and about `bytes` bytes, whichever limit is reached first. A single
  /// message is accepted at any size. Throws Error if either is 0.
  [[nodiscard]] static Queue KeepAll(std::size_t messages, std::size_t bytes = kUnlimitedBytes);

  [[nodiscard]] Kind kind() const noexcept { return kind_; }
  [[nodiscard]] bool lossless() const noexcept { return kind_ == Kind::kKeepAll; }
  [[nodiscard]] std::size_t depth() const noexcept { return depth_; }
  [[nodiscard]] std::size_t limit_bytes() const noexcept { return limit_bytes_; }
  bool operator==(const Queue&) const = default;

 private:
  Kind kind_ = Kind::kKeepLast;
  std::size_t depth_ = kDefaultDepth;
  std::size_t limit_bytes_ = kUnlimitedBytes;
};

}  // namespace hgros
