#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <functional>
#include <regex>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::HasSubstr;

// The number after "KEY": in a line of JSON; -1: there is none.
double NumberIn(const std::string& line, const std::string& key) {
  const std::string begin = "\"" + key + "\":";
  const std::size_t at = line.find(begin);
  if (at == std::string::npos || line.substr(at + begin.size(), 4) == "null") return -1;
  return std::strtod(line.c_str() + at + begin.size(), nullptr);
}

// What the command writes as soon as `shows` holds for it: on a busy machine, little may come in the second of a
// report.
std::string OutputThat(const RobotForCommands& robot, const std::vector<std::string>& words,
                       const std::function<bool(const std::string&)>& shows) {
  std::string out;
  EXPECT_TRUE(test::Await([&] {
    out = robot.Run(Patiently(words)).out;
    return shows(out);
  })) << out;
  return out;
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
  const auto rate = [&] {
    const std::vector<std::string> lines = LinesOf(ticking.robot.Run({"hz", "tick", "-n", "2", "--json"}).out);
    return lines.size() == 2 ? NumberIn(lines[1], "rate_hz") : -1;
  };
  EXPECT_TRUE(test::Await([&] { return rate() > 5 && rate() < 60; })) << "a busy machine ticks less often";
  for (const ChannelTraffic& traffic : ticking.robot.session().Snapshot().traffic) {
    EXPECT_TRUE(traffic.channel != "tick" || traffic.encoded == 0) << "no message was sent to the command";
  }
  const CommandEnd table = ticking.robot.Run(Patiently({"hz", "tick", "--once"}));
  EXPECT_EQ(table.status, 0);
  EXPECT_THAT(table.out, testing::StartsWith("CHANNEL      RATE  PUBLISHERS  PUBLISHED\ntick "));
}

TEST(HgrosHz, ShowsIntervalsAndAHistogramOfWhatArrives) {
  TickingRobot ticking;
  const std::string table = OutputThat(ticking.robot, {"hz", "tick", "--receive", "-n", "1"},
                                       [](const std::string& out) { return out.find('#') != std::string::npos; });
  EXPECT_THAT(table, HasSubstr("HISTOGRAM"));
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
}

TEST(HgrosHz, EndsWithAnErrorWhenNobodyPublishes) {
  TickingRobot ticking;
  const CommandEnd end = ticking.robot.Run(Patiently({"hz", "tcik", "--once"}));
  EXPECT_EQ(end.status, 1);
  EXPECT_EQ(end.out, "");
  EXPECT_EQ(end.err, "hgros: Nobody publishes on tcik yet. Did you mean tick?\n");
  EXPECT_EQ(ticking.robot.Run({"hz", "tick", "--timeout", "0.2"}).status, 3);
}

TEST(HgrosHz, EndsSilentlyOnCtrlC) {
  TickingRobot ticking;
  CommandRun run({"hz", "tick"}, ticking.robot.environment());
  ASSERT_TRUE(run.Prints("tick "));
  run.Signal(SIGINT);
  EXPECT_EQ(run.Wait(), 128 + SIGINT);
  EXPECT_EQ(run.err(), "");
}

TEST(HgrosHz, WritesTheHistogramOnCtrlC) {
  TickingRobot ticking;
  CommandRun run({"hz", "tick", "--receive"}, ticking.robot.environment());
  const std::regex some("tick [^\n]* Hz +([2-9]|[1-9][0-9]+) ");  // An interval needs two messages.
  ASSERT_TRUE(test::Await([&] { return std::regex_search(run.out(), some); })) << run.out();
  run.Signal(SIGINT);
  EXPECT_EQ(run.Wait(), 128 + SIGINT);
  EXPECT_THAT(run.out(), HasSubstr("HISTOGRAM"));
  EXPECT_EQ(run.err(), "");
}

TEST(HgrosHz, GoesOnWhenTheRobotHasGone) {
  auto ticking = std::make_unique<TickingRobot>();
  const auto environment = ticking->robot.environment();
  CommandRun run({"hz", "tick", "--timeout", "6"}, environment);
  ASSERT_TRUE(run.Prints("tick "));
  ticking.reset();
  EXPECT_EQ(run.Wait(), 3);
  EXPECT_EQ(run.err(), "");
}

TEST(HgrosBw, SaysThatTheSizeIsUnknownUntilSomebodyReceives) {
  TickingRobot ticking;
  const CommandEnd end = ticking.robot.Run(Patiently({"bw", "tick", "--once", "--json"}));
  EXPECT_EQ(end.status, 0);
  EXPECT_THAT(end.out, HasSubstr("\"bytes_per_second\":null,\"mean_bytes\":null,\"rate_hz\":"));
  EXPECT_THAT(end.err, HasSubstr("unknown: nobody outside its process receives them. --receive measures it."));
  const auto flows = [](const std::string& out) { return NumberIn(out, "bytes_per_second") > 10'000; };
  const std::string received = OutputThat(ticking.robot, {"bw", "tick", "--receive", "--once", "--json"}, flows);
  EXPECT_GT(NumberIn(received, "min_bytes"), 1000);
  EXPECT_LT(NumberIn(received, "max_bytes"), 1100);
  EXPECT_GT(NumberIn(received, "bytes_per_second"), 10'000);
  const std::string counted = OutputThat(ticking.robot, {"bw", "tick", "--once", "--json"}, flows);
  EXPECT_EQ(NumberIn(counted, "mean_bytes"), NumberIn(received, "mean_bytes"));
  EXPECT_GT(NumberIn(counted, "bytes_per_second"), 10'000);
}

TEST(HgrosDelay, ShowsTheTransportAndTheQueueOfEachReceiver) {
  TickingRobot ticking;
  const Subscription heard =
      ticking.robot.session().FromAny<Log>("tick", Invoke::kSerial, [](const Log&) {}, {.name = "hearing"});
  const auto line = [&] { return ticking.robot.Run(Patiently({"delay", "tick", "--once", "--json"})).out; };
  EXPECT_TRUE(test::Await([&] { return NumberIn(line(), "wait_p50_ns") > 0; })) << line();
  EXPECT_THAT(line(), HasSubstr("\"node\":\"hearing\""));
  EXPECT_THAT(line(), HasSubstr("\"transport_p50_ns\":null")) << "the message stays in its process";
  const std::vector<std::string> received =
      LinesOf(OutputThat(ticking.robot, {"delay", "tick", "--receive", "--once", "--json"},
                         [](const std::string& out) { return NumberIn(out, "delay_p50_ns") > 0; }));
  ASSERT_GE(received.size(), 2U);
  EXPECT_LT(NumberIn(received[0], "delay_min_ns"), 1e9);
}

TEST(HgrosDelay, SaysThatNobodyReceives) {
  TickingRobot ticking;
  const CommandEnd end = ticking.robot.Run(Patiently({"delay", "tick", "-n", "2"}));
  EXPECT_EQ(end.status, 1);
  EXPECT_EQ(end.err, "hgros: Nobody counts this of tick now. --receive measures what arrives here.\n");
}

TEST(HgrosHz, RefusesNamesThatNoChannelCanHave) {
  const CommandEnd end = RunToEnd({"hz", std::string(3000, 'x')});
  EXPECT_EQ(end.status, 1);
  EXPECT_THAT(end.err, HasSubstr("it has 3000 bytes, more than 200"));
}

TEST(HgrosDelay, DoesNotCountLatchedMessagesFromBefore) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 1});
  publish(Log());
  const std::vector<std::string> lines = LinesOf(robot.Run({"delay", "status", "--receive", "--once", "--json"}).out);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(NumberIn(lines[0], "received"), 0);
}

}  // namespace
}  // namespace hgros::cli
