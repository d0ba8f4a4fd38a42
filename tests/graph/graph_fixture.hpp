#pragma once

#include <algorithm>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hgros/graph/data_graph.hpp"
#include "support/await.hpp"

namespace hgros::test {

/// Keeps the lines that the graph logs.
class Heard {
 public:
  [[nodiscard]] std::shared_ptr<Log> MakeLog() {
    return std::make_shared<Log>([this](LogLevel, std::string_view text) {
      const std::scoped_lock lock(mutex_);
      lines_.emplace_back(text);
    });
  }
  [[nodiscard]] bool Contains(std::string_view part) const {
    const std::scoped_lock lock(mutex_);
    for (const std::string& line : lines_) {
      if (line.find(part) != std::string::npos) return true;
    }
    return false;
  }

  [[nodiscard]] std::size_t Count(std::string_view part) const {
    const std::scoped_lock lock(mutex_);
    return static_cast<std::size_t>(
        std::ranges::count_if(lines_, [&](const std::string& line) { return line.find(part) != std::string::npos; }));
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> lines_;
};

/// Collects ints from callbacks.
class Collected {
 public:
  void Add(int value) {
    const std::scoped_lock lock(mutex_);
    values_.push_back(value);
  }
  [[nodiscard]] std::vector<int> values() const {
    const std::scoped_lock lock(mutex_);
    return values_;
  }
  [[nodiscard]] std::size_t size() const {
    const std::scoped_lock lock(mutex_);
    return values_.size();
  }

 private:
  mutable std::mutex mutex_;
  std::vector<int> values_;
};

[[nodiscard]] inline NodeOptions Options(Executor executor, Queue queue = {}, std::string name = {}) {
  return {std::move(name), queue, std::move(executor)};
}

[[nodiscard]] inline std::vector<Executor> AllExecutors() {
  return {Executor::Tbb(), Executor::Inline(), Executor::Dedicated()};
}

[[nodiscard]] inline std::vector<int> Counting(int from, int to) {
  std::vector<int> values;
  for (int i = from; i < to; ++i) values.push_back(i);
  return values;
}

}  // namespace hgros::test
