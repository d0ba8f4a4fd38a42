#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <future>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::AllOf;
using testing::HasSubstr;

// The number after "KEY": in a line of JSON; -1: there is none.
double NumberIn(const std::string& line, const std::string& key) {
  const std::string begin = "\"" + key + "\":";
  const std::size_t at = line.find(begin);
  if (at == std::string::npos || line.substr(at + begin.size(), 4) == "null") return -1;
  return std::strtod(line.c_str() + at + begin.size(), nullptr);
}

// What the command writes as soon as `shows` holds for it.
std::string OutputThat(const RobotForCommands& robot, const std::vector<std::string>& words,
                       const std::function<bool(const std::string&)>& shows) {
  return robot.RunUntil(Patiently(words), Prints(testing::Truly(shows))).out;
}

// A robot that publishes 1000 bytes and a few on "tick" every 20 ms.
struct TickingRobot {
  RobotForCommands robot;
  Publisher<Log> publish = robot.session().Advertise<Log>("tick");
  NodeTimer timer = robot.session().CreateTimer("tick", std::chrono::milliseconds(20), [this](const Tick&) {
    auto log = std::make_unique<Log>();
    log->set_message(std::string(1000, 'x'));
    publish(std::move(log));
  });
};

TEST(HgrosHz, CountsWhatIsPublishedWithoutReceivingIt) {
  TickingRobot ticking;
  EXPECT_TRUE(test::Await([&] {
    const std::vector<std::string> lines = LinesOf(ticking.robot.Run({"hz", "tick", "-n", "2", "--json"}).out);
    const double rate = lines.size() == 2 ? NumberIn(lines[1], "rate_hz") : -1;
    return rate > 5 && rate < 60;
  })) << "a busy machine ticks less often";
  for (const ChannelTraffic& traffic : ticking.robot.session().Snapshot().traffic) {
    EXPECT_TRUE(traffic.channel != "tick" || traffic.encoded == 0) << "no message was sent to the command";
  }
  EXPECT_THAT(ticking.robot.Run(Patiently({"hz", "tick", "--once"})),
              Prints(0, testing::StartsWith("CHANNEL      RATE  PUBLISHERS  PUBLISHED\ntick ")));
}

TEST(HgrosHz, ShowsIntervalsAndAHistogramOfWhatArrives) {
  TickingRobot ticking;
  auto drawn = std::async(std::launch::async, [&ticking] {
    ticking.robot.RunUntil(Patiently({"hz", "tick", "--receive", "-n", "1"}),
                           Prints(AllOf(HasSubstr("HISTOGRAM"), HasSubstr("#"))));
  });
  const std::vector<std::string> json =
      LinesOf(OutputThat(ticking.robot, {"hz", "tick", "--receive", "--once", "--json"}, [](const std::string& out) {
        return LinesOf(out).size() >= 2 && NumberIn(out, "received") > 10;
      }));
  ASSERT_GE(json.size(), 2U);
  EXPECT_GT(NumberIn(json[0], "received"), 10);
  EXPECT_GT(NumberIn(json[0], "interval_p50_ns"), 1e6);
  double counted = 0;
  for (std::size_t i = 1; i < json.size(); ++i) {
    EXPECT_THAT(json[i], HasSubstr("\"histogram_of\":\"interval\""));
    counted += NumberIn(json[i], "count");
  }
  EXPECT_GE(counted, NumberIn(json[0], "received") - 1);
  drawn.get();
}

TEST(HgrosHz, EndsOnCtrlCAtItsTimeoutOrWhenNobodyPublishes) {
  auto ending = std::make_unique<TickingRobot>();
  ending->robot.AwaitAnnounced();
  CommandRun lasting({"hz", "tick", "--timeout", "6"}, ending->robot.environment());
  ASSERT_TRUE(lasting.Prints("tick "));
  ending.reset();  // It goes on without the robot.
  const TickingRobot ticking;
  EXPECT_THAT(RunToEnd({"hz", std::string(3000, 'x')}),
              Ends(1, HasSubstr("it has 3000 bytes, more than 200")));  // No channel can have this name.
  EXPECT_THAT(ticking.robot.Run(Patiently({"hz", "tcik", "--once"})),
              AllOf(Ends(1, "hgros: Nobody publishes on tcik yet. Did you mean tick?\n"), Prints("")));
  EXPECT_EQ(ticking.robot.Run({"hz", "tick", "--timeout", "0.2"}).status, 3);

  // One after the other: one that looks at a session while it ends says so.
  const std::regex some("tick [^\n]* Hz +([2-9]|[1-9][0-9]+) ");  // An interval needs two messages.
  for (const bool receives : {false, true}) {
    CommandRun run(
        receives ? std::vector<std::string>{"hz", "tick", "--receive"} : std::vector<std::string>{"hz", "tick"},
        ticking.robot.environment());
    ASSERT_TRUE(test::Await([&] {
      const std::string out = run.out();
      return receives ? std::regex_search(out, some) : out.find("tick ") != std::string::npos;
    })) << run.out();
    run.End();
    EXPECT_EQ(run.err(), "");
    EXPECT_EQ(run.out().find("HISTOGRAM") != std::string::npos, receives);
  }
  EXPECT_EQ(lasting.Wait(), 3);
  EXPECT_EQ(lasting.err(), "");
}

TEST(HgrosBw, SaysThatTheSizeIsUnknownUntilSomebodyReceives) {
  TickingRobot ticking;
  EXPECT_THAT(ticking.robot.Run(Patiently({"bw", "tick", "--once", "--json"})),
              AllOf(Ends(0, HasSubstr("unknown: nobody outside its process receives them. --receive measures it.")),
                    Prints(HasSubstr("\"bytes_per_second\":null,\"mean_bytes\":null,\"rate_hz\":"))));
  const auto flows = [](const std::string& out) { return NumberIn(out, "bytes_per_second") > 10'000; };
  const std::string received = OutputThat(ticking.robot, {"bw", "tick", "--receive", "--once", "--json"}, flows);
  EXPECT_GT(NumberIn(received, "min_bytes"), 1000);
  EXPECT_LT(NumberIn(received, "max_bytes"), 1100);
  const std::string counted = OutputThat(ticking.robot, {"bw", "tick", "--once", "--json"}, flows);
  EXPECT_EQ(NumberIn(counted, "mean_bytes"), NumberIn(received, "mean_bytes"));
}

TEST(HgrosDelay, ShowsTheTransportAndTheQueueOfEachReceiver) {
  TickingRobot ticking;
  EXPECT_THAT(ticking.robot.Run(Patiently({"delay", "tick", "-n", "2"})),
              Ends(1, "hgros: Nobody counts this of tick now. --receive measures what arrives here.\n"));
  const Subscription heard =
      ticking.robot.session().FromAny<Log>("tick", Invoke::kSerial, [](const Log&) {}, {.name = "hearing"});
  const std::string line = OutputThat(ticking.robot, {"delay", "tick", "--once", "--json"},
                                      [](const std::string& out) { return NumberIn(out, "wait_p50_ns") > 0; });
  EXPECT_THAT(line, HasSubstr("\"node\":\"hearing\""));
  EXPECT_THAT(line, HasSubstr("\"transport_p50_ns\":null")) << "the message stays in its process";
  const std::vector<std::string> received =
      LinesOf(OutputThat(ticking.robot, {"delay", "tick", "--receive", "--once", "--json"},
                         [](const std::string& out) { return NumberIn(out, "delay_p50_ns") > 0; }));
  ASSERT_GE(received.size(), 2U);
  EXPECT_LT(NumberIn(received[0], "delay_min_ns"), 1e9);

  const auto publish = ticking.robot.session().Advertise<Log>("status", {.latched = 1});
  publish(Log());  // Messages from before are not counted.
  const std::vector<std::string> before =
      LinesOf(ticking.robot.Run({"delay", "status", "--receive", "--once", "--json"}).out);
  ASSERT_EQ(before.size(), 1U);
  EXPECT_EQ(NumberIn(before[0], "received"), 0);
}

TEST(HgrosDelay, ShowsHowWellStampsMatch) {
  RobotForCommands robot;
  const auto left = robot.session().Advertise<Log>("left");
  const auto right = robot.session().Advertise<Log>("right");
  std::int64_t ticks = 0;
  const NodeTimer timer = robot.session().CreateTimer("tick", std::chrono::milliseconds(20), [&](const Tick&) {
    Log log;
    log.mutable_timestamp()->set_seconds(++ticks);
    left(log);
    log.mutable_timestamp()->set_nanos(3'000'000);
    right(log);
  });
  const std::vector<std::string> lines =
      LinesOf(OutputThat(robot, {"delay", "left", "right", "--match", "0.01", "--once", "--json"},
                         [](const std::string& out) { return NumberIn(out, "matched") > 2; }));
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_THAT(lines[0], HasSubstr("\"channel\":\"left\""));
  EXPECT_EQ(NumberIn(lines[0], "after_p50_ns"), 0);
  EXPECT_EQ(NumberIn(lines[1], "after_p50_ns"), 3e6);
  EXPECT_THAT(robot.Run({"delay", "left", "--match", "0.01"}), Ends(2, "hgros: --match needs two to nine channels.\n"));
}

}  // namespace
}  // namespace hgros::cli
