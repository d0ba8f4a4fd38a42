#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/screen/terminal_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::HasSubstr;
using testing::Not;

// A robot that publishes to a node of its own.
class BusyRobot {
 public:
  BusyRobot() : publish_(robot_.session().Advertise<Log>("status")) {
    heard_ = robot_.session().FromAny<Log>("status", Invoke::kSerial, [](const Log&) {}, {.name = "hearing"});
    timer_ = robot_.session().CreateTimer("tick", std::chrono::milliseconds(20),
                                          [this](const Tick&) { publish_(std::make_unique<Log>()); });
    robot_.AwaitAnnounced();
  }
  [[nodiscard]] const RobotForCommands& robot() const { return robot_; }
  [[nodiscard]] std::map<std::string, std::string> environment() const { return robot_.environment(); }

 private:
  RobotForCommands robot_{"patrol"};
  Publisher<Log> publish_;
  Subscription heard_;
  NodeTimer timer_;
};

TEST(HgrosTop, ShowsSessionsNodesAndChannelsAndEndsWithQ) {
  const BusyRobot robot;
  TerminalRun top({"top"}, robot.environment());
  EXPECT_TRUE(top.Shows("patrol:" + std::to_string(getpid())));
  EXPECT_TRUE(top.Shows(" Hz")) << top.written();
  EXPECT_FALSE(top.Restored());
  top.Type("\t");
  EXPECT_TRUE(top.Shows("hearing"));
  top.Type("\r");
  EXPECT_TRUE(top.Shows("Executor")) << "all about the node";
  top.Type("\x1b");
  EXPECT_TRUE(top.ShowsNot("Executor"));
  top.Type("3");
  EXPECT_TRUE(top.Shows("BANDWIDTH"));
  top.Type("/nothing");
  EXPECT_TRUE(top.Shows("Nothing contains \"nothing\"."));
  top.Type("\x1b");
  EXPECT_TRUE(top.Shows("foxglove.Log"));
  top.Type("h");
  EXPECT_TRUE(top.Shows("Reverse the order"));
  top.Type("q");
  EXPECT_EQ(top.Wait(), 0);
  EXPECT_TRUE(top.Restored());
  EXPECT_EQ(top.screen().unknown(), "");
}

TEST(HgrosTop, FollowsTheSizeOfTheTerminalDownToNothing) {
  const BusyRobot robot;
  TerminalRun top({"top", "channels"}, robot.environment());
  EXPECT_TRUE(top.Shows("status"));
  top.Resize(10, 3);
  EXPECT_TRUE(top.ShowsNot("Channels"));
  EXPECT_TRUE(top.Shows("status")) << "a heading, a row and a line of keys";
  top.Resize(1, 1);
  top.Type("h\x1b");
  top.Resize(120, 40);
  EXPECT_TRUE(top.Shows("DROPPED"));
  EXPECT_TRUE(top.Shows("status"));
  top.Type("q");
  EXPECT_EQ(top.Wait(), 0);
}

TEST(HgrosTop, LeavesTheTerminalAsItWasWhenASignalEndsIt) {
  const BusyRobot robot;
  std::vector<int> signals{SIGINT, SIGTERM, SIGHUP, SIGABRT, SIGQUIT, SIGUSR1};
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // They report these, and end otherwise.
  signals.insert(signals.end(), {SIGSEGV, SIGBUS, SIGFPE});
#endif
  for (const int number : signals) {
    TerminalRun top({"top"}, robot.environment());
    ASSERT_TRUE(top.Shows("patrol"));
    top.Signal(number);
    EXPECT_EQ(top.Wait(), 128 + number);
    EXPECT_TRUE(test::Await([&] { return top.Restored(); })) << number << top.written();
  }
}

TEST(HgrosTop, LeavesTheTerminalAsItWasAfterCtrlC) {
  const BusyRobot robot;
  TerminalRun top({"top"}, robot.environment());
  ASSERT_TRUE(top.Shows("patrol"));
  top.Type("\x03");
  EXPECT_EQ(top.Wait(), 128 + SIGINT);
  EXPECT_TRUE(test::Await([&] { return top.Restored(); })) << top.written();
}

TEST(HgrosTop, LeavesTheTerminalWhileItIsSuspended) {
  const BusyRobot robot;
  TerminalRun top({"top"}, robot.environment());
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(top.Shows("patrol"));
    top.Type("\x1a");
    ASSERT_TRUE(top.Shows("suspended " + std::to_string(i + 1)));
    EXPECT_TRUE(test::Await([&] { return top.Restored(); })) << top.written();
    top.Resize(100, 30);
    top.Type("\n");  // fg
  }
  ASSERT_TRUE(top.Shows("patrol"));
  top.Type("q");
  EXPECT_EQ(top.Wait(), 0) << top.written();
  EXPECT_TRUE(test::Await([&] { return top.Restored(); })) << top.written();
}

TEST(HgrosTop, ShowsNoColorsIfTheyAreNotWanted) {
  const BusyRobot robot;
  auto environment = robot.environment();
  environment["NO_COLOR"] = "1";
  TerminalRun top({"top", "nodes"}, environment);
  EXPECT_TRUE(top.Shows("hearing"));
  top.Type("/x");
  EXPECT_TRUE(top.Shows("Only rows with: x"));
  top.Type("\r");
  EXPECT_TRUE(top.Shows("only with \"x\""));
  EXPECT_FALSE(top.screen().colored());
}

TEST(HgrosTop, SaysWhyThereIsNoFullScreen) {
  const std::map<std::string, std::string> nobody{{"HGROS_DOMAIN", "cli" + std::to_string(RandomId())}};
  const CommandEnd piped = RunToEnd({"top"}, nobody);
  EXPECT_EQ(piped.status, 2);
  EXPECT_EQ(piped.out, "");
  EXPECT_THAT(piped.err, HasSubstr("needs a terminal. `hgros top --once` writes a table"));
  for (const auto& [kind, why] : {std::pair("dumb", "TERM=dumb"), std::pair("", "TERM is not set"),
                                  std::pair("nosuchterminal", "no description of the terminal \"nosuchterminal\"")}) {
    auto environment = nobody;
    environment["TERM"] = kind;
    TerminalRun top({"top"}, environment);
    EXPECT_TRUE(top.Shows(why)) << top.written();
    EXPECT_EQ(top.Wait(), 1);
    EXPECT_TRUE(top.Restored());
  }
}

TEST(HgrosTop, WritesTablesAndJsonForPrograms) {
  const BusyRobot robot;
  const CommandEnd table = robot.robot().Run(Patiently({"top", "nodes", "--once"}));
  EXPECT_EQ(table.status, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("NODE     CHANNEL     SESSION"));
  EXPECT_THAT(table.out, HasSubstr("hearing  status      patrol:"));
  EXPECT_THAT(table.out, Not(HasSubstr("\x1b")));
  const CommandEnd json = robot.robot().Run(Patiently({"top", "--json", "-n", "1"}));
  EXPECT_EQ(LinesOf(json.out).size(), 1U);
  EXPECT_THAT(json.out, testing::StartsWith("{\"process\":\"patrol\",\"pid\":"));
  EXPECT_THAT(json.out, HasSubstr("\"cpu_percent\":"));
  EXPECT_EQ(robot.robot().Run(Patiently({"top", "-n", "1"})).status, 0);
  EXPECT_THAT(robot.robot().Run({"top", "--once", "-n", "2"}).err, HasSubstr("It contradicts --once."));
  EXPECT_EQ(robot.robot().Run({"top", "--batch", "--timeout", "0.5"}).status, 3);
}

TEST(HgrosTop, ItsExamplesWork) {
  const BusyRobot robot;
  for (const std::vector<std::string>& words : ExamplesOf("top")) {
    TerminalRun top(Patiently(words), robot.environment());
    EXPECT_TRUE(top.Shows(words.back() == "2" ? "status" : "patrol")) << testing::PrintToString(words);
    if (words.size() == 1) top.Type("q");
    EXPECT_EQ(top.Wait(), 0) << testing::PrintToString(words);
  }
}

}  // namespace
}  // namespace hgros::cli
