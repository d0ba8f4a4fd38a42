#include "floor.hpp"

#include <tbb/flow_graph.h>

#include <condition_variable>
#include <mutex>
#include <thread>

namespace hgros::bench {

Samples FloorTbbLatency(int count) {
  Arrival arrival;
  tbb::flow::graph graph;
  tbb::flow::function_node<ParcelPtr> node(graph, tbb::flow::serial, [&](const ParcelPtr&) {
    arrival.Note();
    return tbb::flow::continue_msg{};
  });
  const ParcelPtr message = std::make_shared<const Parcel>(1024);
  Samples samples = MeasureLatency(count, std::chrono::microseconds(500), arrival, [&] { node.try_put(message); });
  graph.wait_for_all();
  return samples;
}

double FloorTbbThroughput(int count) {
  std::atomic<int> arrived{0};
  tbb::flow::graph graph;
  tbb::flow::function_node<ParcelPtr> node(graph, tbb::flow::serial, [&](const ParcelPtr&) {
    if (arrived.fetch_add(1, std::memory_order_relaxed) + 1 == count) arrived.notify_one();
    return tbb::flow::continue_msg{};
  });
  const ParcelPtr message = std::make_shared<const Parcel>(1024);
  const std::int64_t start = MonotonicNow();
  for (int i = 0; i < count; ++i) node.try_put(message);
  for (int seen = arrived; seen < count; seen = arrived) arrived.wait(seen);
  const double seconds = static_cast<double>(MonotonicNow() - start) / 1e9;
  graph.wait_for_all();
  return count / seconds;
}

Samples FloorThreadLatency(int count) {
  Arrival arrival;
  std::mutex mutex;
  std::condition_variable changed;
  ParcelPtr slot;
  bool stop = false;
  std::thread thread([&] {
    std::unique_lock lock(mutex);
    for (;;) {
      changed.wait(lock, [&] { return stop || slot != nullptr; });
      if (stop) return;
      const ParcelPtr taken = std::move(slot);
      slot = nullptr;
      lock.unlock();
      arrival.Note();
      lock.lock();
    }
  });
  const ParcelPtr message = std::make_shared<const Parcel>(1024);
  Samples samples = MeasureLatency(count, std::chrono::microseconds(500), arrival, [&] {
    {
      const std::scoped_lock lock(mutex);
      slot = message;
    }
    changed.notify_one();
  });
  {
    const std::scoped_lock lock(mutex);
    stop = true;
  }
  changed.notify_one();
  thread.join();
  return samples;
}

double FloorTwoThreads() {
  const auto work = [] {
    std::atomic<std::uint64_t> own{0};
    for (int i = 0; i < 20'000'000; ++i) own.fetch_add(1, std::memory_order_relaxed);
  };
  const auto run = [&](int threads) {
    const std::int64_t start = MonotonicNow();
    std::vector<std::jthread> all;
    for (int i = 0; i < threads; ++i) all.emplace_back(work);
    all.clear();
    return threads / static_cast<double>(MonotonicNow() - start);
  };
  const double one = run(1);
  return run(2) / one;
}

}  // namespace hgros::bench
