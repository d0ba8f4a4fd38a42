#include <array>

#include "graph/graph_fixture.hpp"

namespace hgros::test {
namespace {

/// A message of another session, whose number is the value's.
void Inject(DataGraph& graph, int value, std::size_t latched, std::uint64_t incarnation = 1,
            const std::string& channel = "map") {
  MessageInfo info;
  info.id = {7, incarnation, static_cast<std::uint64_t>(value) + 1};
  DataGraph::Inject(graph.Open(channel, TypeOf<int>(), CallSite::Current()), std::make_shared<const int>(value),
                    TypeOf<int>(), info, nullptr, latched);
}

class LatchOnEveryExecutor : public OnEveryExecutor {};
INSTANTIATE_TEST_SUITE_P(Latch, LatchOnEveryExecutor, testing::Values(0U, 1U, 2U));

TEST_P(LatchOnEveryExecutor, LateNodeGetsLatchedMessagesOnceAndBeforeLiveOnes) {
  DataGraph graph;
  const auto publish = graph.Advertise<int>("map", 3);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(publish(std::make_unique<int>(i)), PublishStatus::kOk);
  Collected got;
  // More than the depth of the queue: latched messages do not depend on it.
  const auto subscription = Collect(graph, got, Options(executor(), Queue::KeepLast(2)), "map");
  ASSERT_TRUE(Await([&] { return got.size() == 3; }));
  EXPECT_EQ(publish(std::make_unique<int>(10)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return got.size() == 4; }));
  EXPECT_EQ(got.values(), Counting(7, 11));
}

TEST_P(LatchOnEveryExecutor, NodesAddedDuringPublishingMissNothingAndGetNothingTwice) {
  DataGraph graph;
  constexpr int kMessages = 3000;
  const auto publish = graph.Advertise<int>("map", kMessages);
  std::jthread publisher([&] {
    for (int i = 0; i < kMessages; ++i) EXPECT_EQ(publish(std::make_unique<int>(i)), PublishStatus::kOk);
  });
  std::vector<std::unique_ptr<Collected>> all;
  std::vector<Subscription> subscriptions;
  for (int i = 0; i < 8; ++i) {
    all.push_back(std::make_unique<Collected>());
    subscriptions.push_back(Collect(graph, *all.back(), Options(executor(), Queue::KeepAll(kMessages)), "map"));
  }
  publisher.join();
  for (const auto& got : all) {
    ASSERT_TRUE(Await([&] { return got->size() >= static_cast<std::size_t>(kMessages); }));
    EXPECT_EQ(got->values(), Counting(0, kMessages));
  }
}

TEST_P(LatchOnEveryExecutor, NewNodesGetLatchedMessagesOfALostPublisherOnceWhenItReturns) {
  DataGraph graph;
  for (int i = 0; i < 3; ++i) Inject(graph, i, 2);
  graph.PublisherIsGone(7);
  Collected got;
  const auto subscription = Collect(graph, got, Options(executor()), "map");
  ASSERT_TRUE(WaitIdle(graph));
  EXPECT_EQ(got.size(), 0U) << "the publisher may be dead";
  graph.PublisherIsBack(7);
  ASSERT_TRUE(Await([&] { return got.size() == 2; }));
  graph.PublisherIsGone(7);
  graph.PublisherIsBack(7);
  Inject(graph, 3, 2);
  ASSERT_TRUE(Await([&] { return got.size() == 3; }));
  EXPECT_EQ(got.values(), Counting(1, 4));
}

// The session hears of the return on another thread than that of the messages. One graph: on a busy machine a worker of
// oneTBB needs a third of a second to leave the arena of one for that of the next.
TEST_P(LatchOnEveryExecutor, NewNodesGetLatchedMessagesOfALostPublisherBeforeItsNextOne) {
  DataGraph graph;
  for (int round = 0; round < 200; ++round) {
    const std::string channel = "map" + std::to_string(round);
    for (int i = 0; i < 3; ++i) Inject(graph, i, 3, 1, channel);
    graph.PublisherIsGone(7);
    Collected got;
    const auto subscription = Collect(graph, got, Options(executor()), channel);
    std::thread returns([&] { graph.PublisherIsBack(7); });
    Inject(graph, 3, 3, 1, channel);
    Inject(graph, 4, 3, 1, channel);
    returns.join();
    ASSERT_TRUE(Await([&] { return got.size() == 5; }));
    EXPECT_EQ(got.values(), Counting(0, 5));
  }
}

TEST(Latch, KeepsNothingOfAPublisherThatHasRestarted) {
  for (const bool lost : {false, true}) {
    const int again = lost ? 2 : 0;  // Its numbers go on, or begin again.
    DataGraph graph;
    Inject(graph, 0, 3);
    Inject(graph, 1, 3);
    if (lost) graph.PublisherIsGone(7);
    Collected got;
    const auto late = lost ? Collect(graph, got, Options(Executor::Inline()), "map") : Subscription();
    Inject(graph, again, 3, 2);
    if (lost) graph.PublisherIsBack(7);
    const auto last = lost ? Subscription() : Collect(graph, got, Options(Executor::Inline()), "map");
    EXPECT_EQ(got.values(), Counting(again, again + 1)) << lost;
  }
}

TEST(Latch, RemembersOnlyAFewLostPublishers) {
  DataGraph graph;
  Channel& channel = graph.Open("map", TypeOf<int>(), CallSite::Current());
  std::vector<std::weak_ptr<const int>> kept;
  for (std::uint64_t publisher = 1; publisher <= 10; ++publisher) {
    const auto message = std::make_shared<const int>(1);
    kept.push_back(message);
    MessageInfo info;
    info.id = {publisher, 1, 1};
    DataGraph::Inject(channel, message, TypeOf<int>(), info, nullptr, 1);
    graph.PublisherIsGone(publisher);
  }
  EXPECT_EQ(std::count_if(kept.begin(), kept.end(), [](const auto& one) { return !one.expired(); }), 4);
  EXPECT_FALSE(kept.back().expired());
}

struct Large {
  std::array<char, 1 << 20> bytes{};
};

/// A channel that gets latched messages of other sessions.
class RemoteLatch : public testing::Test {
 protected:
  template <class T>
  void Inject(std::uint64_t publisher, std::shared_ptr<const T> message, std::size_t latched) {
    Channel& channel = graph.Open("map", TypeOf<T>(), CallSite::Current());
    MessageInfo info;
    info.id = {publisher, 1, ++sequence};
    EXPECT_TRUE(DataGraph::Inject(channel, message, TypeOf<T>(), info, nullptr, latched));
    kept.emplace_back(std::move(message));
  }
  [[nodiscard]] std::vector<std::size_t> Kept() const {
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (!kept[i].expired()) numbers.push_back(i);
    }
    return numbers;
  }
  [[nodiscard]] std::uint64_t NotLatched() const { return graph.Snapshot().channels.at(0).not_latched; }

  int lines = 0;
  DataGraph graph{{}, std::make_shared<Log>([this](LogLevel, std::string_view) { ++lines; })};
  std::uint64_t sequence = 0;
  std::vector<std::weak_ptr<const void>> kept;
};

TEST_F(RemoteLatch, KeepsTheNewestBytesOfAPublisherThatLatchesEverything) {
  for (int i = 0; i < 70; ++i) Inject(7, std::make_shared<const Large>(), ~std::size_t{0} >> 1);
  EXPECT_EQ(Kept().size(), 64U);
  EXPECT_EQ(Kept().front(), 6U);
  EXPECT_EQ(NotLatched(), 6U);
  EXPECT_EQ(lines, 1);
}

TEST_F(RemoteLatch, InventedPublishersRemoveNothingOfOthers) {
  for (std::uint64_t publisher = 1; publisher <= 70; ++publisher) {
    Inject(publisher, std::make_shared<const Large>(), 1);
  }
  EXPECT_EQ(Kept().size(), 64U);
  EXPECT_EQ(Kept().front(), 0U);
  // A publisher that has its place replaces its message.
  Inject(1, std::make_shared<const Large>(), 1);
  EXPECT_EQ(Kept().back(), 70U);
  EXPECT_EQ(NotLatched(), 6U);
  EXPECT_EQ(lines, 1);
}

TEST_F(RemoteLatch, KeepsSomeThousandSmallMessages) {
  for (std::uint64_t publisher = 1; publisher <= 16'500; ++publisher) {
    Inject(publisher, std::make_shared<const int>(1), 1);
  }
  EXPECT_EQ(Kept().size(), 16384U);
}

TEST_F(RemoteLatch, PublishersThatAreGoneMakeRoom) {
  for (std::uint64_t publisher = 1; publisher <= 64; ++publisher) {
    Inject(publisher, std::make_shared<const Large>(), 1);
  }
  graph.PublisherIsGone(3);
  Inject(65, std::make_shared<const Large>(), 1);
  EXPECT_EQ(Kept().size(), 64U);
  EXPECT_EQ(Kept().back(), 64U);
  EXPECT_EQ(NotLatched(), 0U);
}

TEST_F(RemoteLatch, ASingleMessageMayBeLargerThanTheLimit) {
  struct Huge {
    std::array<char, (64 << 20) + 1> bytes;
  };
  Inject(7, std::make_shared<const Huge>(), 1);
  Inject(7, std::make_shared<const Huge>(), 1);
  EXPECT_EQ(Kept(), std::vector<std::size_t>{1});
}

TEST(Latch, ConcurrentNodeGetsLatchedMessages) {
  DataGraph graph;
  const auto publish = graph.Advertise<int>("map", 2);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(publish(std::make_unique<int>(i)), PublishStatus::kOk);
  for (const Executor& executor : AllExecutors()) {
    std::atomic<int> count{0};
    const auto subscription = graph.FromGraph<int>(
        "map", Invoke::kConcurrent, [&](const int&) { ++count; }, Options(executor));
    EXPECT_TRUE(Await([&] { return count == 2; }));
  }
}

}  // namespace
}  // namespace hgros::test
