#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "hgros/clock/time.hpp"

namespace hgros::bench {

/// Durations or other numbers of one kind, in one unit.
class Samples {
 public:
  void Add(double value) { values_.push_back(value); }
  void Add(const Samples& other) { values_.insert(values_.end(), other.values_.begin(), other.values_.end()); }
  [[nodiscard]] std::size_t size() const { return values_.size(); }
  [[nodiscard]] double Quantile(double q) const {
    if (values_.empty()) return 0;
    std::vector<double> sorted = values_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(q * static_cast<double>(sorted.size())))];
  }
  [[nodiscard]] double Median() const { return Quantile(0.5); }
  [[nodiscard]] double Mean() const {
    double sum = 0;
    for (const double value : values_) sum += value;
    return values_.empty() ? 0 : sum / static_cast<double>(values_.size());
  }

 private:
  std::vector<double> values_;
};

/// Prints one line of the result: metric,value,unit. The runner turns the lines into a table.
inline void Report(const std::string& metric, double value, const char* unit) {
  std::printf("%s,%.6g,%s\n", metric.c_str(), value, unit);
  std::fflush(stdout);
}

/// Median, mean and tail of latencies in ns, as us.
inline void ReportLatency(const std::string& name, const Samples& nanoseconds) {
  Report(name + "_us", nanoseconds.Median() / 1e3, "us");
  Report(name + "_mean_us", nanoseconds.Mean() / 1e3, "us");
  Report(name + "_p99_us", nanoseconds.Quantile(0.99) / 1e3, "us");
}

}  // namespace hgros::bench
