#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hgros/tf/edge_snapshot.hpp"

namespace hgros::viewer {

/// How long ago the last transform of each moving frame came: by when it was taken here, not by its stamp, which may be
/// of any clock. Seconds on a steady clock, as the caller reads it. Thread safety: none.
class FrameAges {
 public:
  void Take(std::span<const EdgeSnapshot> edges, double now_s);

  /// Nothing of a frame that is static, or that is no child.
  [[nodiscard]] std::optional<double> AgeOf(std::string_view frame, double now_s) const;
  /// Whether AgeOf() has reached that, decided as NextAged() does.
  [[nodiscard]] bool HasAged(std::string_view frame, double age_s, double now_s) const;
  /// When the next of those frames reaches that age; infinity: none does.
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
