#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace hgros::viewer {

/// The range of values that colors are spread over. It covers what was seen last, without outliers: of each message all
/// values except the lowest and highest 2 % (unless that leaves a single value), and, from 16 messages on, all messages
/// except the lowest and highest 1 % (at least one). It rarely changes: it grows if values lie outside by more than a
/// twentieth of it, then with a margin of a quarter, and shrinks if they fill less than a quarter.
class ValueRange {
 public:
  static constexpr std::size_t kFewMessages = 16;
  static constexpr std::size_t kAllMessages = std::numeric_limits<std::size_t>::max();

  /// Covers a message, and forgets all but the last `messages` (at least kFewMessages). `weight`: the number of
  /// messages that it stands for. Returns whether the range has changed. Values that are not numbers are ignored.
  bool Cover(std::span<const float> values, std::size_t messages = kFewMessages, std::size_t weight = 1) {
    sample_.clear();
    const std::size_t step = std::max<std::size_t>(1, values.size() / kSample);
    for (std::size_t i = 0; i < values.size(); i += step) {
      if (std::isfinite(values[i])) sample_.push_back(values[i]);
    }
    if (sample_.empty()) return false;
    const std::size_t tail = sample_.size() / 50;
    std::pair<float, float> seen(Lowest(sample_, tail), Highest(sample_, tail));
    // All values except the outliers are equal, so the outliers count, too.
    if (seen.first == seen.second && !(known_ && hi_ > lo_)) {
      const auto [least, greatest] = std::ranges::minmax(sample_);
      seen = {least, greatest};
    }
    Remember(seen, messages, weight);
    return Settle();
  }

  [[nodiscard]] bool known() const noexcept { return known_; }
  [[nodiscard]] float lo() const noexcept { return lo_; }
  [[nodiscard]] float hi() const noexcept { return hi_ > lo_ ? hi_ : lo_ + 1; }

 private:
  static constexpr std::size_t kSample = 4096;  ///< Of the values of a message, and of all messages.

  /// The lowest without the first `tail`. Changes the order.
  [[nodiscard]] static float Lowest(std::vector<float>& values, std::size_t tail) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(tail);
    std::ranges::nth_element(values, at);
    return *at;
  }
  [[nodiscard]] static float Highest(std::vector<float>& values, std::size_t tail) {
    return Lowest(values, values.size() - 1 - tail);
  }

  void Remember(const std::pair<float, float>& seen, std::size_t messages, std::size_t weight) {
    seen_.insert(seen_.end(), std::min(weight, kSample), seen);
    const std::size_t most = std::max(messages, kFewMessages);
    if (seen_.size() > most) seen_.erase(seen_.begin(), seen_.end() - static_cast<std::ptrdiff_t>(most));
    if (seen_.size() <= kSample) return;
    for (std::size_t i = 0; 2 * i < seen_.size(); ++i) seen_[i] = seen_[2 * i];
    seen_.resize((seen_.size() + 1) / 2);
  }

  bool Settle() {
    const std::size_t tail = seen_.size() < kFewMessages ? 0 : std::max<std::size_t>(1, seen_.size() / 128);
    sample_.resize(seen_.size());
    std::ranges::transform(seen_, sample_.begin(), [](const auto& one) { return one.first; });
    const float lowest = Lowest(sample_, tail);
    std::ranges::transform(seen_, sample_.begin(), [](const auto& one) { return one.second; });
    const float highest = Highest(sample_, tail);
    const float spread = highest - lowest;
    const float slack = (hi_ - lo_) / 20;
    const bool below = known_ && lowest < lo_ - slack;
    const bool above = known_ && highest > hi_ + slack;
    if (below || above) {
      // A range that grew once will grow again.
      const float margin = 0.25F * (std::max(hi_, highest) - std::min(lo_, lowest));
      if (below) lo_ = lowest - margin;
      if (above) hi_ = highest + margin;
      return true;
    }
    if (known_ && (spread <= 0 || 4 * spread >= hi_ - lo_)) return false;
    lo_ = lowest;
    hi_ = highest;
    known_ = true;
    return true;
  }

  bool known_ = false;
  float lo_ = 0;
  float hi_ = 1;
  std::vector<float> sample_;
  std::vector<std::pair<float, float>> seen_;  ///< Lowest and highest value of each message.
};

/// A value of a range as 8 bits.
[[nodiscard]] inline std::uint8_t EncodeIn(float lowest, float highest, float value) noexcept {
  const float unit = (value - lowest) / (highest - lowest);
  return static_cast<std::uint8_t>(std::isfinite(unit) ? std::lround(std::clamp(unit, 0.0F, 1.0F) * 255) : 0);
}

}  // namespace hgros::viewer
