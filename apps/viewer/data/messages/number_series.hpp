#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <vector>

#include "hgros/clock/time.hpp"

namespace hgros::viewer {

/// A number over time: at most `most` values, not older than `kept`. It is drawn as the lowest and highest value of
/// each column of a plot, so that every spike is visible.
///
/// Thread safety: none. Invariants: times ascend. A value that is older than the last one by more than kSlightlyLate
/// clears the series: a clock went back. One that is slightly older, as when messages of two publishers cross, is left
/// out.
class NumberSeries {
 public:
  struct Value {
    Time at;
    double value = 0;
  };
  static constexpr Duration kSlightlyLate = std::chrono::seconds(1);

  explicit NumberSeries(Duration kept, std::size_t most = 1'000'000) : kept_(kept), most_(most) {}

  void Add(Time at, double value);
  void Clear() { values_.clear(); }
  [[nodiscard]] std::size_t size() const noexcept { return values_.size(); }
  [[nodiscard]] const std::deque<Value>& values() const noexcept { return values_; }

  /// One column of a plot.
  struct Column {
    std::size_t column = 0;
    double least = 0, greatest = 0;
    double first = 0, last = 0;
    bool begins = false;  ///< No line leads here: a value that is not a number, or silence, lies before it.
  };
  /// The values in [from, to) in `columns` of equal length. Empty columns and values that are not finite are left out.
  /// Silence is ten times the usual time between two values, and at least 1 s.
  [[nodiscard]] std::vector<Column> Columns(Time from, Time to, std::size_t columns) const;

 private:
  const Duration kept_;
  const std::size_t most_;
  std::deque<Value> values_;
};

}  // namespace hgros::viewer
