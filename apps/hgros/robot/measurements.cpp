#include "robot/measurements.hpp"

#include <algorithm>
#include <cmath>

namespace hgros::cli {
namespace {

// The smallest of 1, 2, 5, 10, 20, ... that is at least `width`.
double RoundWidth(double width) {
  const double power = std::pow(10.0, std::floor(std::log10(width)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * power >= width * 0.999999) return step * power;
  }
  return 10 * power;
}

}  // namespace

void Measurements::Add(double value) {
  min_ = count_ == 0 ? value : std::min(min_, value);
  max_ = count_ == 0 ? value : std::max(max_, value);
  sum_ += value;
  if (last_.size() < kMost) {
    last_.push_back(value);
  } else {
    last_[count_ % kMost] = value;
  }
  ++count_;
}

double Measurements::Quantile(double q) const {
  if (last_.empty()) return 0;
  std::vector<double> values = last_;
  const auto at = std::min(values.size() - 1, static_cast<std::size_t>(q * static_cast<double>(values.size())));
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(at));
  return values[at];
}

std::vector<Bar> Measurements::Bars(std::size_t count) const {
  if (last_.empty() || count == 0) return {};
  constexpr double kFew = 0.01;
  const auto [least, most] = std::ranges::minmax(last_);
  if (least == most) return {{least, most, last_.size()}};
  double low = Quantile(kFew);
  double high = Quantile(1 - kFew);
  if (low == high) {
    low = least;
    high = most;
  }
  const double width = RoundWidth((high - low) / static_cast<double>(count));
  const double from = std::floor(low / width);
  const auto bars = static_cast<std::size_t>(std::max(std::floor(high / width) - from, 0.0)) + 1;
  std::vector<Bar> all(bars);
  for (std::size_t i = 0; i < bars; ++i) {
    all[i].from = (from + static_cast<double>(i)) * width;
    all[i].to = (from + static_cast<double>(i + 1)) * width;
  }
  for (const double value : last_) {
    const double place = std::clamp(std::floor(value / width) - from, 0.0, static_cast<double>(bars - 1));
    ++all[static_cast<std::size_t>(place)].count;
  }
  all.front().from = std::min(all.front().from, least);
  all.back().to = std::max(all.back().to, most);
  return all;
}

}  // namespace hgros::cli
