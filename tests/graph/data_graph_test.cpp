#include "hgros/graph/data_graph.hpp"

#include <new>
#include <set>
#include <stdexcept>

#include "graph/graph_fixture.hpp"
#include "support/error_of.hpp"

namespace hgros::test {
namespace {

// Counts how often it is copied.
struct Counted {
  Counted() = default;
  Counted(const Counted&) { ++copies; }
  Counted& operator=(const Counted&) = delete;
  inline static std::atomic<int> copies{0};
};

// Cannot be copied, as if there were no memory for it, or for another reason.
struct Uncopyable {
  explicit Uncopyable(bool memory) : memory_is_short(memory) {}
  Uncopyable(const Uncopyable& other) : memory_is_short(other.memory_is_short) {
    if (memory_is_short) throw std::bad_alloc();
    throw std::runtime_error("no copy");
  }
  Uncopyable& operator=(const Uncopyable&) = delete;
  ~Uncopyable() = default;
  bool memory_is_short;
};

class EveryExecutor : public OnEveryExecutor {};
INSTANTIATE_TEST_SUITE_P(DataGraph, EveryExecutor, testing::Values(0U, 1U, 2U));

TEST_P(EveryExecutor, AllNodesGetTheSameObjectWithoutCopies) {
  DataGraph graph;
  Counted::copies = 0;
  std::mutex mutex;
  std::multiset<const Counted*> seen;
  std::vector<Subscription> subscriptions;
  for (const Invoke invoke : {Invoke::kSerial, Invoke::kConcurrent}) {
    const auto keep_address = [&](std::shared_ptr<const Counted> message) {
      const std::scoped_lock lock(mutex);
      seen.insert(message.get());
    };
    subscriptions.push_back(graph.FromGraph<Counted>("c", invoke, keep_address, Options(executor())));
  }
  auto message = std::make_unique<Counted>();
  const Counted* address = message.get();
  EXPECT_EQ(graph.ToGraph("c", std::move(message)), PublishStatus::kOk);
  EXPECT_EQ(message, nullptr);
  EXPECT_TRUE(Await([&] {
    const std::scoped_lock lock(mutex);
    return seen.count(address) == 2;
  }));
  EXPECT_EQ(Counted::copies, 0);
}

TEST_P(EveryExecutor, SerialNodesKeepEachPublishersOrder) {
  DataGraph graph;
  for (const int threads : {1, 2, 3, 7, 16}) {
    constexpr int kEach = 500;
    std::vector<std::vector<int>> got(static_cast<std::size_t>(threads));
    std::atomic<int> inside{0};
    std::atomic<int> overlaps{0};
    std::atomic<int> count{0};
    const std::string channel = "order" + std::to_string(threads);
    const auto check_order = [&](const std::pair<int, int>& message) {
      if (inside.fetch_add(1) != 0) ++overlaps;
      got[static_cast<std::size_t>(message.first)].push_back(message.second);
      inside.fetch_sub(1);
      ++count;
    };
    const auto subscription = graph.FromGraph<std::pair<int, int>>(channel, Invoke::kSerial, check_order,
                                                                   Options(executor(), Queue::KeepAll(100000)));
    InThreads(threads, kEach, [&](int t, int i) {
      EXPECT_EQ(graph.ToGraph(channel, std::make_unique<std::pair<int, int>>(t, i)), PublishStatus::kOk);
    });
    ASSERT_TRUE(Await([&] { return count == threads * kEach; })) << threads << " threads";
    EXPECT_EQ(overlaps, 0);
    for (const auto& values : got) EXPECT_EQ(values, Counting(0, kEach));
  }
}

TEST_P(EveryExecutor, ConcurrentNodesGetEveryMessageOnce) {
  DataGraph graph;
  for (const int threads : {1, 2, 3, 7, 16}) {
    constexpr int kEach = 300;
    std::vector<std::atomic<int>> got(static_cast<std::size_t>(threads * kEach));
    std::atomic<int> count{0};
    const std::string channel = "all" + std::to_string(threads);
    const auto count_each = [&](const int& message) {
      ++got[static_cast<std::size_t>(message)];
      ++count;
    };
    const auto subscription =
        graph.FromGraph<int>(channel, Invoke::kConcurrent, count_each, Options(executor(), Queue::KeepAll(100000)));
    InThreads(threads, kEach, [&](int t, int i) {
      EXPECT_EQ(graph.ToGraph(channel, std::make_unique<int>(t * kEach + i)), PublishStatus::kOk);
    });
    ASSERT_TRUE(Await([&] { return count == threads * kEach; })) << threads << " threads";
    for (const auto& times : got) EXPECT_EQ(times, 1);
  }
}

TEST_P(EveryExecutor, ThrowingCallbackIsCountedLoggedAndIsolated) {
  Heard heard;
  DataGraph graph({}, heard.MakeLog());
  Collected good;
  const auto bad = graph.FromGraph<int>(
      "c", Invoke::kSerial, [](const int&) { throw std::runtime_error("no map yet"); },
      Options(executor(), {}, "planner"));
  const auto other = Collect(graph, good, Options(executor()));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(i)), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return good.size() == 10 && bad.stats().run == 10; }));  // Counted after its failure.
  EXPECT_TRUE(heard.Contains("planner"));
  EXPECT_TRUE(heard.Contains("no map yet"));
  EXPECT_EQ(bad.stats().failed, 10U);
}

TEST_P(EveryExecutor, SlowKeepLastNodeGetsTheNewestAndCountsDrops) {
  if (executor().kind() == Executor::Kind::kInline) GTEST_SKIP() << "an inline node makes its publisher wait instead";
  DataGraph graph;
  Door door;
  Collected got;
  const auto hold = [&](const int& value) {
    got.Add(value);
    door.Pass();
  };
  const auto subscription = graph.FromGraph<int>("c", Invoke::kSerial, hold, Options(executor(), Queue::KeepLast(3)));
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(0)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return got.size() == 1; }));
  for (int i = 1; i <= 10; ++i) EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(i)), PublishStatus::kOk);
  door.Open();
  ASSERT_TRUE(Await([&] { return got.size() == 4; }));
  EXPECT_EQ(got.values(), (std::vector<int>{0, 8, 9, 10}));
  EXPECT_EQ(subscription.stats().dropped, 7U);
  EXPECT_EQ(subscription.stats().received, 11U);
}

TEST_P(EveryExecutor, KeepLastNodeLogsItsFirstDropOnceWithTheWayToChangeItsQueue) {
  Heard heard;
  DataGraph graph(Workers(2), heard.MakeLog());  // Both callbacks wait at the same time.
  CountingDoor door;
  const auto slow = [&](const int&) { door.Pass(); };
  const auto dropping = graph.FromGraph<int>("c", Invoke::kSerial, slow, Options(executor(), Queue::KeepLast(3)));
  const auto latest = graph.FromGraph<int>("d", Invoke::kSerial, slow, Options(executor(), Queue::Latest()));
  std::vector<std::jthread> publishers;  // The first message of an inline node keeps its publisher.
  for (const char* channel : {"c", "d"}) {
    publishers.emplace_back([&graph, channel] { (void)graph.ToGraph(channel, std::make_unique<int>(0)); });
  }
  ASSERT_TRUE(Await([&] { return door.came == 2; }));
  for (int i = 1; i <= 10; ++i) {
    for (const char* channel : {"c", "d"})
      EXPECT_EQ(graph.ToGraph(channel, std::make_unique<int>(i)), PublishStatus::kOk);
  }
  door.Open();
  EXPECT_EQ(heard.Count("has dropped"), 1U) << "the newest alone was asked for on the other channel";
  EXPECT_TRUE(
      heard.Contains("Subscription \"c#0\" on channel \"c\" has dropped 1 of 5 messages: they come faster than "
                     "they are handled, and its queue keeps only the last 3."));
  EXPECT_TRUE(heard.Contains("data_graph: nodes: \"c#0\": queue"));
  EXPECT_EQ(latest.stats().dropped, 9U);
}

TEST(DataGraph, InlineSerialNodeGetsItsOwnMessageAfterItReturns) {
  DataGraph graph;
  Collected got;
  int depth = 0;
  int deepest = 0;
  const auto publish_next = [&](const int& value) {
    deepest = std::max(deepest, ++depth);
    got.Add(value);
    if (value < 5) (void)graph.ToGraph("c", std::make_unique<int>(value + 1));
    --depth;
  };
  const auto subscription = graph.FromGraph<int>("c", Invoke::kSerial, publish_next, Options(Executor::Inline()));
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(0)), PublishStatus::kOk);
  EXPECT_EQ(got.values(), Counting(0, 6));
  EXPECT_EQ(deepest, 1);
}

TEST(DataGraph, SecondTypeOnAChannelThrowsNamingBothTypesAndTheLine) {
  DataGraph graph;
  (void)graph.Advertise<int>("scan");
  EXPECT_THROW((void)graph.ToGraph("scan", std::make_unique<double>(1.0)), TypeMismatch);
  const std::string text = ErrorOf([&] { return graph.ToGraph("scan", std::make_unique<double>(1.0)); });
  for (const char* part : {"scan", "int", "double", "data_graph_test.cpp", "another channel name."}) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
}

TEST(DataGraph, BadChannelNameThrows) {
  DataGraph graph;
  EXPECT_THROW((void)graph.Advertise<int>(""), Error);
  EXPECT_THROW((void)graph.Advertise<int>("two words"), Error);
  EXPECT_THROW((void)graph.Advertise<int>(std::string(201, 'a')), Error);
}

TEST(DataGraph, ClosedChannelDeliversRemoteMessagesOnly) {
  DataGraph graph;
  graph.SetClosed("c", true);
  Collected got;
  const auto collect = [&](const int& value, const MessageInfo& info) {
    EXPECT_EQ(info.remote, value == 7);
    got.Add(value);
  };
  const auto subscription = graph.FromGraph<int>("c", Invoke::kSerial, collect, Options(Executor::Inline()));
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(1)), PublishStatus::kOk);
  Channel& channel = graph.Open("c", TypeOf<int>(), CallSite::Current());
  DataGraph::Inject(channel, std::make_shared<const int>(7), TypeOf<int>(), MessageInfo{}, nullptr, 0);
  EXPECT_EQ(got.values(), std::vector<int>{7});
  graph.SetClosed("c", false);
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(2)), PublishStatus::kOk);
  EXPECT_EQ(got.values(), (std::vector<int>{7, 2}));
}

TEST(DataGraph, NodesAreNamedAfterTheirChannelUnlessTheyHaveANameThatCanBeShown) {
  DataGraph graph;
  const auto first = graph.FromGraph<int>("scan", Invoke::kSerial, [](const int&) {});
  const auto second = graph.FromGraph<int>("scan", Invoke::kSerial, [](const int&) {});
  const auto third = graph.FromGraph<int>("scan", Invoke::kSerial, [](const int&) {},
                                          {.name = "matcher", .queue = {}, .executor = {}});
  EXPECT_EQ(first.name(), "scan#0");
  EXPECT_EQ(second.name(), "scan#1");
  EXPECT_EQ(third.name(), "matcher");
  const auto subscribe = [&](const std::string& name) {
    return graph.FromGraph<int>("c", Invoke::kSerial, [](const int&) {}, {.name = name});
  };
  for (const char* name : {"map\nper", "\x1b[2J", "map\u202e", "\u0085", "\xff"}) {
    EXPECT_THROW((void)subscribe(name), Error) << name;
  }
  EXPECT_THROW((void)subscribe(std::string(1001, 'n')), Error);
  EXPECT_NO_THROW((void)subscribe("the mapper 2 \u00e4"));
}

TEST(DataGraph, ConfigurationOverridesTheProgramsNodeOptions) {
  GraphOptions options;
  options.overrides["matcher"] = {Queue::Latest(), Executor::Inline()};
  DataGraph graph(options);
  const auto subscription = graph.FromGraph<int>(
      "scan", Invoke::kSerial, [](const int&) {}, Options(Executor::Tbb(), Queue::KeepLast(9), "matcher"));
  EXPECT_EQ(subscription.stats().queue, Queue::Latest());
  EXPECT_EQ(subscription.stats().executor.kind(), Executor::Kind::kInline);
}

TEST(DataGraph, SnapshotCountsMessagesAndCallbacks) {
  DataGraph graph;
  const auto subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [](const int&) {}, Options(Executor::Inline(), {}, "node"));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(i)), PublishStatus::kOk);
  const GraphSnapshot snapshot = graph.Snapshot();
  ASSERT_EQ(snapshot.channels.size(), 1U);
  EXPECT_EQ(snapshot.channels[0].published, 100U);
  ASSERT_EQ(snapshot.channels[0].nodes.size(), 1U);
  const NodeSnapshot& node = snapshot.channels[0].nodes[0];
  EXPECT_EQ(node.received, 100U);
  EXPECT_EQ(node.run, 100U);
  EXPECT_EQ(node.run_time.count(), 100U);
  EXPECT_EQ(node.queue_wait.count(), 100U);
}

TEST(DataGraph, FindsEveryChannelWhileOthersAreAdded) {
  DataGraph graph;
  constexpr int kChannels = 1000;
  std::atomic<bool> stop{false};
  std::atomic<int> added{0};
  std::atomic<int> misses{0};
  std::jthread reader([&] {
    while (!stop) {
      const int count = added;
      for (int i = 0; i < count; ++i) {
        // The channel was opened with int, and another type is refused. No refusal shows that the channel was found.
        if (graph.ToGraph("channel" + std::to_string(i), std::make_unique<int>(i)) != PublishStatus::kOk) ++misses;
      }
    }
  });
  for (int i = 0; i < kChannels; ++i) {
    (void)graph.Advertise<int>("channel" + std::to_string(i));
    added = i + 1;
  }
  stop = true;
  reader.join();
  EXPECT_EQ(misses, 0);
  EXPECT_EQ(graph.Snapshot().channels.size(), static_cast<std::size_t>(kChannels));
}

TEST(DataGraph, AcceptsMoveOnlyCallbacks) {
  DataGraph graph;
  Collected got;
  auto owned = std::make_unique<int>(41);
  const auto subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&got, owned = std::move(owned)](const int& value) { got.Add(*owned + value); },
      Options(Executor::Inline()));
  EXPECT_EQ(graph.ToGraph("c", std::make_unique<int>(1)), PublishStatus::kOk);
  EXPECT_EQ(got.values(), std::vector<int>{42});
}

TEST(DataGraph, WaitIdleWaitsForAWholePipeline) {
  DataGraph graph;
  std::vector<Subscription> stages;
  Collected got;
  for (int i = 0; i < 10; ++i) {
    stages.push_back(graph.FromGraph<int>("s" + std::to_string(i), Invoke::kSerial, [&graph, i](const int& value) {
      (void)graph.ToGraph("s" + std::to_string(i + 1), std::make_unique<int>(value + 1));
    }));
  }
  stages.push_back(Collect(graph, got, {}, "s10"));
  for (int i = 0; i < 10; ++i) (void)graph.ToGraph("s0", std::make_unique<int>(i));
  EXPECT_TRUE(WaitIdle(graph));
  EXPECT_EQ(got.values(), Counting(10, 20));
}

TEST(DataGraph, RefusesAndCountsNullMessages) {
  DataGraph graph;
  int seen = 0;
  const auto subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&](const int&) { ++seen; }, Options(Executor::Inline()));
  auto message = std::make_unique<int>(1);
  const auto publish = graph.Advertise<int>("c");
  EXPECT_EQ(publish(std::move(message)), PublishStatus::kOk);
  EXPECT_EQ(publish(std::move(message)), PublishStatus::kEmpty);  // NOLINT(bugprone-use-after-move): that is the test.
  EXPECT_EQ(publish.Wait(std::unique_ptr<int>(), std::chrono::steady_clock::now()), PublishStatus::kEmpty);
  EXPECT_EQ(graph.ToGraph("c", std::shared_ptr<const int>()), PublishStatus::kEmpty);
  EXPECT_EQ(Publisher<int>()(std::make_unique<int>(1)), PublishStatus::kClosed) << "an empty handle";
  EXPECT_EQ(seen, 1);
  EXPECT_EQ(graph.Snapshot().channels[0].refused, 3U);
}

TEST(DataGraph, RefusesCountsAndLogsMessagesThatThereIsNoMemoryToCopy) {
  Heard log;
  DataGraph graph({}, log.MakeLog());
  const auto publish = graph.Advertise<Uncopyable>("c");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(publish(Uncopyable(true)), PublishStatus::kNoMemory);
  EXPECT_EQ(graph.Snapshot().channels[0].refused, 3U);
  EXPECT_EQ(log.Count("There is no memory to copy a message that is published on channel \"c\""), 1U);
  EXPECT_EQ(Publisher<Uncopyable>()(Uncopyable(true)), PublishStatus::kClosed) << "an empty handle";
  EXPECT_THROW(publish(Uncopyable(false)), std::runtime_error) << "of the message's own making";
}

TEST(DataGraph, MovesFromAMessageOnlyIfItIsTaken) {
  DataGraph graph;
  CountingDoor door;
  std::vector<const char*> seen;
  const auto hold = [&](const std::string& message) {
    door.Pass();
    seen.push_back(message.data());
  };
  const auto subscription =
      graph.FromGraph<std::string>("c", Invoke::kSerial, hold, Options(Executor::Tbb(), Queue::KeepAll(1)));
  const auto publish = graph.Advertise<std::string>("c");
  std::vector<const char*> sent;
  std::string message;
  do {
    message = std::string(100, 'm');
    sent.push_back(message.data());
  } while (publish(std::move(message)) == PublishStatus::kOk && (sent.size() > 1 || door.AwaitOne()));
  EXPECT_EQ(message, std::string(100, 'm'));  // NOLINT(bugprone-use-after-move): that is the test.
  EXPECT_EQ(message.data(), sent.back()) << "it was copied";
  sent.pop_back();
  auto unique = std::make_unique<std::string>("unique");
  auto shared = std::make_shared<std::string>("shared");
  std::shared_ptr<const std::string> constant = shared;
  EXPECT_EQ(publish(std::move(unique)), PublishStatus::kFull);
  EXPECT_EQ(publish(std::move(shared)), PublishStatus::kFull);
  EXPECT_EQ(publish(std::move(constant)), PublishStatus::kFull);
  const auto now = std::chrono::steady_clock::now();
  EXPECT_EQ(publish.Wait(std::move(unique), now), PublishStatus::kTimedOut);    // NOLINT(bugprone-use-after-move)
  EXPECT_EQ(publish.Wait(std::move(shared), now), PublishStatus::kTimedOut);    // NOLINT(bugprone-use-after-move)
  EXPECT_EQ(publish.Wait(std::move(constant), now), PublishStatus::kTimedOut);  // NOLINT(bugprone-use-after-move)
  EXPECT_TRUE(unique != nullptr && shared != nullptr && constant != nullptr) << "a refused message was taken";
  door.Open();
  EXPECT_TRUE(WaitIdle(graph));
  EXPECT_EQ(seen, sent) << "copies were delivered";
}

}  // namespace
}  // namespace hgros::test
