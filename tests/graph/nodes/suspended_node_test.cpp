#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>

#include "graph/graph_fixture.hpp"
#include "hgros/graph/running_node.hpp"

namespace hgros {
namespace {

using test::Await;
using test::Collected;
using test::Counting;
using test::Options;

constexpr int kMessages = 500;

struct Way {
  const char* name;
  Invoke invoke;
  Executor executor;
};
void PrintTo(const Way& way, std::ostream* out) { *out << way.name; }

// Its first callback suspends the node.
class SuspendedNode : public testing::TestWithParam<Way> {
 protected:
  [[nodiscard]] Subscription Subscribe() {
    return graph_.FromGraph<int>(
        "c", GetParam().invoke,
        [this](const int& value) {
          taken_.Add(value);
          if (value != 0) return;
          suspend_ = SuspenderOfRunningNode();
          suspend_(true);
          suspended_ = true;
        },
        Options(GetParam().executor, Queue::KeepAll(kMessages)));
  }
  void Publish(int from, int to) {
    for (int i = from; i < to; ++i) EXPECT_EQ(graph_.ToGraph("c", std::make_unique<int>(i)), PublishStatus::kOk);
  }
  // Those that come now wait.
  void SuspendAndPublish() {
    Publish(0, 1);
    ASSERT_TRUE(Await([&] { return suspended_.load(); }));
    Publish(1, kMessages);
  }

  DataGraph graph_;
  Collected taken_;
  std::function<void(bool)> suspend_;
  std::atomic<bool> suspended_ = false;
};

TEST_P(SuspendedNode, KeepsMessagesInItsQueueUntilItGoesOn) {
  const Subscription subscription = Subscribe();
  SuspendAndPublish();
  EXPECT_EQ(subscription.stats().queued, kMessages - 1U);
  EXPECT_EQ(graph_.ToGraph("c", std::make_unique<int>(kMessages)), PublishStatus::kOk);
  EXPECT_EQ(graph_.ToGraph("c", std::make_unique<int>(kMessages)), PublishStatus::kFull) << "its limit holds";
  EXPECT_EQ(taken_.size(), 1U);
  suspend_(false);
  EXPECT_TRUE(Await([&] { return taken_.size() == kMessages + 1U; }));
  if (GetParam().invoke == Invoke::kSerial) {
    EXPECT_EQ(taken_.values(), Counting(0, kMessages + 1));
  }
  suspend_(true);
  suspend_(false);
  Publish(1, 2);
  EXPECT_TRUE(Await([&] { return taken_.size() == kMessages + 2U; }));
}

TEST_P(SuspendedNode, CanEnd) {
  Subscription subscription = Subscribe();
  SuspendAndPublish();
  subscription.Reset();
  suspend_(false);  // There is nothing any more.
  EXPECT_EQ(taken_.size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Ways, SuspendedNode,
                         testing::Values(Way{"serial", Invoke::kSerial, Executor::Tbb()},
                                         Way{"concurrent", Invoke::kConcurrent, Executor::Tbb()},
                                         Way{"dedicated", Invoke::kSerial, Executor::Dedicated()}),
                         [](const testing::TestParamInfo<Way>& one) { return std::string(one.param.name); });

TEST(RunningNode, HasNoSuspenderWithoutAQueue) {
  EXPECT_EQ(SuspenderOfRunningNode(), nullptr) << "this is no callback";
  DataGraph graph;
  bool has = true;
  const Subscription subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&has](const int&) { has = SuspenderOfRunningNode() != nullptr; },
      Options(Executor::Inline()));
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(1)), PublishStatus::kOk);
  EXPECT_FALSE(has);
}

}  // namespace
}  // namespace hgros
