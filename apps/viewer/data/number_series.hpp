#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <vector>

#include "hgros/clock/time.hpp"

namespace hgros::viewer {

/// A number over time, kept for as long as `kept` and at most `most` values; drawn as the least and the greatest of
/// each column of a plot, so that no spike is lost however many values there are.
///
/// Thread safety: none.
/// Invariants: times ascend; one that is older than the last by more than kSlightlyLate (a clock that went back) begins
/// anew, one that is less so (of two publishers whose messages cross) is left out.
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
  };
  /// What lies in [from, to), cut into `columns` of equal length; columns without a value are left out. What is no
  /// finite number is left out too.
  [[nodiscard]] std::vector<Column> Columns(Time from, Time to, std::size_t columns) const;

 private:
  const Duration kept_;
  const std::size_t most_;
  std::deque<Value> values_;
};

}  // namespace hgros::viewer
