#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "clock/lines.hpp"
#include "hgros/graph/data_graph.hpp"
#include "support/await.hpp"

namespace hgros::test {

/// Keeps the lines that the graph logs.
struct Heard : Lines {
  [[nodiscard]] std::shared_ptr<Log> MakeLog() { return std::make_shared<Log>(Sink()); }
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
  [[nodiscard]] std::size_t size() const { return values().size(); }

 private:
  mutable std::mutex mutex_;
  std::vector<int> values_;
};

/// A door that counts those that have come to it.
class CountingDoor : private Door {
 public:
  using Door::Open;
  void Pass() {
    ++came;
    Door::Pass();
  }
  [[nodiscard]] bool AwaitOne() const {
    return Await([this] { return came > 0; });
  }
  std::atomic<int> came{0};
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

[[nodiscard]] inline GraphOptions Workers(int threads) {
  return {.threads = threads, .overrides = {}, .publisher = {}};
}

[[nodiscard]] inline Subscription Collect(DataGraph& graph, Collected& into, NodeOptions options,
                                          std::string_view channel = "c") {
  return graph.FromGraph<int>(
      channel, Invoke::kSerial, [&into](const int& value) { into.Add(value); }, std::move(options));
}

[[nodiscard]] inline bool WaitIdle(const DataGraph& graph) {
  return graph.WaitIdle(std::chrono::steady_clock::now() + kPatience);
}

/// Calls action(t, 0), action(t, 1)... in each of these threads t, and waits for their ends.
inline void InThreads(int threads, int each, const std::function<void(int, int)>& action) {
  std::vector<std::jthread> running;
  for (int t = 0; t < threads; ++t) {
    running.emplace_back([&action, each, t] {
      for (int i = 0; i < each; ++i) action(t, i);
    });
  }
}

/// Keeps the messages of a subscription.
template <class T>
class KeptMessages {
 public:
  void operator()(const std::shared_ptr<const T>& message) {
    const std::scoped_lock lock(mutex_);
    messages_.push_back(message);
  }
  [[nodiscard]] std::vector<std::shared_ptr<const T>> messages() const {
    const std::scoped_lock lock(mutex_);
    return messages_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<const T>> messages_;
};

/// The parameter is the number of an executor.
class OnEveryExecutor : public testing::TestWithParam<std::size_t> {
 protected:
  [[nodiscard]] static Executor executor() { return AllExecutors().at(GetParam()); }
};

}  // namespace hgros::test
