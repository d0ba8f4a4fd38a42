#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <foxglove/CompressedImage.pb.h>
#include <foxglove/LaserScan.pb.h>
#include <foxglove/PoseInFrame.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

TEST(HgrosHelp, ExplainsAllCommandsAndEachWithItsExamples) {
  EXPECT_THAT(RunToEnd({"help"}), Writes(AllOf(HasSubstr("  list "), HasSubstr("  echo "))));
  TwoAtATime(Commands().size(), [](std::size_t i) {
    const CommandEntry& entry = Commands()[i];
    if (entry.family() || entry.hidden()) return;
    std::vector<std::string> words = ShellWords(std::string(entry.name));
    words.emplace_back("--help");
    const CommandEnd end = RunToEnd(words);
    EXPECT_EQ(end.status, 0);
    const std::string examples = end.out.substr(end.out.find("Examples:"));
    EXPECT_GE(LinesOf(examples).size(), 5U) << entry.name;
    for (const Example& example : entry.make()->Examples()) {
      EXPECT_TRUE(example.line.starts_with("hgros " + std::string(entry.name))) << example.line;
      EXPECT_THAT(examples, HasSubstr("  " + example.line + "\n"));
    }
    words.pop_back();
    words.insert(words.begin(), "help");
    EXPECT_THAT(RunToEnd(words), Writes(end.out));
  });
  EXPECT_THAT(RunToEnd({"help", "param", "get"}),
              Prints(0, HasSubstr("Usage: hgros param get [SESSION] [PATH] [OPTIONS]\n")));
  EXPECT_EQ(RunToEnd({"param", "--help"}).status, 0);
}

TEST(HgrosHelp, RefusesWrongNamesAndValues) {
  EXPECT_THAT(RunToEnd({"lst"}), Ends(2, "hgros: There is no command \"lst\". Did you mean list?\n"));
  EXPECT_THAT(RunToEnd({"topic", "list"}), Ends(2, "hgros: There is no command \"topic\". Use `hgros list`.\n"));
  for (const char* name : {"node", "launch", "rosbag"}) {
    EXPECT_THAT(RunToEnd({name, "info"}), Ends(2, HasSubstr(". Use `hgros "))) << name;
  }
  EXPECT_THAT(RunToEnd({"run", "demo_nodes_cpp", "talker"}), Ends(2, HasSubstr("`hgros components`")));
  EXPECT_THAT(RunToEnd({"list", "--domian", "x"}),
              Ends(2, "hgros: --domian is not an option. Did you mean --domain?\n"));
  EXPECT_EQ(RunToEnd({"help", "list", "all"}).err, "hgros: \"all\" is one argument too many.\n");
  EXPECT_THAT(RunToEnd({"list", "[a,b]"}).err, HasSubstr("WHAT: \"[a,b]\" is not one of:"));
  EXPECT_THAT(RunToEnd({"echo", "scan", "--rate", "-1.5"}).err, HasSubstr("\"-1.5\" is not a number above zero."));
  EXPECT_EQ(RunToEnd({"list", "nodes", "-1"}).err, "hgros: -1 is not an option.\n");
  EXPECT_THAT(RunToEnd({"echo", "scan", "-n", "0"}).err, HasSubstr("\"0\" is not a whole number above zero."));
  EXPECT_THAT(RunToEnd({"echo", "scan", "--rate", "fast"}).err, HasSubstr("\"fast\" is not a number above zero."));
  EXPECT_THAT(RunToEnd({"echo"}), Ends(2, StartsWith("hgros: CHANNEL is missing.")));
}

TEST(HgrosVersion, IsThatOfTheProjectAndStandsAlone) {
  EXPECT_THAT(RunToEnd({"--version"}).out, testing::MatchesRegex("hgros [0-9]+\\.[0-9]+\\.[0-9]+\n"));
  EXPECT_THAT(RunToEnd({"--version", "extra"}),
              AllOf(Ends(2, HasSubstr("--version takes nothing else, but there is \"extra\".")), Prints("")));
}

TEST(HgrosExamples, RunBesideARobot) {
  RobotForCommands robot("talker");
  const auto scan = robot.session().Advertise<foxglove::LaserScan>("scan");
  const auto odometry = robot.session().Advertise<foxglove::PoseInFrame>("odometry");
  const auto camera = robot.session().Advertise<foxglove::CompressedImage>("camera");
  const Subscription heard =
      robot.session().FromAny<foxglove::LaserScan>("scan", Invoke::kSerial, [](const foxglove::LaserScan&) {});
  const NodeTimer timer = robot.session().CreateTimer("all", std::chrono::milliseconds(5), [&](const Tick&) {
    scan(std::make_unique<foxglove::LaserScan>());
    odometry(std::make_unique<foxglove::PoseInFrame>());
    camera(std::make_unique<foxglove::CompressedImage>());
  });
  robot.AwaitAnnounced();
  std::map<std::string, std::unique_ptr<CommandRun>> runs;  // By line; all at the same time.
  for (const char* command : {"bw", "delay", "echo", "help", "hz", "info", "list"}) {
    for (const std::vector<std::string>& words : ExamplesOf(command)) {
      EXPECT_EQ(words.front(), command);
      runs[testing::PrintToString(words)] = std::make_unique<CommandRun>(words, robot.environment());
    }
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(2500);
  for (const auto& [line, run] : runs) {
    EXPECT_TRUE(test::Await([&run = *run] { return !run.out().empty(); })) << line << run->err();
    const int status = run->Wait(std::max(end - std::chrono::steady_clock::now(), std::chrono::nanoseconds(1)));
    if (status == -1) {  // Such as hz, which goes on until Ctrl-C.
      run->Signal(SIGINT);
      EXPECT_THAT(run->Wait(), testing::AnyOf(0, 128 + SIGINT)) << line << " may just have ended by itself.";
    } else {
      EXPECT_EQ(status, 0) << line << run->err();
    }
  }
}

}  // namespace
}  // namespace hgros::cli
