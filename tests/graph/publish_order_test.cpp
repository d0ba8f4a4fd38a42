// Messages arrive everywhere in the order in which they were published, even if an inline callback publishes them.
#include <list>

#include "graph/graph_fixture.hpp"

namespace hgros::test {
namespace {

/// Collects the messages that leave the process.
class Border final : public Outlet {
 public:
  [[nodiscard]] bool wanted() const noexcept override { return true; }
  PublishStatus Reserve(const void*, const TypeInfo&, PreparedMessage&) noexcept override { return PublishStatus::kOk; }
  bool Commit(const AnyMessage& message, const TypeInfo&, const MessageInfo&, PreparedMessage&&) noexcept override {
    left.Add(*static_cast<const int*>(message.get()));
    return true;
  }
  void Cancel() noexcept override {}

  Collected left;
};

class PublishOrder : public testing::TestWithParam<Invoke> {
 protected:
  void CollectOn(std::string_view channel, const Executor& executor, Queue queue = {}) {
    nodes_.push_back(Collect(graph_, collected_.emplace_back(), Options(executor, queue), channel));
  }
  // An inline node that answers each number below `end` with the next one.
  void CountOn(std::string_view channel, Publisher<int> answer, int end, Queue queue = {}) {
    const auto answer_next = [answer, end](int value) {
      if (value < end) {
        EXPECT_EQ(answer(value + 1), PublishStatus::kOk);
      }
    };
    nodes_.push_back(graph_.FromGraph<int>(channel, GetParam(), answer_next, Options(Executor::Inline(), queue)));
  }
  // A handle that also publishes to other sessions.
  Publisher<int> ToBorder(std::string_view channel) {
    Channel& opened = graph_.Open(channel, TypeOf<int>(), CallSite::Current());
    graph_.SetOutlet(opened, border_);
    return {graph_.Share(opened), Reach::kAny};
  }
  void ExpectEverywhere(const std::vector<int>& values) {
    ASSERT_TRUE(WaitIdle(graph_));
    for (const Collected& one : collected_) EXPECT_EQ(one.values(), values);
  }

  std::list<Collected> collected_;
  std::shared_ptr<Border> border_ = std::make_shared<Border>();
  DataGraph graph_;
  std::vector<Subscription> nodes_;
};

TEST_P(PublishOrder, HoldsWhenAnInlineCallbackPublishesOnItsOwnChannel) {
  const auto publish = ToBorder("c");
  CollectOn("c", Executor::Inline());
  CountOn("c", publish, 5);
  for (const Executor& executor : AllExecutors()) CollectOn("c", executor);
  EXPECT_EQ(publish(0), PublishStatus::kOk);
  ExpectEverywhere(Counting(0, 6));
  EXPECT_EQ(border_->left.values(), Counting(0, 6));
}

TEST_P(PublishOrder, HoldsWhenAMessageReturnsOverAnotherChannel) {
  const auto there = ToBorder("there");
  const auto back = graph_.Advertise<int>("back");
  CountOn("there", back, 5);
  CountOn("back", there, 5);
  CollectOn("there", Executor::Inline());
  EXPECT_EQ(there(0), PublishStatus::kOk);
  ExpectEverywhere({0, 2, 4});
  EXPECT_EQ(border_->left.values(), (std::vector<int>{0, 2, 4}));
}

TEST_P(PublishOrder, HoldsForLosslessAndLatchedChannels) {
  const auto publish = graph_.Advertise<int>("c", 3);
  CountOn("c", publish, 5, Queue::KeepAll(10));
  CollectOn("c", Executor::Inline(), Queue::KeepAll(10));
  CollectOn("c", Executor::Dedicated());
  EXPECT_EQ(publish(0), PublishStatus::kOk);
  ExpectEverywhere(Counting(0, 6));
  CollectOn("c", Executor::Inline());
  EXPECT_EQ(collected_.back().values(), Counting(3, 6));
}

TEST_P(PublishOrder, HoldsForTheOnlyLosslessNodeAmongOthers) {
  const auto publish = graph_.Advertise<int>("c");
  CountOn("c", publish, 5, Queue::KeepAll(10));
  CollectOn("c", Executor::Inline());
  EXPECT_EQ(publish(0), PublishStatus::kOk);
  ExpectEverywhere(Counting(0, 6));
}

INSTANTIATE_TEST_SUITE_P(Inline, PublishOrder, testing::Values(Invoke::kSerial, Invoke::kConcurrent),
                         [](const auto& one) { return one.param == Invoke::kSerial ? "Serial" : "Concurrent"; });

}  // namespace
}  // namespace hgros::test
