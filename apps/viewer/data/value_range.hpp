#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hgros::viewer {

/// The range of values that colors are spread over. It covers all values except the lowest and highest 2 % (unless that
/// leaves a single value). It grows in steps, so that it rarely changes.
class ValueRange {
 public:
  /// Returns whether the range has changed. Values that are not numbers are ignored.
  bool Cover(std::span<const float> values) {
    sample_.clear();
    const std::size_t step = std::max<std::size_t>(1, values.size() / kSample);
    for (std::size_t i = 0; i < values.size(); i += step) {
      if (std::isfinite(values[i])) sample_.push_back(values[i]);
    }
    if (sample_.empty()) return false;
    const auto tail = static_cast<std::ptrdiff_t>(sample_.size() / 50);
    const auto low = sample_.begin() + tail;
    std::ranges::nth_element(sample_, low);
    float lowest = *low;
    const auto high = sample_.end() - 1 - tail;
    std::ranges::nth_element(sample_, high);
    float highest = *high;
    if (lowest == highest &&
        !(known_ && hi_ > lo_)) {  // All values except the outliers are equal, so the outliers count, too.
      const auto [least, greatest] = std::ranges::minmax(sample_);
      lowest = least;
      highest = greatest;
    }
    if (known_ && lowest >= lo_ && highest <= hi_) return false;
    const float new_lo = known_ ? std::min(lo_, lowest) : lowest;
    const float new_hi = known_ ? std::max(hi_, highest) : highest;
    const float margin = known_ ? 0.25F * (new_hi - new_lo) : 0;  // A range that grew once will grow again.
    if (!known_ || new_lo < lo_) lo_ = new_lo - margin;
    if (!known_ || new_hi > hi_) hi_ = new_hi + margin;
    known_ = true;
    return true;
  }

  [[nodiscard]] bool known() const noexcept { return known_; }
  [[nodiscard]] float lo() const noexcept { return lo_; }
  [[nodiscard]] float hi() const noexcept { return hi_ > lo_ ? hi_ : lo_ + 1; }

 private:
  static constexpr std::size_t kSample = 4096;

  bool known_ = false;
  float lo_ = 0;
  float hi_ = 1;
  std::vector<float> sample_;
};

/// A value of the range as 8 bits.
[[nodiscard]] inline std::uint8_t EncodeIn(const ValueRange& range, float value) noexcept {
  const float unit = (value - range.lo()) / (range.hi() - range.lo());
  return static_cast<std::uint8_t>(std::isfinite(unit) ? std::lround(std::clamp(unit, 0.0F, 1.0F) * 255) : 0);
}

/// The new code of each old code after the range has changed.
[[nodiscard]] inline std::vector<std::uint8_t> Recoding(const ValueRange& before, const ValueRange& now) {
  std::vector<std::uint8_t> codes(256);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    codes[i] = EncodeIn(now, before.lo() + static_cast<float>(i) / 255 * (before.hi() - before.lo()));
  }
  return codes;
}

}  // namespace hgros::viewer
