#include "viewer/data/messages/number_series.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

namespace hgros::viewer {
namespace {

constexpr std::int64_t kShortestSilence = 1'000'000'000;  // ns

/// Longer times between two of these values are silence, in ns.
template <class Values>
std::int64_t LongestPause(const Values& values) {
  constexpr std::size_t kLooked = 1000;
  std::vector<std::int64_t> pauses;
  for (std::size_t i = 1; i < values.size(); i += values.size() / kLooked + 1) {
    pauses.push_back((values[i].at - values[i - 1].at).count());
  }
  if (pauses.empty()) return kShortestSilence;
  const auto usual = pauses.begin() + static_cast<std::ptrdiff_t>(pauses.size() / 2);
  std::ranges::nth_element(pauses, usual);
  return std::max(kShortestSilence, *usual < std::numeric_limits<std::int64_t>::max() / 10 ? 10 * *usual : *usual);
}

}  // namespace

void NumberSeries::Add(Time at, double value) {
  // Times up to the year 2116, so that the difference of two times cannot overflow.
  at.nanoseconds = std::clamp<std::int64_t>(at.nanoseconds, 0, std::numeric_limits<std::int64_t>::max() / 2);
  if (!values_.empty() && at < values_.back().at) {
    if (values_.back().at - at <= kSlightlyLate) return;
    values_.clear();
  }
  values_.push_back({at, value});
  while (values_.size() > most_ || values_.back().at - values_.front().at > kept_) values_.pop_front();
}

std::vector<NumberSeries::Column> NumberSeries::Columns(Time from, Time to, std::size_t columns) const {
  std::vector<Column> drawn;
  if (columns == 0 || !(from < to)) return drawn;
  const auto span = static_cast<double>(to.nanoseconds - from.nanoseconds);
  const Duration silence(LongestPause(values_));
  Time before;         // Of the last number.
  bool broken = true;  // Since then something came that is not a number, or there is none.
  for (auto value = std::ranges::lower_bound(values_, from, {}, &Value::at); value != values_.end() && value->at < to;
       ++value) {
    if (!std::isfinite(value->value)) {
      broken = true;
      continue;
    }
    const bool begins = broken || value->at - before > silence;
    before = value->at;
    broken = false;
    const auto part = static_cast<double>(value->at.nanoseconds - from.nanoseconds) / span;
    const std::size_t column = std::min(static_cast<std::size_t>(part * static_cast<double>(columns)), columns - 1);
    if (drawn.empty() || drawn.back().column != column) {
      drawn.push_back({column, value->value, value->value, value->value, value->value, begins});
      continue;
    }
    Column& last = drawn.back();
    last.least = std::min(last.least, value->value);
    last.greatest = std::max(last.greatest, value->value);
    last.last = value->value;
  }
  return drawn;
}

}  // namespace hgros::viewer
