#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hgros::cli {

/// A bar of a histogram: values from `from` up to, but without, `to`; the last bar has its end, too.
struct Bar {
  double from = 0;
  double to = 0;
  std::uint64_t count = 0;
};

/// Numbers of one kind: their mean and extremes, and the distribution of the last 10,000.
class Measurements {
 public:
  void Add(double value);

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] double min() const noexcept { return min_; }
  [[nodiscard]] double max() const noexcept { return max_; }
  [[nodiscard]] double Mean() const noexcept { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }
  /// The value that the share `q` (0 to 1) of the last ones does not exceed; 0 without values.
  [[nodiscard]] double Quantile(double q) const;
  /// Bars of equal width, which is 1, 2 or 5 times a power of ten: about `count` for almost all values. The first and
  /// the last bar reach to the extremes. Their counts sum up to the number of the last values.
  [[nodiscard]] std::vector<Bar> Bars(std::size_t count) const;

 private:
  static constexpr std::size_t kMost = 10'000;

  std::vector<double> last_;
  std::uint64_t count_ = 0;
  double sum_ = 0;
  double min_ = 0;
  double max_ = 0;
};

}  // namespace hgros::cli
