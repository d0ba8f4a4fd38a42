#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr const char* kServices =
    "components: {numbers: {type: relay/Numbers}, checker: {type: relay/Checker}}\n"
    "processes:\n"
    "  front: {components: [numbers], restart: on-failure, memory: 200MB, cpus: [0, 1], nice: 5, env: {LEVEL: 3}}\n"
    "programs:\n"
    "  screen: {command: [python3, -c, 'print(\"${HOME:-}$1; 100%\")'], priority: 20, restart: always}\n";

const std::vector<std::string> kComposed{"--image", "robot:1", "--path", "/robot/robot.yaml"};

CommandEnd ExportCompose(const RobotFolder& robot, const std::vector<std::string>& more = kComposed) {
  std::vector<std::string> words{"export", "compose", robot.file()};
  words.insert(words.end(), more.begin(), more.end());
  return RunToEnd(words, robot.environment());
}

// What Compose reads, as JSON. "no Compose" if it is not installed.
std::string ReadByCompose(const RobotFolder& robot, const std::string& text) {
  std::ofstream(robot.path("compose.yaml")) << text;
  return RunInShell("cd " + robot.path("").string() +
                        " || exit\n"
                        "if docker compose version > /dev/null 2>&1; then docker compose config --no-interpolate\n"
                        "elif command -v docker-compose > /dev/null; then docker-compose -f compose.yaml config\n"
                        "else echo no Compose; fi 2>&1; echo rc $?",
                    robot.environment())
      .out;
}

TEST(HgrosExportCompose, ServicesHaveWhatTheRobotFileSays) {
  const RobotFolder robot(kServices);
  const CommandEnd end = ExportCompose(robot);
  EXPECT_EQ(end.status, 0) << end.err;
  const std::string front =
      end.out.substr(end.out.find("  \"front\":"), end.out.find("  \"main\":") - end.out.find("  \"front\":"));
  EXPECT_THAT(front, AllOf(HasSubstr("    image: \"robot:1\"\n"),
                           HasSubstr("    entrypoint: [\"nice\", \"-n\", \"5\", \"hgros\", \"run\", "
                                     "\"/robot/robot.yaml\", \"--process=front\"]\n"),
                           HasSubstr("    network_mode: \"service:hgros-network\"\n"),
                           HasSubstr("    volumes: [\"tmp:/tmp\"]\n"), HasSubstr("    restart: on-failure\n"),
                           HasSubstr("    mem_limit: 200000000b\n"), HasSubstr("    cpuset: \"0,1\"\n"),
                           HasSubstr("      \"LEVEL\": \"3\"\n"), Not(HasSubstr("SYS_NICE"))));
  const std::string screen = end.out.substr(end.out.find("  \"screen\":"));
  EXPECT_THAT(screen, AllOf(HasSubstr("[\"chrt\", \"--fifo\", \"20\", \"python3\""), HasSubstr("cap_add: [SYS_NICE]"),
                            HasSubstr("restart: always"), HasSubstr("depends_on: [hgros-network, \"front\", \"main\"]"),
                            HasSubstr("$$1; 100%"), Not(HasSubstr("mem_limit"))));
}

TEST(HgrosExportCompose, ComposeReadsIt) {
  const RobotFolder robot(kServices);
  const std::string read = ReadByCompose(robot, ExportCompose(robot).out);
  if (read.starts_with("no ")) GTEST_SKIP() << "Docker Compose is not installed.";
  EXPECT_THAT(read, AllOf(HasSubstr("rc 0\n"), HasSubstr("mem_limit: "),
                          HasSubstr("network_mode: service:hgros-network"), HasSubstr("$$1; 100%")));
  // It does see mistakes.
  std::string wrong = ExportCompose(robot).out;
  wrong.replace(wrong.find("mem_limit"), 9, "mem_limot");
  EXPECT_THAT(ReadByCompose(robot, wrong), HasSubstr("mem_limot"));
}

TEST(HgrosExportCompose, NamesThatYamlWouldReadAsSomethingElseAreQuoted) {
  const RobotFolder robot("components: {a: {type: relay/Does}}\nprocesses: {'no': {components: [a]}}\n");
  EXPECT_THAT(ExportCompose(robot).out, HasSubstr("\n  \"no\":\n"));
}

TEST(HgrosExportCompose, WritesAFileIntoAFolder) {
  const RobotFolder robot(kServices);
  const CommandEnd end = ExportCompose(robot, {"--image", "robot:1", "--path", "/robot/robot.yaml", "--hgros",
                                               "/opt/hgros", "--folder", robot.path("out")});
  EXPECT_EQ(end.status, 0) << end.err;
  std::ifstream file(robot.path("out/compose.yaml"));
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_THAT(text, AllOf(StartsWith("# Written by hgros export"), HasSubstr("working_dir: \"/robot\""),
                          HasSubstr("\"/opt/hgros\", \"run\", \"/robot/robot.yaml\"")));
}

TEST(HgrosExportCompose, SaysWhatComposeCannotHave) {
  EXPECT_EQ(ExportCompose(RobotFolder(kServices), {}).status, 2);
  EXPECT_THAT(ExportCompose(RobotFolder(kServices), {}).err,
              HasSubstr("Give the image of the containers: --image IMAGE."));
  EXPECT_THAT(ExportCompose(RobotFolder(kServices), {"--image", "a"}).err,
              HasSubstr("Say with --path where the file is"));
  const RobotFolder name("components: {a: {type: relay/Does}}\nprograms: {'läuft': {command: [ls]}}\n");
  EXPECT_THAT(ExportCompose(name).err, HasSubstr("cannot be the name of a service of Compose."));
  const RobotFolder hosts(
      "hosts: {base: {address: 10.0.0.2}}\ncomponents: {a: {type: relay/Does}}\n"
      "processes: {p: {components: [a], host: base}}\n");
  EXPECT_THAT(ExportCompose(hosts).err, HasSubstr("containers have no addresses of hosts"));
}

}  // namespace
}  // namespace hgros::cli
