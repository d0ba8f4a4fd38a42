#include "tracing/paths.hpp"

#include <gtest/gtest.h>

#include <ctime>

#include "tracing/chrome_trace.hpp"

namespace hgros::cli {
namespace {

// Three sessions: "lidar" publishes scan; "mapper" on another host makes pose of it and, in the same process, map of
// that; "planner" gets the map. Times in us.
struct Robot3 {
  Traced traced;

  Robot3() {
    for (const char* name : {"lidar", "mapper", "planner"}) {
      traced.sessions.push_back({SessionId{traced.sessions.size() + 1}, name, "host", 42, ClockOffset{}});
    }
  }
  void Publish(std::size_t session, const char* channel, const char* node, std::uint64_t message, std::uint64_t cause,
               std::int64_t at_us) {
    traced.publishes.push_back({session, channel, node, 7, message, cause, at_us * 1000});
  }
  void Run(std::size_t session, const char* channel, const char* node, std::uint64_t message,
           std::optional<std::int64_t> sent_us, std::int64_t received_us, std::int64_t start_us, std::int64_t end_us) {
    traced.runs.push_back(
        {session, channel, node, 7, message, std::nullopt, received_us * 1000, start_us * 1000, end_us * 1000});
    if (sent_us) traced.runs.back().sent_ns = *sent_us * 1000;
  }
  // A scan at `us` and what follows. `base` numbers its messages.
  void Turn(std::uint64_t base, std::int64_t us) {
    Publish(0, "scan", "", base, 0, us);
    Run(1, "scan", "odometry", base, us + 10, us + 30, us + 60, us + 500);
    Publish(1, "pose", "odometry", base + 1, base, us + 160);
    Run(1, "pose", "mapping", base + 1, {}, us + 160, us + 200, us + 1000);
    Publish(1, "map", "mapping", base + 2, base + 1, us + 900);
    Run(2, "map", "planning", base + 2, us + 905, us + 930, us + 960, us + 990);
  }
};

TEST(Paths, FollowTheCausesAndTellWhereTheTimeGoes) {
  Robot3 robot;
  for (std::uint64_t i = 0; i < 5; ++i) robot.Turn(100 * (i + 1), static_cast<std::int64_t>(10'000 * i));
  const Paths found = PathsBetween(robot.traced, "scan", "map");
  EXPECT_EQ(found.arrived, 5U);
  EXPECT_EQ(found.interrupted, 0U);
  ASSERT_EQ(found.paths.size(), 1U);
  const Path& path = found.paths[0];
  EXPECT_EQ(path.messages, 5U);
  EXPECT_EQ(path.all.Quantile(0.5), 960'000);
  ASSERT_EQ(path.hops.size(), 3U);
  const Hop& scan = path.hops[0];
  EXPECT_EQ(scan.channel, "scan");
  EXPECT_EQ(scan.node, "odometry");
  EXPECT_EQ(scan.publisher, 0U);
  EXPECT_EQ(scan.session, 1U);
  EXPECT_EQ(scan.encode.Quantile(0.5), 10'000);
  EXPECT_EQ(scan.transport.Quantile(0.5), 20'000);
  EXPECT_EQ(scan.wait.Quantile(0.5), 30'000);
  EXPECT_EQ(scan.run.Quantile(0.5), 100'000) << "until the pose is published, not until the callback ends";
  EXPECT_EQ(scan.all.Quantile(0.5), 160'000);
  const Hop& pose = path.hops[1];
  EXPECT_EQ(pose.encode.Quantile(0.5), 0) << "inside its process";
  EXPECT_EQ(pose.transport.Quantile(0.5), 0);
  EXPECT_EQ(pose.wait.Quantile(0.5), 40'000);
  EXPECT_EQ(pose.run.Quantile(0.5), 700'000);
  EXPECT_TRUE(pose.critical);
  EXPECT_NEAR(pose.share, 740.0 / 960, 1e-9);
  EXPECT_FALSE(scan.critical);
  const Hop& map = path.hops[2];
  EXPECT_EQ(map.run.Quantile(0.5), 30'000);
  EXPECT_EQ(map.all.Quantile(0.5), 60'000) << "without the last callback";
  EXPECT_NEAR(scan.share + pose.share + map.share, 1, 1e-9);
}

TEST(Paths, BeginInTheMiddleOfAChain) {
  Robot3 robot;
  robot.Turn(100, 0);
  const Paths found = PathsBetween(robot.traced, "pose", "map");
  ASSERT_EQ(found.paths.size(), 1U);
  ASSERT_EQ(found.paths[0].hops.size(), 2U);
  EXPECT_EQ(found.paths[0].all.Quantile(0.5), 800'000);
}

TEST(Paths, OfSeveralReceiversAreApartTheMostUsedFirst) {
  Robot3 robot;
  robot.Turn(100, 0);
  robot.Turn(200, 10'000);
  robot.Run(0, "map", "screen", 202, 10'905, 10'950, 10'970, 10'990);
  const Paths found = PathsBetween(robot.traced, "scan", "map");
  ASSERT_EQ(found.paths.size(), 2U);
  EXPECT_EQ(found.paths[0].messages, 2U);
  EXPECT_EQ(found.paths[0].hops.back().node, "planning");
  EXPECT_EQ(found.paths[1].messages, 1U);
  EXPECT_EQ(found.paths[1].hops.back().node, "screen");
}

TEST(Paths, SayWhyThereIsNone) {
  Robot3 robot;
  robot.Publish(0, "timer/map", "", 1, 0, 0);
  robot.Run(0, "timer/map", "map timer", 1, {}, 0, 5, 20);
  robot.Publish(0, "map", "map timer", 2, 1, 10);
  robot.Run(2, "map", "planning", 2, 12, 14, 16, 20);
  robot.Run(2, "map", "planning", 3, 22, 24, 26, 30);  // Its publish was not seen.
  const Paths found = PathsBetween(robot.traced, "scan", "map");
  EXPECT_TRUE(found.paths.empty());
  EXPECT_EQ(found.arrived, 2U);
  EXPECT_EQ(found.interrupted, 1U);
  EXPECT_EQ(found.origins, (std::map<std::string, std::size_t>{{"timer/map", 1}}));
}

// What was published from another thread with a CauseScope names no node. The node that runs a service's handler has
// not handled the request itself.
TEST(Paths, PassThroughAPublishOutsideCallbacksOrOfAnotherNode) {
  for (const char* node : {"", "handler"}) {
    Robot3 robot;
    robot.Publish(0, "scan", "", 1, 0, 0);
    robot.Run(1, "scan", "odometry", 1, 2, 4, 6, 8);
    robot.Publish(1, "map", node, 2, 1, 50);
    robot.Run(2, "map", "planning", 2, 52, 54, 56, 58);
    const Paths found = PathsBetween(robot.traced, "scan", "map");
    ASSERT_EQ(found.paths.size(), 1U) << node;
    EXPECT_EQ(found.paths[0].hops[0].node, "odometry") << node;
    EXPECT_EQ(found.paths[0].hops[0].run.Quantile(0.5), 44'000) << node;
  }
}

TEST(Paths, OfMessagesInACircleEnd) {
  Robot3 robot;
  for (std::uint64_t i = 1; i <= 2; ++i) {
    robot.Publish(0, "a", "n", i, 3 - i, 0);
    robot.Run(0, "a", "n", i, {}, 0, 0, 0);
  }
  EXPECT_EQ(PathsBetween(robot.traced, "scan", "a").interrupted, 2U);
}

// A peer chooses the keys: all of its messages may have the same one.
TEST(Paths, OfManyMessagesWithOneKeyTakeNoLongTime) {
  Robot3 robot;
  for (int i = 0; i < 100'000; ++i) {
    robot.Publish(0, "map", "n", 1, 1, i);
    robot.Run(0, "map", "m", 1, {}, i, i, i);
  }
  robot.Publish(0, "scan", "n", 2, 0, 0);
  const std::clock_t begin = std::clock();  // Time of the CPU, since others may use it, too.
  const Paths found = PathsBetween(robot.traced, "scan", "map");
  EXPECT_EQ(found.interrupted + found.lost, 100'000U);
  const std::string json = ChromeTraceOf(robot.traced);
  EXPECT_LT(std::clock() - begin, 20 * CLOCKS_PER_SEC);
  EXPECT_LT(json.size(), 100'000'000U);
}

TEST(Paths, OfLongChainsAreLimited) {
  Robot3 robot;
  constexpr std::uint64_t kLength = 60;
  robot.Publish(0, "scan", "", 1, 0, 0);
  for (std::uint64_t i = 2; i <= kLength; ++i) {
    robot.Run(0, "a", "n", i - 1, {}, 0, 0, 0);
    robot.Publish(0, "a", "n", i, i - 1, 0);
  }
  constexpr std::size_t kRuns = 20'000;
  for (std::size_t i = 0; i < kRuns; ++i) robot.Run(0, "map", "n", kLength, {}, 0, 0, 0);
  const Paths found = PathsBetween(robot.traced, "scan", "map");
  ASSERT_EQ(found.paths.size(), 1U);
  EXPECT_GT(found.lost, 0U);
  EXPECT_EQ(found.paths[0].messages + found.lost, kRuns);
}

TEST(Traced, SurvivesAnyNumbersAndNames) {
  const auto trace = std::make_shared<Trace>();
  trace->set_time_ns(INT64_MIN);
  trace->set_steady_ns(INT64_MAX);
  trace->add_names("");
  trace->add_names("scan\033[2J\xff");
  trace->set_lost(UINT64_MAX - 1);
  for (const std::uint32_t index : {0U, 1U, 2U, UINT32_MAX}) {
    Trace::Publish& publish = *trace->add_publishes();
    publish.set_channel(index);
    publish.set_node(index);
    publish.set_message(index);
    publish.set_cause(index);
    publish.set_at_ns(INT64_MIN);
    Trace::Run& run = *trace->add_runs();
    run.set_channel(index);
    run.set_node(index);
    run.set_message(index);
    run.set_sent_ns(INT64_MIN);
    run.set_received_ns(INT64_MIN);
    run.set_start_ns(INT64_MIN);
    run.set_end_ns(INT64_MAX);
  }
  const auto ended_before = trace->runs(0);
  trace->add_runs()->CopyFrom(ended_before);
  trace->mutable_runs(4)->set_start_ns(INT64_MAX);
  trace->mutable_runs(4)->set_end_ns(INT64_MIN);
  trace->add_runs()->CopyFrom(ended_before);
  trace->mutable_runs(5)->set_received_ns(INT64_MAX);
  trace->add_publishes()->CopyFrom(trace->publishes(0));
  const std::vector<TraceMessage> messages = {{SessionId{1}, trace}};
  const Traced traced = Assemble(messages, {{SessionId{1}, {Duration(INT64_MIN), Duration(INT64_MAX)}}});
  EXPECT_EQ(traced.publishes.size(), 4U);
  EXPECT_EQ(traced.lost, UINT64_MAX) << "a message is published once";
  EXPECT_EQ(traced.runs.size(), 4U) << "callbacks that end before they start, or start before their message comes";
  (void)PathsBetween(traced, "scan", "");
  const std::string json = ChromeTraceOf(traced);
  EXPECT_EQ(json.find('\033'), std::string::npos);
}

TEST(Traced, CorrectsTheClocksOfHosts) {
  constexpr std::int64_t kAhead = 5'000'000'000;
  const auto message = [](std::int64_t wall, std::int64_t steady) {
    auto trace = std::make_shared<Trace>();
    trace->set_time_ns(wall);
    trace->set_steady_ns(steady);
    trace->add_names("");
    trace->add_names("scan");
    return trace;
  };
  const auto here = message(1'000'000'000, 10'000);
  Trace::Publish& publish = *here->add_publishes();
  publish.set_channel(1);
  publish.set_at_ns(4'000);
  const auto there = message(1'000'000'000 + kAhead, 900'000);
  Trace::Run& run = *there->add_runs();
  run.set_channel(1);
  run.set_publisher(1);
  run.set_sent_ns(1'000'000'000 - 5'000);
  run.set_received_ns(896'000);
  run.set_start_ns(898'000);
  run.set_end_ns(899'000);
  const std::vector<TraceMessage> messages = {{SessionId{1}, here}, {SessionId{2}, there}};
  const Traced traced = Assemble(messages, {{SessionId{1}, {}}, {SessionId{2}, {Duration(kAhead), Duration(100)}}});
  EXPECT_EQ(traced.publishes.at(0).at_ns, 1'000'000'000 - 6'000);
  EXPECT_EQ(traced.runs.at(0).sent_ns, 1'000'000'000 - 5'000);
  EXPECT_EQ(traced.runs.at(0).received_ns, 1'000'000'000 - 4'000);
  EXPECT_EQ(traced.runs.at(0).start_ns, 1'000'000'000 - 2'000);
  EXPECT_EQ(DescribeClocks(traced, false).size(), 1U);
}

}  // namespace
}  // namespace hgros::cli
