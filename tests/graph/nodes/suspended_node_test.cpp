#include "graph/graph_fixture.hpp"
#include "hgros/graph/node_queue.hpp"

namespace hgros::test {
namespace {

constexpr int kMessages = 500;

struct Way {
  const char* name;
  Invoke invoke;
  Executor executor;
};
void PrintTo(const Way& way, std::ostream* out) { *out << way.name; }

// A call without a message is collected as the negative number of its MessageInfo.
class SuspendedNode : public testing::TestWithParam<Way> {
 protected:
  void Publish(int from, int to) {
    for (int i = from; i < to; ++i) EXPECT_EQ(graph_.ToGraph("c", std::make_unique<int>(i)), PublishStatus::kOk);
  }
  void Call(std::uint64_t number) const {
    MessageInfo info;
    info.number = number;
    queue_.CallWithoutMessage(info);
  }
  // Those that come now wait.
  void SuspendAndPublish() {
    Publish(0, 1);
    ASSERT_TRUE(Await([&] { return taken_.size() == 1; }));
    queue_.Suspend(true);
    Publish(1, kMessages);
  }
  [[nodiscard]] bool serial() const { return GetParam().invoke == Invoke::kSerial; }

  DataGraph graph_;
  Collected taken_;
  Subscription subscription_ = graph_.FromGraph<int>(
      "c", GetParam().invoke,
      [this](const std::shared_ptr<const int>& value, const MessageInfo& info) {
        taken_.Add(value ? *value : -static_cast<int>(info.number));
      },
      Options(GetParam().executor, Queue::KeepAll(kMessages)));
  const NodeQueue queue_{subscription_};
};

TEST_P(SuspendedNode, KeepsMessagesInItsQueueUntilItGoesOn) {
  SuspendAndPublish();
  EXPECT_EQ(subscription_.stats().queued, kMessages - 1U);
  EXPECT_EQ(graph_.ToGraph("c", std::make_unique<int>(kMessages)), PublishStatus::kOk);
  EXPECT_EQ(graph_.ToGraph("c", std::make_unique<int>(kMessages)), PublishStatus::kFull) << "its limit holds";
  EXPECT_EQ(taken_.size(), 1U);
  queue_.Suspend(false);
  EXPECT_TRUE(Await([&] { return taken_.size() == kMessages + 1U; }));
  if (serial()) {
    EXPECT_EQ(taken_.values(), Counting(0, kMessages + 1));
  }
  queue_.Suspend(true);
  queue_.Suspend(false);
  Publish(1, 2);
  EXPECT_TRUE(Await([&] { return taken_.size() == kMessages + 2U; }));
}

TEST_P(SuspendedNode, IsCalledWithoutAMessageBeforeThoseThatWait) {
  SuspendAndPublish();
  for (std::uint64_t number = 1; number <= 20; ++number) {
    Call(number);
    ASSERT_TRUE(number % 5 != 0 || Await([&] { return taken_.size() == 1 + number; })) << "while they wait";
  }
  EXPECT_EQ(subscription_.stats().queued, kMessages - 1U);
  for (std::uint64_t number = 21; number <= 40; ++number) Call(number);
  queue_.Suspend(false);
  EXPECT_TRUE(Await([&] { return taken_.size() == kMessages + 40U; }));
  std::vector<int> expected = {0};
  for (int number = 1; number <= 40; ++number) expected.push_back(-number);
  for (int i = 1; i < kMessages; ++i) expected.push_back(i);
  if (serial()) {
    EXPECT_EQ(taken_.values(), expected);
  }
  EXPECT_EQ(subscription_.stats().received, static_cast<unsigned>(kMessages)) << "calls are no messages";
}

TEST_P(SuspendedNode, CanEnd) {
  SuspendAndPublish();
  subscription_.Reset();
  queue_.Suspend(false);  // There is nothing any more.
  Call(1);
  queue_.CountDropped();
  EXPECT_EQ(taken_.size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Ways, SuspendedNode,
                         testing::Values(Way{"serial", Invoke::kSerial, Executor::Tbb()},
                                         Way{"concurrent", Invoke::kConcurrent, Executor::Tbb()},
                                         Way{"dedicated", Invoke::kSerial, Executor::Dedicated()}),
                         [](const testing::TestParamInfo<Way>& one) { return std::string(one.param.name); });

TEST(SuspendedPolledNode, IsReadableOnlyIfSomethingMayRun) {
  DataGraph graph;
  int calls = 0;
  Subscription subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&calls](const std::shared_ptr<const int>& value) { calls += value ? 1 : 10; },
      Options(Executor::Polled(), Queue::KeepAll(10)));
  const NodeQueue queue(subscription);
  queue.Suspend(true);
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(1)), PublishStatus::kOk);
  EXPECT_EQ(subscription.RunWaiting(5), 0U);
  queue.CallWithoutMessage({});
  EXPECT_EQ(subscription.RunWaiting(5), 1U);
  EXPECT_EQ(calls, 10);
  queue.Suspend(false);
  EXPECT_EQ(subscription.RunWaiting(5), 1U);
  EXPECT_EQ(calls, 11);
}

TEST(NodeQueue, IsNoneWithoutAQueue) {
  EXPECT_FALSE(NodeQueue());
  EXPECT_FALSE(NodeQueue(Subscription()));
  DataGraph graph;
  Collected taken;
  EXPECT_FALSE(NodeQueue(Collect(graph, taken, Options(Executor::Inline()))));
}

}  // namespace
}  // namespace hgros::test
