#include <gtest/gtest.h>
#include <poll.h>

#include <optional>
#include <thread>

#include "graph/graph_fixture.hpp"

namespace hgros {
namespace {

using test::Await;
using test::Collected;
using test::Counting;
using test::Options;

bool IsReadable(int descriptor, std::chrono::milliseconds patience = {}) {
  pollfd one{descriptor, POLLIN, 0};
  return poll(&one, 1, static_cast<int>(patience.count())) == 1;
}

Subscription Polled(DataGraph& graph, Collected& taken, Queue queue = {}) {
  return graph.FromGraph<int>(
      "c", Invoke::kSerial, [&taken](const int& value) { taken.Add(value); }, Options(Executor::Polled(), queue));
}

TEST(PolledNode, RunsOneWaitingMessageOnTheCallingThread) {
  DataGraph graph;
  std::thread::id ran;
  auto subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&ran](const int&) { ran = std::this_thread::get_id(); }, Options(Executor::Polled()));
  EXPECT_EQ(subscription.RunWaiting(), 0U);
  (void)graph.ToGraph("c", std::make_unique<int>(1));
  (void)graph.ToGraph("c", std::make_unique<int>(2));
  EXPECT_EQ(ran, std::thread::id()) << "nobody has called RunWaiting";
  EXPECT_EQ(subscription.RunWaiting(), 1U);
  EXPECT_EQ(ran, std::this_thread::get_id());
  EXPECT_EQ(subscription.stats().queued, 1U);
  EXPECT_EQ(subscription.RunWaiting(10), 1U);
}

TEST(PolledNode, DescriptorIsReadableWhileMessagesWait) {
  DataGraph graph;
  Collected taken;
  Subscription subscription = Polled(graph, taken);
  ASSERT_GE(subscription.descriptor(), 0);
  EXPECT_FALSE(IsReadable(subscription.descriptor()));
  (void)graph.ToGraph("c", std::make_unique<int>(0));
  (void)graph.ToGraph("c", std::make_unique<int>(1));
  EXPECT_TRUE(IsReadable(subscription.descriptor()));
  EXPECT_EQ(subscription.RunWaiting(), 1U);
  EXPECT_TRUE(IsReadable(subscription.descriptor()));
  EXPECT_EQ(subscription.RunWaiting(), 1U);
  EXPECT_FALSE(IsReadable(subscription.descriptor()));
  EXPECT_EQ(taken.values(), Counting(0, 2));
}

TEST(PolledNode, DescriptorIsReadableForLatchedMessages) {
  DataGraph graph;
  const auto publish = graph.Advertise<int>("c", 2);
  (void)publish(7);
  Collected taken;
  Subscription subscription = Polled(graph, taken);
  EXPECT_TRUE(IsReadable(subscription.descriptor()));
  EXPECT_EQ(subscription.RunWaiting(5), 1U);
  EXPECT_FALSE(IsReadable(subscription.descriptor()));
}

TEST(PolledNode, DropsTheOldestAndCountsIt) {
  DataGraph graph;
  Collected taken;
  Subscription subscription = Polled(graph, taken, Queue::KeepLast(3));
  for (int i = 0; i < 10; ++i) (void)graph.ToGraph("c", std::make_unique<int>(i));
  EXPECT_EQ(subscription.stats().dropped, 7U);
  EXPECT_EQ(subscription.RunWaiting(10), 3U);
  EXPECT_EQ(taken.values(), Counting(7, 10));
}

TEST(PolledNode, LosslessQueueHoldsBackThePublisherUntilOneIsTaken) {
  DataGraph graph;
  Collected taken;
  Subscription subscription = Polled(graph, taken, Queue::KeepAll(2));
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(0)), PublishStatus::kOk);
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(1)), PublishStatus::kOk);
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(2)), PublishStatus::kFull);
  EXPECT_EQ(subscription.RunWaiting(1), 1U) << "exactly one, although a block of messages could be taken";
  EXPECT_EQ(subscription.stats().queued, 1U);
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(2)), PublishStatus::kOk);
  EXPECT_EQ(subscription.RunWaiting(5), 2U);
  EXPECT_EQ(taken.values(), Counting(0, 3));
}

TEST(PolledNode, EachMessageGoesToOneOfSeveralThreads) {
  constexpr int kMessages = 2000;
  std::optional<DataGraph> graph(std::in_place);
  Collected taken;
  Subscription subscription = Polled(*graph, taken, Queue::KeepAll(8));
  const int descriptor = subscription.descriptor();
  std::vector<std::thread> takers;
  for (int i = 0; i < 3; ++i) {
    takers.emplace_back([&] {
      while (taken.size() < kMessages && IsReadable(descriptor, test::kPatience)) (void)subscription.RunWaiting();
    });
  }
  const auto publish = graph->Advertise<int>("c");
  for (int i = 0; i < kMessages; ++i) {
    ASSERT_EQ(publish.Wait(std::make_unique<int>(i), std::chrono::steady_clock::now() + test::kPatience),
              PublishStatus::kOk);
  }
  ASSERT_TRUE(Await([&] { return taken.size() == kMessages; }));
  graph.reset();  // Wakes those that wait for more.
  for (std::thread& taker : takers) taker.join();
  std::vector<int> values = taken.values();
  std::ranges::sort(values);
  EXPECT_EQ(values, Counting(0, kMessages));
}

TEST(PolledNode, EndOfTheGraphWakesAndDoesNotWaitForMessages) {
  Collected taken;
  Subscription subscription;
  {
    DataGraph graph;
    subscription = Polled(graph, taken);
    (void)graph.ToGraph("c", std::make_unique<int>(0));
    EXPECT_TRUE(graph.WaitIdle(std::chrono::steady_clock::now())) << "a message that nobody takes is not waited for";
    EXPECT_EQ(subscription.RunWaiting(), 1U);
    (void)graph.ToGraph("c", std::make_unique<int>(1));
  }
  EXPECT_TRUE(IsReadable(subscription.descriptor()));
  EXPECT_EQ(subscription.RunWaiting(), 0U);
  EXPECT_EQ(taken.size(), 1U);
}

TEST(PolledNode, ConfigurationDoesNotReplaceTheExecutor) {
  GraphOptions options;
  options.overrides["mine"] = {Queue::KeepLast(1), Executor::Tbb()};
  DataGraph graph(options);
  Collected taken;
  NodeOptions node = Options(Executor::Polled());
  node.name = "mine";
  auto subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&taken](const int& value) { taken.Add(value); }, node);
  (void)graph.ToGraph("c", std::make_unique<int>(0));
  (void)graph.ToGraph("c", std::make_unique<int>(1));
  EXPECT_EQ(subscription.RunWaiting(5), 1U);
  EXPECT_EQ(subscription.stats().executor.kind(), Executor::Kind::kPolled);
}

TEST(PolledNode, OtherExecutorsHaveNoDescriptorAndNothingToRun) {
  DataGraph graph;
  auto subscription = graph.FromGraph<int>("c", Invoke::kSerial, [](const int&) {});
  EXPECT_EQ(subscription.descriptor(), -1);
  EXPECT_EQ(subscription.RunWaiting(), 0U);
  EXPECT_EQ(Subscription().descriptor(), -1);
}

}  // namespace
}  // namespace hgros
