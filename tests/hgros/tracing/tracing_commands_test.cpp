#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidjson/document.h>

#include <chrono>
#include <csignal>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/screen/terminal_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// A timer publishes tick, which this session receives.
struct TickRobot {
  RobotForCommands robot{"ticker"};
  Publisher<Log> tick = robot.session().Advertise<Log>("tick");
  Publisher<Log> unheard = robot.session().Advertise<Log>("unheard");
  Subscription on_tick =
      robot.session().FromAny<Log>("tick", Invoke::kSerial, [](const Log&) {}, {.name = "listening"});
  NodeTimer timer =
      robot.session().CreateTimer("tick", std::chrono::milliseconds(20), [this](const Tick&) { tick(Log()); });
};

TEST(TracingCommands, EndWithCode3WhenTheTimeoutComesFirst) {
  TickRobot ticking;
  for (std::vector<std::string> words : {std::vector<std::string>{"path", "timer/tick", "tick"}, {"trace"}}) {
    words.insert(words.end(), {"--seconds", "1e300", "--timeout", "0.5"});
    EXPECT_THAT(ticking.robot.Run(words), Ends(3));
  }
}

TEST(HgrosPath, SaysAtOnceWhichChannelsAreNotUsed) {
  TickRobot ticking;
  ticking.robot.RunUntil(
      {"path", "timer/tick", "unheard", "--seconds", "60", "--timeout", "1"},
      Ends(3, "hgros: Nobody subscribes to unheard yet.\nhgros: This takes longer than --timeout allows.\n"));
  EXPECT_THAT(ticking.robot.Run({"path", "tikc", "tick", "--seconds", "60", "--timeout", "1"}).err,
              HasSubstr("hgros: Nobody publishes on tikc yet. Did you mean tick?\n"));
}

TEST(HgrosTrace, WritesItsSummaryAsJsonButNothingToATerminal) {
  TickRobot ticking;
  const CommandEnd end =
      ticking.robot.RunUntil({"trace", "--seconds", "0.3", "--json", "-o", "/dev/null"},
                             Prints(0, AllOf(HasSubstr("\"sessions\":1"), Not(HasSubstr("\"callbacks\":0")))));
  rapidjson::Document summary;
  ASSERT_FALSE(summary.Parse(end.out.c_str()).HasParseError()) << end.out;
  EXPECT_EQ(std::string(summary["file"].GetString()), "/dev/null");
  EXPECT_GT(summary["callbacks"].GetInt(), 0);
  EXPECT_EQ(summary["sessions"].GetInt(), 1);
  ticking.robot.RunUntil({"trace", "--seconds", "0.3", "-o", "/dev/null"},
                         Prints(HasSubstr(" of 1 session are in /dev/null")));
  const TerminalRun trace({"trace", "--seconds", "0.3"}, ticking.robot.environment());
  EXPECT_EQ(trace.Wait(), 2);
  EXPECT_TRUE(trace.Shows("name a file with --output"));
  EXPECT_THAT(trace.written(), Not(HasSubstr("traceEvents")));
}

TEST(FullScreen, LeavesTheTerminalAsItWasAfterASignalThatIsRarelySent) {
  TickRobot ticking;
  for (const int number : {SIGIO, SIGPWR, SIGSTKFLT, SIGRTMIN + 3, SIGRTMAX}) {
    TerminalRun top({"top"}, ticking.robot.environment());
    ASSERT_TRUE(top.Shows("ticker"));
    top.Signal(number);
    EXPECT_EQ(top.Wait(), 128 + number);
    EXPECT_TRUE(test::Await([&] { return top.Restored(); })) << number;
  }
}

}  // namespace
}  // namespace hgros::cli
