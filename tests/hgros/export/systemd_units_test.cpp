#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kAll =
    "components:\n"
    "  numbers: {type: relay/Numbers}\n"
    "  checker: {type: relay/Checker, essential: true}\n"
    "processes:\n"
    "  front: {components: [numbers], restart: on-failure, memory: 200MB, cpus: [0, 1], nice: 5, env: {LEVEL: 3}}\n"
    "programs:\n"
    "  screen: {command: [python3, -c, 'print(\"$HOME; 100%\")'], priority: 20, restart: always}\n";

std::string TextOf(const std::filesystem::path& file) {
  std::ifstream in(file);
  EXPECT_TRUE(in.is_open()) << file;
  return {std::istreambuf_iterator<char>(in), {}};
}

CommandEnd Export(const RobotFolder& robot, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"export", "systemd", robot.file(), "--folder", robot.path("units")};
  words.insert(words.end(), more.begin(), more.end());
  return RunToEnd(words, robot.environment());
}

// What systemd-analyze says of all units in the folder; "no systemd-analyze" if it is not installed.
std::string Verify(const RobotFolder& robot, const std::string& scope) {
  return RunInShell(
             "command -v systemd-analyze > /dev/null || { echo no systemd-analyze; exit; }\n"
             "export XDG_RUNTIME_DIR=" +
                 robot.path("").string() +
                 "\n"
                 "systemd-analyze " +
                 scope + " --man=no verify " + robot.path("units").string() + "/* 2>&1; echo rc $?",
             robot.environment())
      .out;
}

TEST(HgrosExportSystemd, UnitsHaveReadinessWatchdogLimitsAndRestart) {
  const RobotFolder robot(kAll);
  const CommandEnd end = Export(robot);
  EXPECT_EQ(end.status, 0) << end.err;
  EXPECT_THAT(
      TextOf(robot.path("units/robot-front.service")),
      AllOf(HasSubstr("\nType=notify\n"), HasSubstr("\nWatchdogSec=10s\n"), HasSubstr("\nMemoryMax=200000000\n"),
            HasSubstr("\nCPUAffinity=0 1\n"), HasSubstr("\nNice=5\n"), HasSubstr("\nRestart=on-failure\n"),
            HasSubstr("\nEnvironment=LEVEL=3\n"), HasSubstr("\nPartOf=robot.target\n"),
            HasSubstr(" run " + robot.file() + " --process=front\n"), Not(HasSubstr("OnFailure"))));
  EXPECT_THAT(TextOf(robot.path("units/robot-main.service")),
              AllOf(HasSubstr("\nOnFailure=robot-end.target\n"), HasSubstr("\nRestartPreventExitStatus=10 11\n"),
                    HasSubstr("\nRestart=no\n"), Not(HasSubstr("MemoryMax"))));
  EXPECT_THAT(TextOf(robot.path("units/robot-screen.service")),
              AllOf(HasSubstr("/usr/bin/env -- python3 -c \"print(\\\"$$HOME; 100%%\\\")\"\n"),
                    HasSubstr("\nCPUSchedulingPriority=20\n"), HasSubstr("\nAfter=robot-front.service\n")));
  EXPECT_THAT(TextOf(robot.path("units/robot.target")),
              AllOf(HasSubstr("\nWants=robot-front.service\n"), HasSubstr("\nWants=robot-screen.service\n")));
  EXPECT_THAT(TextOf(robot.path("units/robot-end.target")), HasSubstr("\nConflicts=robot.target\n"));
}

TEST(HgrosExportSystemd, UnitsPassSystemdAnalyze) {
  for (const bool of_user : {true, false}) {
    const RobotFolder robot(kAll);
    ASSERT_EQ(Export(robot, of_user ? std::vector<std::string>{} : std::vector<std::string>{"--user", "root"}).status,
              0);
    const std::string scope = of_user ? "--user" : "--system";
    const std::string said = Verify(robot, scope);
    if (said.starts_with("no ")) GTEST_SKIP() << "systemd-analyze is not installed.";
    EXPECT_EQ(said, "rc 0\n");
    // It does see mistakes.
    std::ofstream(robot.path("units/robot-front.service"), std::ios::app) << "MemoryMaximum=1\n";
    EXPECT_THAT(Verify(robot, scope), HasSubstr("MemoryMaximum"));
  }
}

TEST(HgrosExportSystemd, UnusualTextsPassSystemdAnalyze) {
  const RobotFolder robot(
      "components: {'front-left': {type: relay/Numbers, essential: true}}\n"
      "processes: {'front-left': {components: [front-left], env: {A: 'two \"words\" \\ 100% $HOME'}}}\n"
      "programs: {'läuft': {command: ['./a b', ';', '']}}\n");
  ASSERT_EQ(Export(robot, {"--name", "my robot", "--set", "front-left.params.count=3"}).status, 0);
  EXPECT_THAT(TextOf(robot.path("units/my\\x20robot-front\\x2dleft.service")),
              HasSubstr(" --process=front-left --set=front-left.params.count=3\n"));
  const std::string said = Verify(robot, "--user");
  if (said.starts_with("no ")) GTEST_SKIP() << "systemd-analyze is not installed.";
  EXPECT_EQ(said, "rc 0\n");
}

TEST(HgrosExportSystemd, UnitsOfTheSystemRunAsTheUser) {
  const RobotFolder robot(kAll);
  ASSERT_EQ(Export(robot, {"--user", "robot", "--path", "/etc/robot/robot.yaml", "--hgros", "/opt/bin/hgros"}).status,
            0);
  EXPECT_THAT(TextOf(robot.path("units/robot-front.service")),
              AllOf(HasSubstr("\nUser=robot\n"), HasSubstr("\nEnvironment=XDG_RUNTIME_DIR=/run/hgros-robot\n"),
                    HasSubstr("\nExecStart=/opt/bin/hgros run /etc/robot/robot.yaml --process=front\n"),
                    HasSubstr("\nWorkingDirectory=/etc/robot\n")));
  const CommandEnd end = Export(robot, {"--user", "a b", "--force"});
  EXPECT_EQ(end.status, 2);
  EXPECT_THAT(end.err, HasSubstr("\"a b\" cannot be the name of a user."));
}

TEST(HgrosExportSystemd, VariablesOfTheFileBecomePartOfTheUnits) {
  const RobotFolder robot(
      "components: {a: {type: relay/Does, params: {what: \"${FOLDER}\"}}}\nprograms: {p: {command: [ls], env: {FOLDER: "
      "mine}}}\n");
  ASSERT_EQ(Export(robot).status, 0);
  EXPECT_THAT(TextOf(robot.path("units/robot-main.service")),
              AllOf(HasSubstr("\nEnvironment=FOLDER=" + robot.environment().at("FOLDER") + "\n"),
                    HasSubstr("\nEnvironment=HGROS_DOMAIN=")));
  EXPECT_THAT(TextOf(robot.path("units/robot-p.service")), HasSubstr("\nEnvironment=FOLDER=mine\n"));
}

TEST(HgrosExportSystemd, OneHostHasItsPart) {
  const RobotFolder robot(
      "hosts: {cart: {address: 10.0.0.1, home: true}, base: {address: 10.0.0.2}}\n"
      "components: {a: {type: relay/Does}, b: {type: relay/Does}}\nprocesses: {p: {components: [a], host: base}}\n");
  const CommandEnd end = Export(robot);
  EXPECT_EQ(end.status, 1);
  EXPECT_THAT(end.err, HasSubstr("runs on the host \"base\""));
  ASSERT_EQ(Export(robot, {"--host", "base"}).status, 0);
  EXPECT_THAT(TextOf(robot.path("units/robot-p.service")), HasSubstr(" --process=p --host=base\n"));
  EXPECT_FALSE(std::filesystem::exists(robot.path("units/robot-main.service")));
}

TEST(HgrosExportSystemd, ReplacesNoOtherFile) {
  const RobotFolder robot(kAll);
  ASSERT_EQ(Export(robot).status, 0);
  ASSERT_EQ(Export(robot).status, 0) << "They are the same.";
  std::ofstream(robot.path("units/robot-main.service"), std::ios::app) << "# Mine\n";
  std::filesystem::remove(robot.path("units/robot.target"));
  const CommandEnd end = Export(robot);
  EXPECT_EQ(end.status, 1);
  EXPECT_THAT(end.err, HasSubstr("robot-main.service is there already, with another text."));
  EXPECT_FALSE(std::filesystem::exists(robot.path("units/robot.target"))) << "All or none.";
  EXPECT_EQ(Export(robot, {"--force"}).status, 0);
  EXPECT_THAT(TextOf(robot.path("units/robot-main.service")), Not(HasSubstr("# Mine")));
}

TEST(HgrosExportSystemd, SaysWhatNoUnitCanHave) {
  const RobotFolder variable("components: {a: {type: relay/Does}}\nprograms: {p: {command: [ls], env: {a-b: 1}}}\n");
  EXPECT_THAT(Export(variable).err, HasSubstr("systemd accepts no variable \"a-b\"."));
  const RobotFolder program("components: {a: {type: relay/Does}}\nprograms: {p: {command: [a=b]}}\n");
  EXPECT_THAT(Export(program).err, HasSubstr("its name has a \"=\""));
}

}  // namespace
}  // namespace hgros::cli
