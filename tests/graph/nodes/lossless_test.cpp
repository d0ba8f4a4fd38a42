#include "graph/graph_fixture.hpp"
#include "hgros/internal/graph/outlet.hpp"

namespace hgros::test {
namespace {

using std::chrono::steady_clock;

TEST(Lossless, FullNodeFailsThePublishForAllNodes) {
  DataGraph graph;
  Door door;
  Collected slow;
  Collected quick;
  const auto hold = [&](const int& value) {
    slow.Add(value);
    door.Pass();
  };
  const auto full = graph.FromGraph<int>("c", Invoke::kSerial, hold, Options(Executor::Dedicated(), Queue::KeepAll(2)));
  const auto other = Collect(graph, quick, Options(Executor::Inline()));
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(0)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return slow.size() == 1; }));
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(1)), PublishStatus::kOk);
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(2)), PublishStatus::kOk);
  auto refused = std::make_unique<int>(3);
  EXPECT_EQ(graph.ToGraph("c", std::move(refused)), PublishStatus::kFull);
  ASSERT_NE(refused, nullptr) << "the caller still owns it";
  EXPECT_EQ(quick.values(), Counting(0, 3));
  door.Open();
  ASSERT_TRUE(Await([&] { return slow.size() == 3; }));
  EXPECT_EQ(graph.ToGraph("c", std::move(refused)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return slow.size() == 4; }));
  EXPECT_EQ(slow.values(), Counting(0, 4));
  EXPECT_EQ(graph.Snapshot().channels[0].refused, 1U);
}

TEST(Lossless, ReleasesReservedRoomWhenAnotherNodeIsFull) {
  DataGraph graph;
  CountingDoor door;
  const auto roomy = graph.FromGraph<int>(
      "c", Invoke::kSerial, [](const int&) {}, Options(Executor::Inline(), Queue::KeepAll(1)));
  const auto narrow = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&](const int&) { door.Pass(); }, Options(Executor::Dedicated(), Queue::KeepAll(1)));
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(0)), PublishStatus::kOk);
  ASSERT_TRUE(door.AwaitOne());
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(1)), PublishStatus::kOk);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(2)), PublishStatus::kFull);
  door.Open();
  ASSERT_TRUE(Await([&] { return door.came == 2; }));
  ASSERT_TRUE(Await([&] { return graph.ToGraph("c", std::make_unique<int>(2)) == PublishStatus::kOk; }));
  EXPECT_EQ(roomy.stats().run, 3U);
}

TEST(Lossless, WaitingPublishersLoseNothingAtAnyThreadCount) {
  for (const int threads : {1, 2, 3, 7, 16}) {
    DataGraph graph;
    std::atomic<int> count{0};
    const auto subscription = graph.FromGraph<int>(
        "c", Invoke::kSerial, [&](const int&) { ++count; }, Options(Executor::Tbb(), Queue::KeepAll(4)));
    const auto publish = graph.Advertise<int>("c");
    constexpr int kEach = 400;
    InThreads(threads, kEach, [&](int, int i) {
      EXPECT_EQ(publish.Wait(std::make_unique<int>(i), steady_clock::now() + kPatience), PublishStatus::kOk);
    });
    EXPECT_TRUE(Await([&] { return count == threads * kEach; }));
    EXPECT_EQ(subscription.stats().dropped, 0U);
  }
}

TEST(Lossless, WaitEndsAtDeadlineOnStopRequestAndWhenTheNodeEnds) {
  DataGraph graph;
  CountingDoor door;
  auto subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&](const int&) { door.Pass(); }, Options(Executor::Dedicated(), Queue::KeepAll(1)));
  const auto publish = graph.Advertise<int>("c");
  EXPECT_EQ(publish(std::make_unique<int>(0)), PublishStatus::kOk);
  ASSERT_TRUE(door.AwaitOne());
  EXPECT_EQ(publish(std::make_unique<int>(1)), PublishStatus::kOk);

  auto message = std::make_unique<int>(2);
  EXPECT_EQ(publish.Wait(std::move(message), steady_clock::now() + std::chrono::milliseconds(20)),
            PublishStatus::kTimedOut);
  EXPECT_NE(message, nullptr);

  std::stop_source stop;
  std::jthread stopper([&] { stop.request_stop(); });
  EXPECT_EQ(publish.Wait(std::move(message), steady_clock::now() + kPatience, stop.get_token()),
            PublishStatus::kStopped);
  EXPECT_NE(message, nullptr);

  std::atomic<bool> waited{false};
  std::jthread waiter([&] {
    EXPECT_EQ(publish.Wait(std::move(message), steady_clock::now() + kPatience), PublishStatus::kOk);
    waited = true;
  });
  std::jthread closer([&] { subscription.Reset(); });
  EXPECT_TRUE(Await([&] { return waited.load(); })) << "a node that ends makes room";
  door.Open();
}

TEST(Lossless, WaitingInsideACallbackIsRefusedAtOnce) {
  DataGraph graph;
  std::atomic<int> status{-1};
  const auto publish = graph.Advertise<int>("c");
  const auto fill_and_wait = [&](const int& value) {
    if (value != 0) return;
    // Fill our own queue, then wait for room in it: only this callback's return could make room.
    while (publish(std::make_unique<int>(1)) == PublishStatus::kOk) {
    }
    status = static_cast<int>(publish.Wait(std::make_unique<int>(2), steady_clock::now() + kPatience));
  };
  const auto subscription =
      graph.FromGraph<int>("c", Invoke::kSerial, fill_and_wait, Options(Executor::Tbb(), Queue::KeepAll(2)));
  EXPECT_EQ(publish(std::make_unique<int>(0)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return status >= 0; }));
  EXPECT_EQ(status, static_cast<int>(PublishStatus::kWouldDeadlock));
}

TEST(Lossless, ByteLimitCountsQueuedMessages) {
  struct Big {
    std::byte bytes[1000];
  };
  DataGraph graph;
  CountingDoor door;
  const auto subscription = graph.FromGraph<Big>(
      "c", Invoke::kSerial, [&](const Big&) { door.Pass(); },
      Options(Executor::Dedicated(), Queue::KeepAll(1000, 2500)));
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<Big>()), PublishStatus::kOk);
  ASSERT_TRUE(door.AwaitOne());
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<Big>()), PublishStatus::kOk);
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<Big>()), PublishStatus::kOk);
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<Big>()), PublishStatus::kFull);
  door.Open();
}

// Counts calls. Returns kFull while `full` is set.
class CountingOutlet final : public Outlet {
 public:
  [[nodiscard]] bool wanted() const noexcept override { return true; }
  PublishStatus Reserve(const void*, const TypeInfo&, PreparedMessage&) noexcept override {
    ++reserved;
    return full ? PublishStatus::kFull : PublishStatus::kOk;
  }
  bool Commit(const AnyMessage&, const TypeInfo&, const MessageInfo&, PreparedMessage&&) noexcept override {
    ++committed;
    return true;
  }
  void Cancel() noexcept override { ++cancelled; }

  std::atomic<bool> full{false};
  std::atomic<int> reserved{0};
  std::atomic<int> committed{0};
  std::atomic<int> cancelled{0};
};

TEST(Lossless, FullOutletFailsThePublishForLocalNodesToo) {
  DataGraph graph;
  Collected got;
  const auto outlet = std::make_shared<CountingOutlet>();
  Channel& channel = graph.Open("c", TypeOf<int>(), CallSite::Current());
  graph.SetOutlet(channel, outlet);
  const auto subscription = Collect(graph, got, Options(Executor::Inline(), Queue::KeepAll(1)));
  const Publisher<int> publish(graph.Share(channel), Reach::kAny);
  EXPECT_EQ(publish(std::make_unique<int>(1)), PublishStatus::kOk);
  outlet->full = true;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(publish(std::make_unique<int>(2)), PublishStatus::kFull);
  outlet->full = false;
  EXPECT_EQ(publish(std::make_unique<int>(3)), PublishStatus::kOk);
  EXPECT_EQ(got.values(), (std::vector<int>{1, 3}));
  EXPECT_EQ(outlet->committed, 2);
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(4)), PublishStatus::kOk);
  EXPECT_EQ(outlet->committed, 2) << "ToGraph does not publish outside";
}

TEST(Lossless, ReleasedReservationWakesWaitingPublishers) {
  DataGraph graph;
  std::atomic<int> run{0};
  const auto subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&](const int&) { ++run; }, Options(Executor::Dedicated(), Queue::KeepAll(1)));
  const auto outlet = std::make_shared<CountingOutlet>();
  outlet->full = true;
  Channel& channel = graph.Open("c", TypeOf<int>(), CallSite::Current());
  graph.SetOutlet(channel, outlet);
  std::atomic<bool> stop{false};
  std::jthread in_vain([&] {
    const Publisher<int> everywhere(graph.Share(channel), Reach::kAny);
    while (!stop) (void)everywhere(std::make_unique<int>(-1));
  });
  const auto inside = graph.Advertise<int>("c");
  for (int i = 0; i < 2000; ++i) {
    ASSERT_EQ(inside.Wait(std::make_unique<int>(i), steady_clock::now() + kPatience), PublishStatus::kOk);
  }
  stop = true;
  EXPECT_TRUE(Await([&] { return run == 2000; }));
}

TEST(Lossless, InlineNodeThatRunsAtOnceWakesWaitingPublishers) {
  DataGraph graph;
  CountingDoor door;
  std::atomic<int> run{0};
  const auto hold_first = [&](const int& value) {
    if (value == 0) door.Pass();
  };
  const auto slow =
      graph.FromGraph<int>("c", Invoke::kSerial, hold_first, Options(Executor::Inline(), Queue::KeepAll(10)));
  const auto narrow = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&](const int&) { ++run; }, Options(Executor::Inline(), Queue::KeepAll(1)));
  const auto publish = graph.Advertise<int>("c");
  std::jthread first([&] { EXPECT_EQ(publish(std::make_unique<int>(0)), PublishStatus::kOk); });
  ASSERT_TRUE(door.AwaitOne());
  EXPECT_EQ(publish(std::make_unique<int>(1)), PublishStatus::kFull) << "the room is taken although no message waits";
  std::jthread second(
      [&] { EXPECT_EQ(publish.Wait(std::make_unique<int>(1), steady_clock::now() + kPatience), PublishStatus::kOk); });
  door.Open();
  EXPECT_TRUE(Await([&] { return run == 2; }, kPatience / 2));
}

TEST(Lossless, AcceptsAnOversizedMessageWhileThePreviousOneRuns) {
  struct Big {
    char bytes[200];
  };
  for (const Invoke invoke : {Invoke::kSerial, Invoke::kConcurrent}) {
    DataGraph graph;
    CountingDoor door;
    const auto subscription = graph.FromGraph<Big>(
        "c", invoke, [&](const Big&) { door.Pass(); }, Options(Executor::Tbb(), Queue::KeepAll(10, 100)));
    EXPECT_EQ(graph.ToGraph("c", std::make_unique<Big>()), PublishStatus::kOk);
    ASSERT_TRUE(door.AwaitOne());
    EXPECT_EQ(graph.ToGraph("c", std::make_unique<Big>()), PublishStatus::kOk) << "the queue is empty";
    EXPECT_EQ(graph.ToGraph("c", std::make_unique<Big>()), PublishStatus::kFull);
    door.Open();
  }
}

TEST(Lossless, CreditIsHeldUntilTheMessageLeavesTheQueue) {
  DataGraph graph;
  CountingDoor door;
  const auto subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&](const int&) { door.Pass(); }, Options(Executor::Dedicated(), Queue::KeepAll(1)));
  Channel& channel = graph.Open("c", TypeOf<int>(), CallSite::Current());
  auto first = std::make_shared<const int>(1);
  auto second = std::make_shared<const int>(2);
  const std::weak_ptr<const int> first_watch = first;
  const std::weak_ptr<const int> second_watch = second;
  DataGraph::Inject(channel, std::make_shared<const int>(1), TypeOf<int>(), {}, std::move(first), 0);
  ASSERT_TRUE(door.AwaitOne());
  EXPECT_TRUE(first_watch.expired());
  DataGraph::Inject(channel, std::make_shared<const int>(2), TypeOf<int>(), {}, std::move(second), 0);
  EXPECT_FALSE(second_watch.expired());
  door.Open();
  EXPECT_TRUE(Await([&] { return second_watch.expired(); }));
}

}  // namespace
}  // namespace hgros::test
