#include "ours.hpp"

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "hgros/graph/data_graph.hpp"
#include "message.hpp"
#include "support/handoff.hpp"

namespace hgros::bench {
namespace {

NodeOptions On(const Executor& executor, Queue queue = {}) { return {{}, queue, executor}; }

}  // namespace

double InlineHandle(std::size_t size_bytes, int count) {
  DataGraph graph;
  std::size_t seen = 0;
  const auto subscription = graph.FromGraph<Parcel>(
      "parcels", Invoke::kSerial, [&](const Parcel& parcel) { seen += parcel.bytes.size(); }, On(Executor::Inline()));
  const auto publish = graph.Advertise<Parcel>("parcels");
  const ParcelPtr message = std::make_shared<const Parcel>(size_bytes);
  const std::int64_t start = MonotonicNow();
  for (int i = 0; i < count; ++i) (void)publish(message);
  return static_cast<double>(MonotonicNow() - start) / count;
}

double InlineNamed(int count) {
  DataGraph graph;
  std::size_t seen = 0;
  const auto subscription = graph.FromGraph<Parcel>(
      "parcels", Invoke::kSerial, [&](const Parcel& parcel) { seen += parcel.bytes.size(); }, On(Executor::Inline()));
  const ParcelPtr message = std::make_shared<const Parcel>(1024);
  const std::int64_t start = MonotonicNow();
  for (int i = 0; i < count; ++i) (void)graph.ToGraph("parcels", message);
  return static_cast<double>(MonotonicNow() - start) / count;
}

double NamedThroughput(int threads, int count) {
  DataGraph graph;
  std::vector<Subscription> subscriptions;
  for (int t = 0; t < threads; ++t) {
    subscriptions.push_back(graph.FromGraph<Parcel>(
        "parcels" + std::to_string(t), Invoke::kSerial, [](const Parcel&) {}, On(Executor::Inline())));
  }
  std::atomic<bool> go{false};
  std::vector<std::jthread> publishers;
  for (int t = 0; t < threads; ++t) {
    publishers.emplace_back([&, channel = "parcels" + std::to_string(t)] {
      const ParcelPtr message = std::make_shared<const Parcel>(1024);
      go.wait(false);
      for (int i = 0; i < count; ++i) (void)graph.ToGraph(channel, message);
    });
  }
  const std::int64_t start = MonotonicNow();
  go = true;
  go.notify_all();
  publishers.clear();
  return threads * static_cast<double>(count) / (static_cast<double>(MonotonicNow() - start) / 1e9);
}

Samples Latency(const Executor& executor, int count) {
  Arrival arrival;
  DataGraph graph;
  const auto subscription = graph.FromGraph<Parcel>(
      "parcels", Invoke::kSerial, [&](const Parcel&) { arrival.Note(); }, On(executor));
  const auto publish = graph.Advertise<Parcel>("parcels");
  const ParcelPtr message = std::make_shared<const Parcel>(1024);
  return MeasureLatency(count, std::chrono::microseconds(500), arrival, [&] { (void)publish(message); });
}

double TbbThroughput(int count) {
  std::atomic<int> arrived{0};
  DataGraph graph;
  const auto subscription = graph.FromGraph<Parcel>(
      "parcels", Invoke::kSerial,
      [&](const Parcel&) {
        if (arrived.fetch_add(1, std::memory_order_relaxed) + 1 == count) arrived.notify_one();
      },
      On(Executor::Tbb(), Queue::KeepAll(static_cast<std::size_t>(count))));
  const auto publish = graph.Advertise<Parcel>("parcels");
  const ParcelPtr message = std::make_shared<const Parcel>(1024);
  const std::int64_t start = MonotonicNow();
  for (int i = 0; i < count; ++i) (void)publish(message);
  for (int seen = arrived; seen < count; seen = arrived) arrived.wait(seen);
  return count / (static_cast<double>(MonotonicNow() - start) / 1e9);
}

double Fanout20Inline(int count) {
  DataGraph graph;
  std::vector<Subscription> subscriptions;
  for (int i = 0; i < 20; ++i) {
    subscriptions.push_back(graph.FromGraph<Parcel>(
        "parcels", Invoke::kSerial, [](const Parcel&) {}, On(Executor::Inline())));
  }
  const auto publish = graph.Advertise<Parcel>("parcels");
  const ParcelPtr message = std::make_shared<const Parcel>(1024);
  const std::int64_t start = MonotonicNow();
  for (int i = 0; i < count; ++i) (void)publish(message);
  return static_cast<double>(MonotonicNow() - start) / (20.0 * count);
}

double Fanout20Tbb(int count) {
  std::atomic<int> arrived{0};
  const int expected = 20 * count;
  DataGraph graph;
  std::vector<Subscription> subscriptions;
  for (int i = 0; i < 20; ++i) {
    subscriptions.push_back(graph.FromGraph<Parcel>(
        "parcels", Invoke::kSerial,
        [&](const Parcel&) {
          if (arrived.fetch_add(1, std::memory_order_relaxed) + 1 == expected) arrived.notify_one();
        },
        On(Executor::Tbb(), Queue::KeepAll(static_cast<std::size_t>(count)))));
  }
  const auto publish = graph.Advertise<Parcel>("parcels");
  const ParcelPtr message = std::make_shared<const Parcel>(1024);
  const std::int64_t start = MonotonicNow();
  for (int i = 0; i < count; ++i) (void)publish(message);
  for (int seen = arrived; seen < expected; seen = arrived) arrived.wait(seen);
  return static_cast<double>(MonotonicNow() - start) / expected;
}

Samples Pipeline10(const Executor& executor, int count) {
  Arrival arrival;
  DataGraph graph;
  std::vector<Subscription> nodes;
  std::vector<Publisher<Parcel>> publishers;
  for (int i = 0; i < 10; ++i) publishers.push_back(graph.Advertise<Parcel>("stage" + std::to_string(i)));
  for (int i = 0; i < 10; ++i) {
    nodes.push_back(graph.FromGraph<Parcel>(
        "stage" + std::to_string(i), Invoke::kSerial,
        [&, i](const ParcelPtr& parcel) {
          if (i == 9) {
            arrival.Note();
          } else {
            (void)publishers[static_cast<std::size_t>(i) + 1](parcel);
          }
        },
        On(executor)));
  }
  const ParcelPtr message = std::make_shared<const Parcel>(1024);
  return MeasureLatency(count, std::chrono::microseconds(500), arrival, [&] { (void)publishers[0](message); });
}

}  // namespace hgros::bench
