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
  for (const std::vector<std::string>& words : {std::vector<std::string>{"path", "timer/tick", "tick"}, {"trace"}}) {
    std::vector<std::string> run = words;
    run.insert(run.end(), {"--seconds", "1e300", "--timeout", "0.5"});
    const CommandEnd end = ticking.robot.Run(run);
    EXPECT_EQ(end.status, 3) << end.err;
  }
}

TEST(HgrosPath, SaysAtOnceWhichChannelsAreNotUsed) {
  TickRobot ticking;
  CommandEnd unheard;
  (void)test::Await([&] {  // On a busy machine, the session may not answer in half a second.
    unheard = ticking.robot.Run({"path", "timer/tick", "unheard", "--seconds", "60", "--timeout", "1"});
    return unheard.err.find("does not answer") == std::string::npos;
  });
  EXPECT_EQ(unheard.status, 3);
  EXPECT_EQ(unheard.err, "hgros: Nobody subscribes to unheard yet.\nhgros: This takes longer than --timeout allows.\n");
  const CommandEnd unknown = ticking.robot.Run({"path", "tikc", "tick", "--seconds", "60", "--timeout", "1"});
  EXPECT_THAT(unknown.err, HasSubstr("hgros: Nobody publishes on tikc yet. Did you mean tick?\n"));
}

TEST(HgrosTrace, WritesItsSummaryAsJsonButNothingToATerminal) {
  TickRobot ticking;
  CommandEnd end;  // On a busy machine, the session may not answer in time, or do nothing in 0.3 s.
  (void)test::Await([&] {
    end = ticking.robot.Run({"trace", "--seconds", "0.3", "--json", "-o", "/dev/null"});
    return end.out.find("\"sessions\":1") != std::string::npos && end.out.find("\"callbacks\":0") == std::string::npos;
  });
  EXPECT_EQ(end.status, 0) << end.err;
  rapidjson::Document summary;
  ASSERT_FALSE(summary.Parse(end.out.c_str()).HasParseError()) << end.out;
  EXPECT_EQ(std::string(summary["file"].GetString()), "/dev/null");
  EXPECT_GT(summary["callbacks"].GetInt(), 0);
  EXPECT_EQ(summary["sessions"].GetInt(), 1);
  CommandEnd text;
  (void)test::Await([&] {
    text = ticking.robot.Run({"trace", "--seconds", "0.3", "-o", "/dev/null"});
    return text.out.find(" of 1 session") != std::string::npos;
  });
  EXPECT_THAT(text.out, HasSubstr(" of 1 session are in /dev/null"));
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
