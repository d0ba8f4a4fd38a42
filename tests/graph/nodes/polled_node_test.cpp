#include "graph/nodes/polled_node.hpp"

#include <poll.h>

#include <optional>

#include "graph/graph_fixture.hpp"

namespace hgros::test {
namespace {

bool IsReadable(int descriptor, std::chrono::milliseconds patience = {}) {
  pollfd one{descriptor, POLLIN, 0};
  return poll(&one, 1, static_cast<int>(patience.count())) == 1;
}

Subscription Polled(DataGraph& graph, Collected& taken, Queue queue = {}, std::string name = {}) {
  return Collect(graph, taken, Options(Executor::Polled(), queue, std::move(name)));
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

TEST(PolledNode, DescriptorIsReadableWhileMessagesWaitAndForLatchedOnes) {
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
  const auto publish = graph.Advertise<int>("latched", 2);
  (void)publish(7);
  Subscription late = Collect(graph, taken, Options(Executor::Polled()), "latched");
  EXPECT_TRUE(IsReadable(late.descriptor()));
  EXPECT_EQ(late.RunWaiting(5), 1U);
  EXPECT_FALSE(IsReadable(late.descriptor()));
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
      while (taken.size() < kMessages && IsReadable(descriptor, kPatience)) (void)subscription.RunWaiting();
    });
  }
  const auto publish = graph->Advertise<int>("c");
  for (int i = 0; i < kMessages; ++i) {
    ASSERT_EQ(publish.Wait(std::make_unique<int>(i), std::chrono::steady_clock::now() + kPatience), PublishStatus::kOk);
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
  Subscription subscription = Polled(graph, taken, {}, "mine");
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

// A publisher that has found the queue full waits for on_room.
TEST(QueuedNode, TellsOfTheRoomThatWasReservedBeforeItClosed) {
  int told = 0;
  NodeSetting setting;
  setting.queue = Queue::KeepAll(1);
  setting.executor = Executor::Polled();
  setting.on_room = [&told] { ++told; };
  PolledNode node(std::move(setting), [](const AnyMessage&, const MessageInfo&) {});
  ASSERT_TRUE(node.Reserve(0));
  node.Close(false);
  ASSERT_FALSE(node.Reserve(0)) << "The other publisher's message may still come.";
  const int before = told;
  AnyMessage message = std::make_shared<const int>(1);
  const MessageInfo info;
  const std::shared_ptr<const void> no_credit;
  std::int64_t now = 0;
  node.Deliver({message, info, no_credit}, true, now);
  EXPECT_EQ(told, before + 1);
  EXPECT_TRUE(node.Reserve(0));
}

}  // namespace
}  // namespace hgros::test
