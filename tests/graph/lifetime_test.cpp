#include <optional>
#include <random>

#include "graph/graph_fixture.hpp"
#include "graph/nodes/callback_guard.hpp"
#include "graph/nodes/callback_scope.hpp"
#include "support/seed.hpp"

namespace hgros::test {
namespace {

class LifetimeOnEveryExecutor : public OnEveryExecutor {};
INSTANTIATE_TEST_SUITE_P(Lifetime, LifetimeOnEveryExecutor, testing::Values(0U, 1U, 2U));

TEST_P(LifetimeOnEveryExecutor, DestroyingASubscriptionWaitsForItsCallbackAndRunsNoOther) {
  DataGraph graph;
  const auto publish = graph.Advertise<int>("c");
  std::atomic<bool> stop{false};
  std::jthread publisher([&] {
    while (!stop) (void)publish(std::make_unique<int>(1));
  });
  for (int round = 0; round < test::Rounds(25, 100); ++round) {
    auto alive = std::make_unique<std::atomic<bool>>(true);
    auto subscription = graph.FromGraph<int>(
        "c", round % 2 == 0 ? Invoke::kSerial : Invoke::kConcurrent,
        [state = alive.get()](const int&) { EXPECT_TRUE(state->load()); }, Options(executor()));
    if (round % 3 == 0) (void)Await([&] { return subscription.stats().run > 0; });
    subscription.Reset();
    *alive = false;
    alive.reset();  // AddressSanitizer would report a late callback here.
  }
  stop = true;
}

TEST_P(LifetimeOnEveryExecutor, ASubscriptionMayBeDestroyedInItsOwnCallback) {
  DataGraph graph;
  std::optional<Subscription> subscription;
  Door wired;
  std::atomic<int> calls{0};
  auto captured = std::make_shared<int>(5);
  const std::weak_ptr<int> watch = captured;
  const auto publish = graph.Advertise<int>("c");
  subscription.emplace(graph.FromGraph<int>(
      "c", Invoke::kSerial,
      [&, captured](const int&) {
        wired.Pass();
        EXPECT_FALSE(subscription->Join()) << "a callback cannot wait for itself";
        subscription.reset();
        ++calls;
        EXPECT_EQ(*captured, 5) << "captures live until the callback returns";
      },
      Options(executor())));
  captured.reset();
  wired.Open();
  for (int i = 0; i < 5; ++i) (void)publish(std::make_unique<int>(i));
  ASSERT_TRUE(Await([&] { return calls == 1 && watch.expired(); }));
  (void)publish(std::make_unique<int>(9));
  EXPECT_TRUE(WaitIdle(graph));
  EXPECT_EQ(calls, 1);
}

TEST_P(LifetimeOnEveryExecutor, TwoSubscriptionsMayDestroyEachOtherInTheirCallbacks) {
  for (int round = 0; round < test::Rounds(6, 20); ++round) {
    // Declared before the graph, because its destructor waits for callbacks that are still in flight.
    Subscription first;
    Subscription second;
    std::atomic<int> inside{0};
    std::atomic<int> done{0};
    const auto destroy = [&](Subscription& other) {
      ++inside;
      // Both run at the same time if there are enough threads.
      (void)Await([&] { return inside >= 2; }, std::chrono::milliseconds(20));
      other.Reset();
      ++done;
    };
    DataGraph graph;
    const Executor own = executor().kind() == Executor::Kind::kInline ? Executor::Dedicated() : executor();
    first = graph.FromGraph<int>(
        "a", Invoke::kSerial, [&](const int&) { destroy(second); }, Options(executor()));
    second = graph.FromGraph<int>(
        "b", Invoke::kSerial, [&](const int&) { destroy(first); }, Options(own));
    std::jthread publisher([&] { (void)graph.ToGraph("b", std::make_unique<int>(1)); });
    (void)graph.ToGraph("a", std::make_unique<int>(1));
    publisher.join();
    // Either both ran, or one was closed before it began.
    EXPECT_TRUE(Await([&] { return done >= 1; }));
    EXPECT_TRUE(WaitIdle(graph));
  }
}

TEST_P(LifetimeOnEveryExecutor, GraphDestroyedUnderLoadRefusesPublishesAndStops) {
  for (int round = 0; round < test::Rounds(8, 20); ++round) {
    auto graph = std::make_unique<DataGraph>();
    std::vector<Subscription> subscriptions;
    for (int i = 0; i < 3; ++i) {
      subscriptions.push_back(graph->FromGraph<int>(
          "c", i == 0 ? Invoke::kConcurrent : Invoke::kSerial, [](const int&) {}, Options(executor())));
    }
    const auto publish = graph->Advertise<int>("c");
    std::atomic<int> refused{0};
    std::vector<std::jthread> publishers;
    for (int t = 0; t < 3; ++t) {
      publishers.emplace_back([&, publish] {
        while (publish(std::make_unique<int>(1)) != PublishStatus::kClosed) {
        }
        ++refused;
      });
    }
    ASSERT_TRUE(Await([&] { return subscriptions[1].stats().run > 10; }));
    graph.reset();
    publishers.clear();
    EXPECT_EQ(refused, 3) << "a handle that outlives its graph returns kClosed";
    subscriptions.clear();
  }
}

TEST_P(LifetimeOnEveryExecutor, JoinWaitsForTheCallbackThatEndedTheSubscription) {
  DataGraph graph;
  CountingDoor door;
  std::atomic<bool> returned{false};
  std::optional<Subscription> subscription;
  const auto publish = graph.Advertise<int>("c");
  const auto end_itself = [&](const int&) {
    subscription->Reset();
    door.Pass();
    returned = true;
  };
  subscription.emplace(graph.FromGraph<int>("c", Invoke::kSerial, end_itself, Options(executor())));
  std::jthread publisher([&] { (void)publish(std::make_unique<int>(1)); });
  ASSERT_TRUE(door.AwaitOne());
  std::jthread opener([&] { door.Open(); });
  EXPECT_TRUE(subscription->Join());
  EXPECT_TRUE(returned) << "objects that the callback uses may be destroyed now";
  subscription.reset();
}

TEST(Lifetime, AnEndNamesTheNodeForWhoseCallbackItWaitsOnEveryExecutor) {
  const auto end_of_subscription = [](const Executor& executor) {
    Heard heard;
    CountingDoor door;
    DataGraph graph(GraphOptions{}, heard.MakeLog());
    auto subscription = graph.FromGraph<int>(
        "c", Invoke::kSerial, [&](const int&) { door.Pass(); }, Options(executor, {}, "stuck_planner"));
    std::jthread publisher([&] { (void)graph.ToGraph("c", std::make_unique<int>(1)); });
    ASSERT_TRUE(door.AwaitOne());
    std::jthread opener([&] {
      EXPECT_TRUE(Await([&] {
        return heard.Contains("The end of the subscription of node \"stuck_planner\" on channel \"c\" waits");
      }));
      door.Open();
    });
    subscription.Reset();
    EXPECT_EQ(heard.Count("stuck_planner"), 1U);
  };
  const auto shutdown = [] {
    Heard heard;
    CountingDoor door;
    auto graph = std::make_unique<DataGraph>(GraphOptions{}, heard.MakeLog());
    const auto subscription = graph->FromGraph<int>(
        "c", Invoke::kSerial, [&](const int&) { door.Pass(); }, Options(Executor::Tbb(), {}, "stuck_planner"));
    (void)graph->ToGraph("c", std::make_unique<int>(1));
    ASSERT_TRUE(door.AwaitOne());
    std::jthread destroyer([&] { graph.reset(); });
    EXPECT_TRUE(Await([&] { return heard.Contains("stuck_planner"); }));
    door.Open();
  };
  std::vector<std::jthread> at_once;
  for (const Executor& executor : AllExecutors()) at_once.emplace_back(end_of_subscription, executor);
  at_once.emplace_back(shutdown);
}

TEST(Lifetime, SubscriptionsComeAndGoDuringPublishingAtAnyThreadCount) {
  for (const int threads : {1, 2, 3, 7, 16}) {
    SCOPED_TRACE("threads " + std::to_string(threads));
    DataGraph graph;
    std::atomic<bool> stop{false};
    std::atomic<std::uint64_t> published{0};
    std::vector<std::jthread> publishers;
    for (int t = 0; t < threads; ++t) {
      publishers.emplace_back([&, t] {
        while (!stop) {
          (void)graph.ToGraph("c" + std::to_string(t % 3), std::make_unique<int>(t));
          ++published;
        }
      });
    }
    std::mt19937_64 random(Seed());
    std::vector<Subscription> subscriptions;
    for (int i = 0; i < Rounds(100, 300); ++i) {
      if (subscriptions.size() < 10 && random() % 2 == 0) {
        const auto executors = AllExecutors();
        subscriptions.push_back(graph.FromGraph<int>(
            "c" + std::to_string(random() % 3), random() % 2 == 0 ? Invoke::kSerial : Invoke::kConcurrent,
            [](const int&) {}, Options(executors[random() % executors.size()])));
      } else if (!subscriptions.empty()) {
        subscriptions.erase(subscriptions.begin() + static_cast<std::ptrdiff_t>(random() % subscriptions.size()));
      }
    }
    EXPECT_TRUE(Await([&] { return published > 100; }));
    stop = true;
  }
}

TEST(Lifetime, ASubscriptionMayOutliveItsGraph) {
  Subscription subscription;
  {
    DataGraph graph;
    subscription = graph.FromGraph<int>("c", Invoke::kSerial, [](const int&) {});
  }
  EXPECT_EQ(subscription.name(), "c#0");
  subscription.Reset();
}

TEST(CallbackGuard, DestroysTheCallbackOnceOutsideTheLockAndInsideTheNode) {
  int object = 0;
  auto* const node = reinterpret_cast<Node*>(&object);  // Only compared.
  std::mutex mutex;
  std::condition_variable changed;
  CallbackGuard* guarded = nullptr;
  int destroyed = 0;
  const auto on_destruction = [&](const int* /*object*/) {
    ++destroyed;
    EXPECT_TRUE(CallbackScope::InNode(node));
    std::unique_lock lock(mutex, std::try_to_lock);
    ASSERT_TRUE(lock.owns_lock()) << "the callback is destroyed under the node's lock";
    EXPECT_TRUE(guarded->destroying());
    guarded->DestroyOnce(nullptr, node, lock,
                         changed);  // As if an object that the callback owns closed the node again.
    EXPECT_EQ(destroyed, 1);
  };
  CallbackGuard guard(
      [captured = std::shared_ptr<const int>(&object, on_destruction)](const AnyMessage&, const MessageInfo&) {});
  guarded = &guard;
  std::unique_lock lock(mutex);
  guard.DestroyOnce(nullptr, node, lock, changed);
  EXPECT_TRUE(lock.owns_lock());
  EXPECT_FALSE(guard.destroying());
  guard.DestroyOnce(nullptr, node, lock, changed);
  EXPECT_EQ(destroyed, 1);
}

}  // namespace
}  // namespace hgros::test
