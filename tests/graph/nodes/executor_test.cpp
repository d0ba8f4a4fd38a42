#include "hgros/graph/executor.hpp"

#include <sched.h>
#include <tbb/task_group.h>

#include <set>
#include <utility>

#include "graph/graph_fixture.hpp"
#include "hgros/base/error.hpp"

namespace hgros::test {
namespace {

TEST(Executor, RefusesPrioritiesAndCpusThatDoNotExist) {
  EXPECT_THROW((void)Executor::Dedicated({}, 100), Error);
  EXPECT_THROW((void)Executor::Dedicated({}, -1), Error);
  EXPECT_THROW((void)Executor::Dedicated({-1}), Error);
  EXPECT_THROW((void)Queue::KeepLast(0), Error);
  EXPECT_THROW((void)Queue::KeepAll(0), Error);
}

TEST(Executor, InlineRunsInThePublishersThread) {
  DataGraph graph;
  std::thread::id ran;
  const auto subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&](const int&) { ran = std::this_thread::get_id(); }, Options(Executor::Inline()));
  (void)graph.ToGraph("c", std::make_unique<int>(1));
  EXPECT_EQ(ran, std::this_thread::get_id());
}

TEST(Executor, DedicatedRunsOnItsOwnThreadOnTheRequestedCpus) {
  DataGraph graph;
  std::mutex mutex;
  std::set<std::thread::id> threads;
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  std::atomic<int> count{0};
  const auto record_thread = [&](const int&) {
    const std::scoped_lock lock(mutex);
    threads.insert(std::this_thread::get_id());
    sched_getaffinity(0, sizeof allowed, &allowed);
    ++count;
  };
  const auto subscription = graph.FromGraph<int>("c", Invoke::kConcurrent, record_thread,
                                                 Options(Executor::Dedicated({0}), Queue::KeepAll(100)));
  for (int i = 0; i < 50; ++i) (void)graph.ToGraph("c", std::make_unique<int>(i));
  ASSERT_TRUE(Await([&] { return count == 50; }));
  EXPECT_EQ(threads.size(), 1U);
  EXPECT_EQ(threads.count(std::this_thread::get_id()), 0U);
  EXPECT_EQ(CPU_COUNT(&allowed), 1);
  EXPECT_TRUE(CPU_ISSET(0, &allowed));
}

// A turn ends after one of these callbacks, and turns come in the order in which they were asked for.
TEST(Executor, RunsAnotherNodeWhenEachOfTheBusyOnesHadATurn) {
  for (const auto& [busy, invoke] : std::vector<std::pair<int, Invoke>>{
           {1, Invoke::kSerial}, {3, Invoke::kSerial}, {1, Invoke::kConcurrent}, {3, Invoke::kConcurrent}}) {
    DataGraph graph(Workers(1));
    CountingDoor door;
    std::atomic<int> begun{0};
    std::atomic<int> begun_before{-1};
    std::vector<Subscription> subscriptions;
    for (int i = 0; i < busy; ++i) {
      const std::string channel = "busy" + std::to_string(i);
      const auto be_busy = [&](const int&) {
        door.Pass();
        ++begun;
        Linger(std::chrono::milliseconds(2));  // Longer than a turn.
      };
      subscriptions.push_back(
          graph.FromGraph<int>(channel, invoke, be_busy, Options(Executor::Tbb(), Queue::KeepAll(100))));
      for (int j = 0; j < 100; ++j) (void)graph.ToGraph(channel, std::make_unique<int>(j));
    }
    subscriptions.push_back(graph.FromGraph<int>(
        "control", Invoke::kSerial, [&](const int&) { begun_before = begun.load(); }, Options(Executor::Tbb())));
    ASSERT_TRUE(door.AwaitOne());
    (void)graph.ToGraph("control", std::make_unique<int>(0));
    door.Open();
    EXPECT_TRUE(Await([&] { return begun_before >= 0; }));
    EXPECT_LE(begun_before, busy + 1);
  }
}

// Else it would fall behind: serial nodes run many short callbacks in a turn, too.
TEST(Executor, AConcurrentNodeRunsManyShortCallbacksInATurn) {
  constexpr int kMessages = 1000;
  DataGraph graph(Workers(1));
  Door door;
  const auto first = graph.FromGraph<int>("first", Invoke::kSerial, [&](const int&) { door.Pass(); });
  (void)graph.ToGraph("first", std::make_unique<int>(0));
  std::atomic<int> turns{0};
  std::atomic<int> turns_until_end{-1};
  std::atomic<int> left{kMessages};
  const NodeOptions keep_all = Options(Executor::Tbb(), Queue::KeepAll(kMessages));
  const auto take_a_turn = [&](const int&) {
    ++turns;
    Linger(std::chrono::milliseconds(2));  // Longer than a turn.
  };
  const auto serial = graph.FromGraph<int>("serial", Invoke::kSerial, take_a_turn, keep_all);
  const auto count_down = [&](const int&) {
    if (--left == 0) turns_until_end = turns.load();
  };
  const auto concurrent = graph.FromGraph<int>("concurrent", Invoke::kConcurrent, count_down, keep_all);
  for (int i = 0; i < kMessages; ++i) {
    (void)graph.ToGraph("serial", std::make_unique<int>(i));
    (void)graph.ToGraph("concurrent", std::make_unique<int>(i));
  }
  door.Open();
  ASSERT_TRUE(Await([&] { return turns_until_end >= 0; }));
  EXPECT_LT(turns_until_end, kMessages / 2);
}

TEST(Executor, LogsRefusedSchedulingAndRunsWithoutIt) {
  Heard heard;
  DataGraph graph({}, heard.MakeLog());
  std::atomic<int> count{0};
  const auto subscription = graph.FromGraph<int>(
      "c", Invoke::kSerial, [&](const int&) { ++count; }, Options(Executor::Dedicated({1023}), {}, "far_away"));
  (void)graph.ToGraph("c", std::make_unique<int>(1));
  EXPECT_TRUE(Await([&] { return count == 1; }));
  EXPECT_TRUE(heard.Contains("far_away"));
}

TEST(Executor, TbbRunsConcurrentCallbacksAtTheSameTime) {
  DataGraph graph(Workers(2));
  std::atomic<int> inside{0};
  std::atomic<bool> both{false};
  const auto subscription = graph.FromGraph<int>("c", Invoke::kConcurrent, [&](const int&) {
    if (++inside == 2) both = true;
    (void)Await([&] { return both.load(); });
    --inside;
  });
  for (int i = 0; i < 2; ++i) (void)graph.ToGraph("c", std::make_unique<int>(i));
  EXPECT_TRUE(Await([&] { return both.load(); }));
}

TEST(Executor, BusySerialNodeDoesNotBlockOthers) {
  DataGraph graph(Workers(2));
  Door door;
  std::atomic<int> others{0};
  const auto busy = graph.FromGraph<int>("slow", Invoke::kSerial, [&](const int&) { door.Pass(); });
  const auto quick = graph.FromGraph<int>("quick", Invoke::kSerial, [&](const int&) { ++others; });
  (void)graph.ToGraph("slow", std::make_unique<int>(1));
  for (int i = 0; i < 10; ++i) {
    (void)graph.ToGraph("quick", std::make_unique<int>(i));
    EXPECT_TRUE(Await([&] { return others == i + 1; }));
  }
  door.Open();
}

// In which order depends on the time: a callback that took long leaves the nodes it made ready to the workers.
TEST(Executor, OneWorkerRunsNodesThatACallbackMadeReady) {
  DataGraph graph(Workers(1));
  std::atomic<bool> busy{false};
  std::mutex mutex;
  std::vector<std::string> ran;
  const auto callback = [&](const std::string& name, const std::vector<std::string>& outputs) {
    return [&, name, outputs](const int&) {
      EXPECT_FALSE(busy.exchange(true)) << name << " ran beside another";
      for (const auto& output : outputs) (void)graph.ToGraph(output, std::make_unique<int>(1));
      const std::scoped_lock lock(mutex);
      ran.push_back(name);
      busy = false;
    };
  };
  const auto last = graph.FromGraph<int>("last", Invoke::kSerial, callback("last", {}), Options(Executor::Tbb()));
  const auto middle =
      graph.FromGraph<int>("middle", Invoke::kConcurrent, callback("middle", {"last"}), Options(Executor::Tbb()));
  const auto first =
      graph.FromGraph<int>("first", Invoke::kSerial, callback("first", {"middle", "last"}), Options(Executor::Tbb()));
  (void)graph.ToGraph("first", std::make_unique<int>(1));
  ASSERT_TRUE(WaitIdle(graph));
  ASSERT_FALSE(ran.empty());
  EXPECT_EQ(ran.front(), "first");
  std::sort(ran.begin(), ran.end());
  EXPECT_EQ(ran, (std::vector<std::string>{"first", "last", "last", "middle"}));
}

TEST(Executor, TwoBusyNodesDoNotStarveAThirdOnOneWorker) {
  DataGraph graph(Workers(1));
  std::atomic<bool> ends{false};
  std::atomic<int> third{0};
  const auto ball = [&](const char* to) {
    return [&graph, &ends, to](const int&) {
      if (!ends) (void)graph.ToGraph(to, std::make_unique<int>(1));
    };
  };
  const auto ping = graph.FromGraph<int>("ping", Invoke::kSerial, ball("pong"), Options(Executor::Tbb()));
  const auto pong = graph.FromGraph<int>("pong", Invoke::kSerial, ball("ping"), Options(Executor::Tbb()));
  const auto other = graph.FromGraph<int>(
      "third", Invoke::kSerial, [&](const int&) { ++third; }, Options(Executor::Tbb()));
  (void)graph.ToGraph("ping", std::make_unique<int>(1));
  for (int i = 1; i <= 10; ++i) {
    (void)graph.ToGraph("third", std::make_unique<int>(1));
    EXPECT_TRUE(Await([&] { return third == i; }));
  }
  ends = true;
}

TEST(Executor, ASlowNodeWithManyMessagesTakesTurnsWithTheOthersOfOneWorker) {
  for (const bool lossless : {false, true}) {
    DataGraph graph(Workers(1));
    std::atomic<int> slow{0};
    std::atomic<int> meanwhile{-1};
    const auto run_slowly = [&](const int&) {
      Linger(std::chrono::milliseconds(3));
      ++slow;
    };
    const auto first =
        graph.FromGraph<int>("slow", Invoke::kSerial, run_slowly,
                             Options(Executor::Tbb(), lossless ? Queue::KeepAll(100) : Queue::KeepLast(100)));
    const auto other = graph.FromGraph<int>(
        "other", Invoke::kSerial, [&](const int& before) { meanwhile = slow - before; }, Options(Executor::Tbb()));
    for (int i = 0; i < 60; ++i) (void)graph.ToGraph("slow", std::make_unique<int>(i));
    (void)graph.ToGraph("other", std::make_unique<int>(slow.load()));
    EXPECT_TRUE(Await([&] { return meanwhile >= 0; }));
    EXPECT_LT(meanwhile, 20) << "of 60";
    EXPECT_TRUE(WaitIdle(graph));
    EXPECT_EQ(slow, 60);
  }
}

// It may hold a lock that the other one takes, too.
TEST(TbbExecutor, ACallbackThatWaitsInParallelCodeRunsNoOtherInside) {
  DataGraph graph(Workers(3));
  std::atomic<std::thread::id> waiting;
  std::atomic<bool> ran{false};
  const auto run_elsewhere = [&](const int&) {
    EXPECT_NE(std::this_thread::get_id(), waiting.load());
    ran = true;
  };
  const auto other = graph.FromGraph<int>("other", Invoke::kSerial, run_elsewhere, Options(Executor::Tbb()));
  const auto wait_for_other = [&](const int&) {
    waiting = std::this_thread::get_id();
    tbb::task_group tasks;
    tasks.run([&] { EXPECT_TRUE(Await([&] { return ran.load(); })); });
    (void)graph.ToGraph("other", std::make_unique<int>(1));
    tasks.wait();
  };
  const auto parallel = graph.FromGraph<int>("parallel", Invoke::kSerial, wait_for_other, Options(Executor::Tbb()));
  (void)graph.ToGraph("parallel", std::make_unique<int>(1));
  EXPECT_TRUE(WaitIdle(graph));
}

TEST(TbbExecutor, EveryGraphHasItsOwnWorkers) {
  DataGraph one(Workers(1));
  DataGraph other(Workers(2));
  CountingDoor door;
  const auto wait = [&](const int&) { door.Pass(); };
  std::vector<Subscription> subscriptions;
  subscriptions.push_back(one.FromGraph<int>("c", Invoke::kSerial, wait, {}));
  for (int i = 0; i < 2; ++i) subscriptions.push_back(other.FromGraph<int>("c", Invoke::kSerial, wait, {}));
  EXPECT_EQ(one.ToGraph("c", std::make_unique<int>(1)), PublishStatus::kOk);
  EXPECT_EQ(other.ToGraph("c", std::make_unique<int>(1)), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return door.came == 3; })) << door.came << " of 3 callbacks run at once.";
  door.Open();
}

}  // namespace
}  // namespace hgros::test
