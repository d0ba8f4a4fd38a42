#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/screen/terminal_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// A robot that publishes to a node of its own.
struct BusyRobot {
  BusyRobot() { robot.AwaitAnnounced(); }

  RobotForCommands robot{"patrol"};
  Publisher<Log> publish = robot.session().Advertise<Log>("status");
  Subscription heard = robot.session().FromAny<Log>("status", Invoke::kSerial, [](const Log&) {}, {.name = "hearing"});
  NodeTimer timer = robot.session().CreateTimer("tick", std::chrono::milliseconds(20),
                                                [this](const Tick&) { publish(std::make_unique<Log>()); });
  std::map<std::string, std::string> environment = robot.environment();
};

TEST(HgrosTop, ShowsSessionsNodesAndChannelsAndEndsWithQ) {
  const BusyRobot robot;
  TerminalRun top({"top"}, robot.environment);
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
  EXPECT_TRUE(top.Shows("foxglove.Log"));
  top.Type("q");
  EXPECT_EQ(top.Wait(), 0);
  EXPECT_TRUE(top.Restored());
  EXPECT_EQ(top.screen().unknown(), "");
}

TEST(HgrosTop, FollowsTheSizeOfTheTerminalDownToNothingAndShowsNoColorsIfTheyAreNotWanted) {
  const BusyRobot robot;
  TerminalRun top({"top", "channels"}, robot.environment);
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

  auto environment = robot.environment;
  environment["NO_COLOR"] = "1";
  TerminalRun plain({"top", "nodes"}, environment);
  EXPECT_TRUE(plain.Shows("hearing"));
  plain.Type("/x");
  EXPECT_TRUE(plain.Shows("Only rows with: x"));
  plain.Type("\r");
  EXPECT_TRUE(plain.Shows("only with \"x\""));
  EXPECT_FALSE(plain.screen().colored());
}

TEST(HgrosTop, LeavesTheTerminalAsItWasWhenASignalEndsOrSuspendsIt) {
  const BusyRobot robot;
  std::vector<int> signals{SIGINT, SIGTERM, SIGHUP, SIGABRT, SIGQUIT, SIGUSR1};
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // They report these, and end otherwise.
  signals.insert(signals.end(), {SIGSEGV, SIGBUS, SIGFPE});
#endif
  std::vector<std::unique_ptr<TerminalRun>> runs;  // The last one ends with Ctrl-C.
  for (std::size_t i = 0; i <= signals.size(); ++i) {
    runs.push_back(std::make_unique<TerminalRun>(std::vector<std::string>{"top"}, robot.environment));
  }
  for (std::size_t i = 0; i < runs.size(); ++i) {
    ASSERT_TRUE(runs[i]->Shows("patrol"));
    if (i < signals.size()) {
      runs[i]->Signal(signals[i]);
    } else {
      runs[i]->Type("\x03");
    }
    EXPECT_EQ(runs[i]->Wait(), 128 + (i < signals.size() ? signals[i] : SIGINT));
    EXPECT_TRUE(test::Await([&] { return runs[i]->Restored(); })) << i << runs[i]->written();
  }

  TerminalRun top({"top"}, robot.environment);
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

TEST(HgrosTop, SaysWhyThereIsNoFullScreen) {
  const std::map<std::string, std::string> nobody = OwnDomain();
  EXPECT_THAT(RunToEnd({"top"}, nobody),
              AllOf(Ends(2, HasSubstr("needs a terminal. `hgros top --once` writes a table")), Prints("")));
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

TEST(HgrosTop, WritesTablesAndJsonForProgramsAndItsExamplesWork) {
  const BusyRobot busy;
  EXPECT_THAT(busy.robot.Run(Patiently({"top", "nodes", "--once"})),
              Prints(0, AllOf(HasSubstr("NODE     CHANNEL     SESSION"), HasSubstr("hearing  status      patrol:"),
                              Not(HasSubstr("\x1b")))));
  EXPECT_THAT(LinesOf(busy.robot.Run(Patiently({"top", "--json", "-n", "1"})).out),
              testing::ElementsAre(
                  AllOf(testing::StartsWith("{\"process\":\"patrol\",\"pid\":"), HasSubstr("\"cpu_percent\":"))));
  EXPECT_EQ(busy.robot.Run(Patiently({"top", "-n", "1"})).status, 0);
  EXPECT_THAT(busy.robot.Run({"top", "--once", "-n", "2"}).err, HasSubstr("It contradicts --once."));
  EXPECT_EQ(busy.robot.Run({"top", "--batch", "--timeout", "0.5"}).status, 3);
  for (const std::vector<std::string>& words : ExamplesOf("top")) {
    const TerminalRun top(Patiently(words), busy.environment);
    EXPECT_TRUE(top.Shows(words.back() == "2" ? "status" : "patrol")) << testing::PrintToString(words);
    if (words.size() == 1) top.Type("q");
    EXPECT_EQ(top.Wait(), 0) << testing::PrintToString(words);
  }
}

}  // namespace
}  // namespace hgros::cli
