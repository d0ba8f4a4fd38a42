#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <memory>
#include <optional>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/params/param_codec.hpp"
#include "hgros/params/param_service.hpp"

namespace hgros::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class HgrosParam : public testing::Test {
 protected:
  HgrosParam() {
    (void)server_.Declare("matcher.range", 8.0,
                          {.description = "how far the laser sees", .unit = "m", .least = 0, .most = 30});
    (void)server_.Declare("matcher.method", std::string("icp"), {.choices = {"icp", "ndt"}});
    (void)server_.Declare("gains", std::vector<int>{1, 2});
    service_.emplace(robot_.session(), server_);
    // A session announces its channels a moment after they were made.
    EXPECT_TRUE(test::Await([this] { return !robot_.Run(Patiently({"param", "list"})).out.empty(); }));
  }
  ~HgrosParam() override { std::filesystem::remove_all(file_); }

  RobotForCommands robot_{"robot"};
  ParamServer server_;
  std::optional<ParamService> service_;
  const std::string file_ = testing::TempDir() + "hgros_param_" + std::to_string(RandomId()) + ".yaml";
};

TEST_F(HgrosParam, ListsValuesAsTableAndAsJson) {
  const CommandEnd end = robot_.Run(Patiently({"param", "list"}));
  EXPECT_EQ(end.status, 0) << end.err;
  EXPECT_THAT(LinesOf(end.out), ElementsAre("SESSION  PARAMETER       VALUE", "robot    matcher.range   8.0",
                                            "robot    matcher.method  icp", "robot    gains           [1, 2]"));
  EXPECT_EQ(robot_.Run({"list", "params"}).out, end.out);
  EXPECT_THAT(LinesOf(robot_.Run(Patiently({"param", "list", "robot", "--json"})).out),
              ElementsAre(R"({"session":"robot","path":"matcher.range","value":8})",
                          R"({"session":"robot","path":"matcher.method","value":"icp"})",
                          R"({"session":"robot","path":"gains","value":[1,2]})"));
}

TEST_F(HgrosParam, GetsOneValueOrAPartOfTheTree) {
  EXPECT_EQ(robot_.Run(Patiently({"param", "get", "robot", "matcher.range"})).out, "8.0\n");
  EXPECT_EQ(robot_.Run(Patiently({"param", "get", "matcher.range"})).out, "8.0\n");
  EXPECT_EQ(robot_.Run(Patiently({"param", "get", "robot", "matcher"})).out, "range: 8.0\nmethod: icp\n");
  EXPECT_EQ(robot_.Run(Patiently({"param", "get", "gains[1]", "--json"})).out,
            "{\"session\":\"robot\",\"path\":\"gains[1]\",\"value\":2}\n");
}

TEST_F(HgrosParam, NamesTheNearestSessionAndPath) {
  const CommandEnd path = robot_.Run(Patiently({"param", "get", "robot", "matcher.rnge"}));
  EXPECT_EQ(path.status, 1);
  EXPECT_EQ(path.err, "hgros: There is no parameter matcher.rnge. Did you mean matcher.range?\n");
  const CommandEnd session = robot_.Run({"param", "get", "robto", "matcher"});
  EXPECT_EQ(session.status, 1);
  EXPECT_EQ(session.err, "hgros: No session \"robto\" offers parameters. Did you mean \"robot\"?\n");
}

TEST_F(HgrosParam, AsksForTheSessionIfSeveralOfferParameters) {
  const ParamService second(robot_.session(), server_, "left");
  CommandEnd end;
  EXPECT_TRUE(test::Await([&] {
    end = robot_.Run(Patiently({"param", "get", "gains"}));
    return end.status == 1;
  }));
  EXPECT_EQ(end.err, "hgros: Several sessions offer parameters: left, robot. Name one of them first.\n");
}

TEST_F(HgrosParam, SetsAllOrNone) {
  const CommandEnd end = robot_.Run(Patiently({"param", "set", "robot", "matcher.range", "2.5", "gains", "[-1, 5]"}));
  EXPECT_EQ(end.status, 0) << end.err;
  EXPECT_THAT(LinesOf(end.out), ElementsAre("PARAMETER      BEFORE  VALUE", "matcher.range  8.0     2.5",
                                            "gains          [1, 2]  [-1, 5]"));
  EXPECT_EQ(server_.Get<double>("matcher.range"), 2.5);
  const CommandEnd refused = robot_.Run(Patiently({"param", "set", "gains", "[3]", "matcher.range", "-1"}));
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("matcher.range must be from 0.0 to 30.0 m, but is the number -1."));
  EXPECT_EQ(server_.Get<std::vector<int>>("gains"), (std::vector{-1, 5}));
}

TEST_F(HgrosParam, ShowsTheRefusalOfAValidator) {
  const auto validator = server_.AddValidator(
      "gains", [](const ParamEvent&) -> std::optional<std::string> { return "The motors are running."; });
  const CommandEnd end = robot_.Run(Patiently({"param", "set", "robot", "gains", "[7]"}));
  EXPECT_EQ(end.status, 1);
  EXPECT_EQ(end.err, "hgros: The motors are running.\n");
}

TEST_F(HgrosParam, CreatesAParameterOnlyIfAsked) {
  const CommandEnd refused = robot_.Run(Patiently({"param", "set", "robot", "gain", "1"}));
  EXPECT_EQ(refused.status, 1);
  EXPECT_EQ(refused.err, "hgros: There is no parameter gain. Did you mean gains? With --create it is created.\n");
  EXPECT_EQ(robot_.Run(Patiently({"param", "set", "robot", "gain", "1", "--create"})).status, 0);
  EXPECT_EQ(server_.Get<int>("gain"), 1);
  const CommandEnd within = robot_.Run(Patiently({"param", "set", "robot", "matcher", "{rnage: 2}"}));
  EXPECT_EQ(within.status, 1);
  EXPECT_THAT(within.err, HasSubstr("hgros: There is no parameter matcher.rnage. Did you mean matcher.range?"));
  EXPECT_EQ(robot_.Run(Patiently({"param", "set", "robot", "matcher", "{range: 3}"})).status, 0);
  const CommandEnd odd = robot_.Run(Patiently({"param", "set", "robot", "gain"}));
  EXPECT_EQ(odd.status, 2);
  EXPECT_EQ(odd.err, "hgros: The last parameter, gain, has no value.\n");
}

TEST_F(HgrosParam, DescribesWhatIsDeclared) {
  const CommandEnd end = robot_.Run(Patiently({"param", "describe", "robot", "matcher"}));
  EXPECT_THAT(LinesOf(end.out),
              ElementsAre("PARAMETER       VALUE  DEFAULT  UNIT  TYPE    RANGE     DESCRIPTION",
                          "matcher.range   8.0    8.0      m     number  0 to 30   how far the laser sees",
                          "matcher.method  icp    icp            text    icp, ndt"));
  EXPECT_EQ(robot_.Run(Patiently({"param", "describe", "matcher.range", "--json"})).out,
            "{\"session\":\"robot\",\"path\":\"matcher.range\",\"value\":8,\"default\":8,\"unit\":\"m\","
            "\"type\":\"number\",\"least\":0,\"most\":30,"
            "\"choices\":[],\"read_only\":false,\"description\":\"how far the laser sees\"}\n");
}

TEST_F(HgrosParam, WatchesOneLinePerChange) {
  CommandRun watch({"param", "watch", "robot", "matcher", "-n", "2", "--timeout", "60"}, robot_.environment());
  ASSERT_TRUE(test::Await([&] { return watch.err().find("Watching") != std::string::npos; })) << watch.err();
  ASSERT_TRUE(server_.Set("gains", std::vector{9}).ok());
  ASSERT_TRUE(
      server_.Change({ParamChange::Of("matcher.range", 4.0), ParamChange::Of("matcher.method", std::string("ndt"))})
          .ok());
  EXPECT_EQ(watch.Wait(), 0);
  const std::vector<std::string> lines = LinesOf(watch.out());
  ASSERT_EQ(lines.size(), 2U) << watch.out();
  EXPECT_THAT(lines[0], testing::EndsWith("  matcher.range: 8.0 -> 4.0"));
  EXPECT_THAT(lines[1], testing::EndsWith("  matcher.method: icp -> ndt"));
}

TEST_F(HgrosParam, SavesAFileThatLoadReads) {
  ASSERT_EQ(robot_.Run(Patiently({"param", "save", "robot", file_})).status, 0);
  std::ifstream in(file_);
  const std::string saved{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(saved, "matcher:\n  range: 8.0\n  method: icp\ngains: [1, 2]\n");
  EXPECT_EQ(robot_.Run(Patiently({"param", "save"})).out, saved);
  ASSERT_TRUE(server_.Set("matcher.range", 3.0).ok());
  const CommandEnd load = robot_.Run(Patiently({"param", "load", "robot", file_}));
  EXPECT_EQ(load.status, 0) << load.err;
  EXPECT_THAT(LinesOf(load.out), ElementsAre("PARAMETER      BEFORE  VALUE", "matcher.range  3.0     8.0"));
  EXPECT_EQ(server_.Get<double>("matcher.range"), 8.0);
}

TEST_F(HgrosParam, LoadsAllOrNothingAndNamesThePlaceOfAFault) {
  std::ofstream(file_) << "gains: [5]\nmatcher: {range: 99}\n";
  const CommandEnd refused = robot_.Run(Patiently({"param", "load", "robot", file_}));
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("matcher.range must be from 0.0 to 30.0 m"));
  EXPECT_EQ(server_.Get<std::vector<int>>("gains"), (std::vector{1, 2}));
  std::ofstream(file_) << "gains: [5\n";
  const CommandEnd broken = robot_.Run(Patiently({"param", "load", "robot", file_}));
  EXPECT_EQ(broken.status, 2);
  EXPECT_THAT(broken.err, HasSubstr(file_ + ":"));
}

TEST_F(HgrosParam, EndsWithCode3WhenTheAnswerIsLate) {
  std::promise<void> release;
  const auto blocked = server_.AddValidator("gains", [&](const ParamEvent&) -> std::optional<std::string> {
    release.get_future().wait();
    return std::nullopt;
  });
  const CommandEnd end = robot_.Run({"param", "set", "robot", "gains", "[7]", "--timeout", "3"});
  release.set_value();
  EXPECT_EQ(end.status, 3);
  EXPECT_EQ(end.err, "hgros: The session \"robot\" did not answer in time, but it may still do so.\n");
}

TEST_F(HgrosParam, EndsWithCode3WhenTheSessionDoesNotComeInTime) {
  EXPECT_EQ(robot_.Run({"param", "get", "robto", "gains"}).status, 1);
  const CommandEnd end = robot_.Run({"param", "get", "robto", "gains", "--timeout", "0.3"});
  EXPECT_EQ(end.status, 3);
  EXPECT_THAT(end.err, HasSubstr("Did you mean \"robot\"?"));
}

TEST_F(HgrosParam, RunsItsExamples) {
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::create_directory(file_);
  std::filesystem::current_path(file_);
  std::ofstream("new.yaml") << "wheels: {radius: 0.1}\n";
  for (const char* command : {"list", "get", "describe", "set", "save", "load"}) {
    const auto examples = ExamplesOf("param " + std::string(command));
    EXPECT_GE(examples.size(), 2U) << command;
    for (const std::vector<std::string>& example : examples) {
      const CommandEnd end = robot_.Run(Patiently(example));
      EXPECT_EQ(end.status, 0) << testing::PrintToString(example) << end.err;
    }
  }
  EXPECT_EQ(server_.Get<double>("wheels.radius"), 0.1);
  std::filesystem::current_path(before);
}

TEST_F(HgrosParam, EscapesWhatATerminalWouldObey) {
  ASSERT_TRUE(server_.Set("text", std::string("\x1b[31mred")).ok());
  EXPECT_EQ(robot_.Run(Patiently({"param", "get", "text"})).out, "\\x1b[31mred\n");
}

TEST(HgrosParamAlone, SaysWhenTheWatchedSessionEnds) {
  auto robot = std::make_unique<RobotForCommands>();
  ParamServer server;
  auto service = std::make_unique<ParamService>(robot->session(), server);
  robot->AwaitAnnounced();
  CommandRun watch({"param", "watch", "robot", "--timeout", "90"}, robot->environment());
  ASSERT_TRUE(test::Await([&] { return watch.err().find("Watching") != std::string::npos; })) << watch.err();
  service.reset();
  robot.reset();
  EXPECT_TRUE(test::Await([&] { return watch.err().find("no longer offers its parameters") != std::string::npos; }));
  watch.Signal(SIGINT);
  EXPECT_EQ(watch.Wait(), 128 + SIGINT);
}

TEST(HgrosParamAlone, SaysThatNoSessionOffersParameters) {
  RobotForCommands robot;
  EXPECT_EQ(robot.Run({"param", "list"}).out, "");
  EXPECT_EQ(robot.Run({"param", "get", "gains"}).err, "hgros: No session offers parameters.\n");
  const CommandEnd end = robot.Run({"param", "save"});
  EXPECT_EQ(end.status, 1);
  EXPECT_EQ(end.err, "hgros: No session offers parameters.\n");
}

TEST(HgrosParamAlone, ListsItsCommandsInTheHelp) {
  const CommandEnd end = RunToEnd({"help", "param"});
  EXPECT_EQ(end.status, 0);
  for (const char* command : {"list", "get", "set", "describe", "watch", "save", "load"}) {
    EXPECT_THAT(end.out, HasSubstr("\n  param " + std::string(command) + " "));
  }
  EXPECT_EQ(RunToEnd({"param"}).out, end.out);
  EXPECT_EQ(RunToEnd({"param", "gett"}).err, "hgros: There is no command \"param gett\". Did you mean param get?\n");
}

}  // namespace
}  // namespace hgros::cli
