#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hgros/tf/edge_snapshot.hpp"

namespace hgros::viewer {

/// How long ago the last transform of each moving frame arrived. The time of arrival counts, not the stamp, which may
/// be from any clock. Times are seconds on a steady clock that the caller reads. Thread safety: none.
class FrameAges {
 public:
  void Update(std::span<const EdgeSnapshot> edges, double now_s);

  /// None if the frame is static or has no parent.
  [[nodiscard]] std::optional<double> AgeOf(std::string_view frame, double now_s) const;
  /// Whether AgeOf() has reached that age. Rounds as NextAged() does.
  [[nodiscard]] bool HasAged(std::string_view frame, double age_s, double now_s) const;
  /// When the next frame reaches that age. Infinity if none will.
  [[nodiscard]] double NextAged(double age_s, double now_s) const;
  [[nodiscard]] bool empty() const noexcept { return frames_.empty(); }

 private:
  struct Came {
    std::uint64_t sets = 0;
    double at_s = 0;
  };
  std::map<std::string, Came, std::less<>> frames_;
};

}  // namespace hgros::viewer
