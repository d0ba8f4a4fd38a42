#include "viewer/data/messages/number_series.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace hgros::viewer {

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
  for (auto value = std::ranges::lower_bound(values_, from, {}, &Value::at); value != values_.end() && value->at < to;
       ++value) {
    if (!std::isfinite(value->value)) continue;
    const auto part = static_cast<double>(value->at.nanoseconds - from.nanoseconds) / span;
    const std::size_t column = std::min(static_cast<std::size_t>(part * static_cast<double>(columns)), columns - 1);
    if (drawn.empty() || drawn.back().column != column) {
      drawn.push_back({column, value->value, value->value, value->value, value->value});
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
