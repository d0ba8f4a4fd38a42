#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <future>
#include <memory>
#include <optional>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/params/param_codec.hpp"
#include "hgros/params/param_service.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
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
    EXPECT_TRUE(test::Await([this] { return !Run({"list"}).out.empty(); }));
  }
  // `hgros param` with the arguments, patiently.
  [[nodiscard]] CommandEnd Run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "param");
    return robot_.Run(Patiently(std::move(arguments)));
  }

  RobotForCommands robot_{"robot"};
  ParamServer server_;
  std::optional<ParamService> service_;
  const test::ScratchFolder folder_;
  const std::string file_ = folder_ / "params.yaml";
};

TEST_F(HgrosParam, ListsGetsAndDescribesValues) {
  const CommandEnd list = Run({"list"});
  EXPECT_THAT(list, Prints(0,
                           "SESSION  PARAMETER       VALUE\nrobot    matcher.range   8.0\n"
                           "robot    matcher.method  icp\nrobot    gains           [1, 2]\n"));
  EXPECT_EQ(robot_.Run({"list", "params"}).out, list.out);
  EXPECT_THAT(LinesOf(Run({"list", "robot", "--json"}).out),
              ElementsAre(R"({"session":"robot","path":"matcher.range","value":8})",
                          R"({"session":"robot","path":"matcher.method","value":"icp"})",
                          R"({"session":"robot","path":"gains","value":[1,2]})"));
  EXPECT_EQ(Run({"get", "robot", "matcher.range"}).out, "8.0\n");
  EXPECT_EQ(Run({"get", "matcher.range"}).out, "8.0\n");
  EXPECT_EQ(Run({"get", "robot", "matcher"}).out, "range: 8.0\nmethod: icp\n");
  EXPECT_EQ(Run({"get", "gains[1]", "--json"}).out, "{\"session\":\"robot\",\"path\":\"gains[1]\",\"value\":2}\n");
  EXPECT_THAT(LinesOf(Run({"describe", "robot", "matcher"}).out),
              ElementsAre("PARAMETER       VALUE  DEFAULT  UNIT  TYPE    RANGE     DESCRIPTION",
                          "matcher.range   8.0    8.0      m     number  0 to 30   how far the laser sees",
                          "matcher.method  icp    icp            text    icp, ndt"));
  EXPECT_EQ(Run({"describe", "matcher.range", "--json"}).out,
            "{\"session\":\"robot\",\"path\":\"matcher.range\",\"value\":8,\"default\":8,\"unit\":\"m\","
            "\"type\":\"number\",\"least\":0,\"most\":30,"
            "\"choices\":[],\"read_only\":false,\"description\":\"how far the laser sees\"}\n");
  EXPECT_THAT(Run({"get", "robot", "matcher.rnge"}),
              Ends(1, "hgros: There is no parameter matcher.rnge. Did you mean matcher.range?\n"));
  EXPECT_THAT(robot_.Run({"param", "get", "robto", "matcher"}),
              Ends(1, "hgros: No session \"robto\" offers parameters. Did you mean \"robot\"?\n"));
  EXPECT_THAT(robot_.Run({"param", "get", "robto", "gains", "--timeout", "0.3"}),
              Ends(3, HasSubstr("Did you mean \"robot\"?")));

  ASSERT_TRUE(server_.Set("text", std::string("\x1b[31mred")).ok());
  EXPECT_EQ(Run({"get", "text"}).out, "\\x1b[31mred\n");  // What a terminal would obey.
  const ParamService second(robot_.session(), server_, "left");
  robot_.RunUntil(Patiently({"param", "get", "gains"}),
                  Ends(1, "hgros: Several sessions offer parameters: left, robot. Name one of them first.\n"));
}

TEST_F(HgrosParam, SetsAllOrNone) {
  EXPECT_THAT(Run({"set", "robot", "matcher.range", "2.5", "gains", "[-1, 5]"}),
              Prints(0, "PARAMETER      BEFORE  VALUE\nmatcher.range  8.0     2.5\ngains          [1, 2]  [-1, 5]\n"));
  EXPECT_EQ(server_.Get<double>("matcher.range"), 2.5);
  EXPECT_THAT(Run({"set", "gains", "[3]", "matcher.range", "-1"}),
              Ends(1, HasSubstr("matcher.range must be from 0.0 to 30.0 m, but is the number -1.")));
  EXPECT_EQ(server_.Get<std::vector<int>>("gains"), (std::vector{-1, 5}));

  EXPECT_THAT(Run({"set", "robot", "gain", "1"}),
              Ends(1, "hgros: There is no parameter gain. Did you mean gains? With --create it is created.\n"));
  EXPECT_EQ(Run({"set", "robot", "gain", "1", "--create"}).status, 0);
  EXPECT_EQ(server_.Get<int>("gain"), 1);
  EXPECT_THAT(Run({"set", "robot", "matcher", "{rnage: 2}"}),
              Ends(1, HasSubstr("hgros: There is no parameter matcher.rnage. Did you mean matcher.range?")));
  EXPECT_EQ(Run({"set", "robot", "matcher", "{range: 3}"}).status, 0);
  (void)server_.Declare("text", std::string("a"));
  for (const char* text : {"", "#ff0000", "a # b", "007", "[1]"}) {
    EXPECT_THAT(Run({"set", "robot", "text", text}), Ends(0, "")) << text;
    EXPECT_EQ(server_.Get<std::string>("text"), text);
  }
  EXPECT_THAT(Run({"set", "robot", "gain"}), Ends(2, "hgros: The last parameter, gain, has no value.\n"));

  {
    const auto validator = server_.AddValidator(
        "gains", [](const ParamEvent&) -> std::optional<std::string> { return "The motors are running."; });
    EXPECT_THAT(Run({"set", "robot", "gains", "[7]"}), Ends(1, "hgros: The motors are running.\n"));
  }
  std::promise<void> release;
  const auto blocked = server_.AddValidator("gains", [&](const ParamEvent&) -> std::optional<std::string> {
    release.get_future().wait();
    return std::nullopt;
  });
  const CommandEnd late = robot_.Run({"param", "set", "robot", "gains", "[7]", "--timeout", "3"});
  release.set_value();
  EXPECT_THAT(late, Ends(3, "hgros: The session \"robot\" did not answer in time, but it may still do so.\n"));
}

TEST_F(HgrosParam, NamesSessionsThatOfferParametersUnderOneName) {
  RobotForCommands other("other", robot_.domain());
  ParamServer server;
  (void)server.Declare("gains", std::vector<int>{3, 4});
  const ParamService service(other.session(), server, "robot", [](LogLevel, std::string_view) {});
  other.AwaitAnnounced();
  const std::string pid = ":" + std::to_string(getpid());
  const auto both =
      AllOf(HasSubstr("robot" + pid), HasSubstr("other" + pid),
            HasSubstr(" offer parameters under one name, \"robot\". Rename one, or give each robot its own "
                      "HGROS_DOMAIN.\n"));
  EXPECT_THAT(Run({"list"}), Ends(0, both));
  EXPECT_THAT(
      Run({"set", "robot", "gains", "[7]"}),
      Ends(1, AllOf(both, HasSubstr("hgros: Nothing was changed, because several sessions offer \"robot\".\n"))));
  EXPECT_EQ(server_.Get<std::vector<int>>("gains"), (std::vector{1, 2}));
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

TEST_F(HgrosParam, SavesAFileThatLoadReadsAllOrNothing) {
  ASSERT_EQ(Run({"save", "robot", file_}).status, 0);
  const std::string saved = folder_.Read("params.yaml");
  EXPECT_EQ(saved, "matcher:\n  range: 8.0\n  method: icp\ngains: [1, 2]\n");
  EXPECT_EQ(Run({"save"}).out, saved);
  ASSERT_TRUE(server_.Set("matcher.range", 3.0).ok());
  EXPECT_THAT(Run({"load", "robot", file_}), Prints(0, "PARAMETER      BEFORE  VALUE\nmatcher.range  3.0     8.0\n"));
  EXPECT_EQ(server_.Get<double>("matcher.range"), 8.0);

  EXPECT_THAT(Run({"load", "robot", folder_.Write("large.yaml", "gains: [5]\nmatcher: {range: 99}\n")}),
              Ends(1, HasSubstr("matcher.range must be from 0.0 to 30.0 m")));
  EXPECT_EQ(server_.Get<std::vector<int>>("gains"), (std::vector{1, 2}));
  const std::string broken = folder_.Write("broken.yaml", "gains: [5\n");
  EXPECT_THAT(Run({"load", "robot", broken}), Ends(2, HasSubstr(broken + ":")));

  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path());
  (void)folder_.Write("new.yaml", "wheels: {radius: 0.1}\n");
  for (const char* command : {"list", "get", "describe", "set", "save", "load"}) {
    for (const std::vector<std::string>& example : ExamplesOf("param " + std::string(command))) {
      EXPECT_THAT(robot_.Run(Patiently(example)), Ends(0, testing::_)) << testing::PrintToString(example);
    }
  }
  EXPECT_EQ(server_.Get<double>("wheels.radius"), 0.1);
  std::filesystem::current_path(before);
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
  watch.End();
}

TEST(HgrosParamAlone, SaysThatNoSessionOffersParametersAndListsItsCommands) {
  RobotForCommands robot;
  EXPECT_THAT(robot.Run({"param", "list"}), Ends(0, HasSubstr("hgros: No parameters in domain ")));
  EXPECT_EQ(robot.Run({"param", "get", "gains"}).err, "hgros: No session offers parameters.\n");
  EXPECT_THAT(robot.Run({"param", "save"}), Ends(1, "hgros: No session offers parameters.\n"));
  const CommandEnd help = RunToEnd({"help", "param"});
  EXPECT_EQ(help.status, 0);
  for (const char* command : {"list", "get", "set", "describe", "watch", "save", "load"}) {
    EXPECT_THAT(help.out, HasSubstr("\n  param " + std::string(command) + " "));
  }
  EXPECT_EQ(RunToEnd({"param"}).out, help.out);
  EXPECT_EQ(RunToEnd({"param", "gett"}).err, "hgros: There is no command \"param gett\". Did you mean param get?\n");
}

}  // namespace
}  // namespace hgros::cli
