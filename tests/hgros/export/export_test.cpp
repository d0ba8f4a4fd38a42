// What `hgros export` writes, and what the tools that read it say of that.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
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

CommandEnd Export(const std::string& kind, const RobotFolder& robot, const std::vector<std::string>& options = {},
                  const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"export", kind, robot.file()};
  for (const auto* each : {&options, &more}) words.insert(words.end(), each->begin(), each->end());
  return robot.Ask(words);
}

const std::vector<std::string> kImage{"--image", "robot:1", "--path", "/robot/robot.yaml"};

constexpr const char* kServices =
    "components: {numbers: {type: relay/Numbers}, checker: {type: relay/Checker}}\n"
    "processes:\n"
    "  front: {components: [numbers], restart: on-failure, memory: 200MB, cpus: [0, 1], nice: 5, env: {LEVEL: 3}}\n"
    "programs:\n"
    "  screen: {command: [python3, -c, 'print(\"${HOME:-}$1; 100%\")'], priority: 20, restart: always}\n";

// What Compose reads, as JSON. "no Compose" if it is not installed.
std::string ReadByCompose(const RobotFolder& robot, const std::string& text) {
  robot.Write("compose.yaml", text);
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
  const CommandEnd end = Export("compose", robot, kImage);
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
  // YAML would read some names without quotes as something else.
  const std::string screen = end.out.substr(end.out.find("\n  \"screen\":\n"));
  EXPECT_THAT(screen, AllOf(HasSubstr("[\"chrt\", \"--fifo\", \"20\", \"python3\""), HasSubstr("cap_add: [SYS_NICE]"),
                            HasSubstr("restart: always"), HasSubstr("depends_on: [hgros-network, \"front\", \"main\"]"),
                            HasSubstr("$$1; 100%"), Not(HasSubstr("mem_limit"))));
}

TEST(HgrosExportCompose, ComposeReadsIt) {
  const RobotFolder robot(kServices);
  const std::string read = ReadByCompose(robot, Export("compose", robot, kImage).out);
  if (read.starts_with("no ")) GTEST_SKIP() << "Docker Compose is not installed.";
  EXPECT_THAT(read, AllOf(HasSubstr("rc 0\n"), HasSubstr("mem_limit: "),
                          HasSubstr("network_mode: service:hgros-network"), HasSubstr("$$1; 100%")));
  // It does see mistakes.
  std::string wrong = Export("compose", robot, kImage).out;
  wrong.replace(wrong.find("mem_limit"), 9, "mem_limot");
  EXPECT_THAT(ReadByCompose(robot, wrong), HasSubstr("mem_limot"));
}

TEST(HgrosExportCompose, WritesAFileIntoAFolder) {
  const RobotFolder robot(kServices);
  EXPECT_THAT(Export("compose", robot, kImage, {"--hgros", "/opt/hgros", "--folder", robot.path("out")}), Ends(0));
  EXPECT_THAT(robot.Read("out/compose.yaml"),
              AllOf(StartsWith("# Written by hgros export"), HasSubstr("working_dir: \"/robot\""),
                    HasSubstr("\"/opt/hgros\", \"run\", \"/robot/robot.yaml\"")));
}

TEST(HgrosExportCompose, SaysWhatComposeCannotHave) {
  EXPECT_THAT(Export("compose", RobotFolder(kServices)),
              Ends(2, HasSubstr("Give the image of the containers: --image IMAGE.")));
  EXPECT_THAT(Export("compose", RobotFolder(kServices), {"--image", "a"}).err,
              HasSubstr("Say with --path where the file is"));
  const RobotFolder name("components: {a: {type: relay/Does}}\nprograms: {'läuft': {command: [ls]}}\n");
  EXPECT_THAT(Export("compose", name, kImage).err, HasSubstr("cannot be the name of a service of Compose."));
  const RobotFolder hosts(
      "hosts: {base: {address: 10.0.0.2}}\ncomponents: {a: {type: relay/Does}}\n"
      "processes: {p: {components: [a], host: base}}\n");
  EXPECT_THAT(Export("compose", hosts, kImage).err, HasSubstr("containers have no addresses of hosts"));
}

constexpr const char* kPod =
    "components: {numbers: {type: relay/Numbers}, checker: {type: relay/Checker}}\n"
    "processes:\n"
    "  Front_1: {components: [numbers], restart: on-failure, memory: 200MB, cpus: [0, 1], nice: -5, env: {LEVEL: 3}}\n"
    "programs:\n"
    "  screen: {command: [python3, -c, 'print(\"$(HOME); 100%\")'], nice: 3}\n";

CommandEnd ExportPod(const RobotFolder& robot, const std::vector<std::string>& more = {}) {
  return Export("kubernetes", robot, kImage, more);
}

// What kubectl understands, with a variable that it adds: it refuses wrong types and leaves out unknown keys.
// "no kubectl" if it is not installed.
std::string ReadByKubectl(const RobotFolder& robot, const std::string& text) {
  robot.Write("pod.yaml", text);
  return RunInShell(
             "command -v kubectl > /dev/null || { echo no kubectl; exit; }\n"
             "kubectl set env --local -f " +
                 robot.path("pod.yaml").string() + " ADDED=1 -o yaml 2>&1; echo rc $?",
             robot.environment())
      .out;
}

TEST(HgrosExportKubernetes, ContainersHaveWhatTheRobotFileSays) {
  const RobotFolder robot(kPod);
  EXPECT_THAT(
      ExportPod(robot),
      Prints(0, AllOf(HasSubstr("kind: Job\n"), HasSubstr("restartPolicy: OnFailure\n"),
                      HasSubstr("command: [\"taskset\", \"--cpu-list\", \"0,1\", \"nice\", \"-n\", \"-5\", \"hgros\", "
                                "\"run\", \"/robot/robot.yaml\", \"--process=Front_1\"]\n"),
                      HasSubstr("- name: \"front-1\"\n"), HasSubstr("limits: {memory: \"200000000\"}"),
                      HasSubstr("{name: \"LEVEL\", value: \"3\"}"), HasSubstr("add: [SYS_NICE]"),
                      HasSubstr("$$(HOME); 100%"))));
}

TEST(HgrosExportKubernetes, KubectlUnderstandsIt) {
  for (const char* restart : {"never", "on-failure", "always"}) {
    const RobotFolder robot(kPod);
    const std::string text = ExportPod(robot, {"--set", std::string("programs.screen.restart=") + restart}).out;
    const std::string read = ReadByKubectl(robot, text);
    if (read.starts_with("no ")) GTEST_SKIP() << "kubectl is not installed.";
    EXPECT_THAT(read, AllOf(HasSubstr("rc 0\n"), HasSubstr("name: ADDED"), HasSubstr("memory: 200M\n"),
                            HasSubstr("shareProcessNamespace: true"), HasSubstr("terminationGracePeriodSeconds: 2"),
                            HasSubstr("workingDir: /robot"), HasSubstr("mountPath: /tmp"), HasSubstr("emptyDir: {}"),
                            HasSubstr("- SYS_NICE"), HasSubstr("--process=Front_1"), HasSubstr("$$(HOME); 100%")));
    EXPECT_THAT(read,
                HasSubstr(restart == std::string("always") ? "restartPolicy: Always" : "restartPolicy: OnFailure"));
    // It does see mistakes.
    std::string wrong = text;
    wrong.replace(wrong.find("\"200000000\""), 11, "[2]");
    EXPECT_THAT(ReadByKubectl(robot, wrong), Not(HasSubstr("rc 0\n")));
  }
}

TEST(HgrosExportKubernetes, ThePodFollowsTheStrongestRestart) {
  const RobotFolder robot("components: {a: {type: relay/Does}}\nprograms: {p: {command: [ls]}}\n");
  EXPECT_THAT(ExportPod(robot).out, AllOf(HasSubstr("backoffLimit: 0\n"), HasSubstr("restartPolicy: Never\n")));
  EXPECT_THAT(ExportPod(robot, {"--set", "programs.p.restart=always"}).out,
              AllOf(HasSubstr("kind: Deployment\n"), HasSubstr("restartPolicy: Always\n"), Not(HasSubstr("backoff"))));
}

TEST(HgrosExportKubernetes, SaysWhichNamesAreTheSame) {
  const RobotFolder same("components: {a: {type: relay/Does}}\nprograms: {p: {command: [ls]}, P: {command: [ls]}}\n");
  EXPECT_THAT(ExportPod(same).err, HasSubstr("\"P\" cannot be the name of a container in Kubernetes, beside \"p\"."));
  const RobotFolder none("components: {a: {type: relay/Does}}\nprograms: {'_': {command: [ls]}}\n");
  EXPECT_THAT(ExportPod(none).err, HasSubstr("\"_\" cannot be the name of a container in Kubernetes."));
  EXPECT_THAT(ExportPod(none, {"--name", "--"}).err, HasSubstr("Give another one with --name"));
}

constexpr const char* kAll =
    "components:\n"
    "  numbers: {type: relay/Numbers}\n"
    "  checker: {type: relay/Checker, essential: true}\n"
    "processes:\n"
    "  front: {components: [numbers], restart: on-failure, memory: 200MB, cpus: [0, 1], nice: 5, env: {LEVEL: 3}}\n"
    "programs:\n"
    "  screen: {command: [python3, -c, 'print(\"$HOME; 100%\")'], priority: 20, restart: always}\n";

CommandEnd ExportUnits(const RobotFolder& robot, const std::vector<std::string>& more = {}) {
  return Export("systemd", robot, {"--folder", robot.path("units")}, more);
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
  const CommandEnd end = ExportUnits(robot);
  EXPECT_EQ(end.status, 0) << end.err;
  EXPECT_THAT(
      robot.Read("units/robot-front.service"),
      AllOf(HasSubstr("\nType=notify\n"), HasSubstr("\nWatchdogSec=10s\n"), HasSubstr("\nMemoryMax=200000000\n"),
            HasSubstr("\nCPUAffinity=0 1\n"), HasSubstr("\nNice=5\n"), HasSubstr("\nRestart=on-failure\n"),
            HasSubstr("\nEnvironment=LEVEL=3\n"), HasSubstr("\nPartOf=robot.target\n"),
            HasSubstr(" run " + robot.file() + " --process=front\n"), Not(HasSubstr("OnFailure"))));
  EXPECT_THAT(robot.Read("units/robot-main.service"),
              AllOf(HasSubstr("\nOnFailure=robot-end.target\n"), HasSubstr("\nRestartPreventExitStatus=10 11\n"),
                    HasSubstr("\nRestart=no\n"), Not(HasSubstr("MemoryMax"))));
  EXPECT_THAT(robot.Read("units/robot-screen.service"),
              AllOf(HasSubstr("/usr/bin/env -- python3 -c \"print(\\\"$$HOME; 100%%\\\")\"\n"),
                    HasSubstr("\nCPUSchedulingPriority=20\n"), HasSubstr("\nAfter=robot-front.service\n")));
  EXPECT_THAT(robot.Read("units/robot.target"),
              AllOf(HasSubstr("\nWants=robot-front.service\n"), HasSubstr("\nWants=robot-screen.service\n")));
  EXPECT_THAT(robot.Read("units/robot-end.target"), HasSubstr("\nConflicts=robot.target\n"));
}

TEST(HgrosExportSystemd, UnitsPassSystemdAnalyze) {
  for (const bool of_user : {true, false}) {
    const RobotFolder robot(kAll);
    ASSERT_EQ(
        ExportUnits(robot, of_user ? std::vector<std::string>{} : std::vector<std::string>{"--user", "root"}).status,
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
  ASSERT_EQ(ExportUnits(robot, {"--name", "my robot", "--set", "front-left.params.count=3"}).status, 0);
  EXPECT_THAT(robot.Read("units/my\\x20robot-front\\x2dleft.service"),
              HasSubstr(" --process=front-left --set=front-left.params.count=3\n"));
  const std::string said = Verify(robot, "--user");
  if (said.starts_with("no ")) GTEST_SKIP() << "systemd-analyze is not installed.";
  EXPECT_EQ(said, "rc 0\n");
}

TEST(HgrosExportSystemd, UnitsOfTheSystemRunAsTheUser) {
  const RobotFolder robot(kAll);
  ASSERT_EQ(
      ExportUnits(robot, {"--user", "robot", "--path", "/etc/robot/robot.yaml", "--hgros", "/opt/bin/hgros"}).status,
      0);
  EXPECT_THAT(robot.Read("units/robot-front.service"),
              AllOf(HasSubstr("\nUser=robot\n"), HasSubstr("\nEnvironment=XDG_RUNTIME_DIR=/run/hgros-robot\n"),
                    HasSubstr("\nExecStart=/opt/bin/hgros run /etc/robot/robot.yaml --process=front\n"),
                    HasSubstr("\nWorkingDirectory=/etc/robot\n")));
  EXPECT_THAT(ExportUnits(robot, {"--user", "a b", "--force"}),
              Ends(2, HasSubstr("\"a b\" cannot be the name of a user.")));
}

TEST(HgrosExportSystemd, VariablesOfTheFileBecomePartOfTheUnits) {
  const RobotFolder robot(
      "components: {a: {type: relay/Does, params: {what: \"${FOLDER}\"}}}\nprograms: {p: {command: [ls], env: {FOLDER: "
      "mine}}}\n");
  ASSERT_EQ(ExportUnits(robot).status, 0);
  EXPECT_THAT(robot.Read("units/robot-main.service"),
              AllOf(HasSubstr("\nEnvironment=FOLDER=" + robot.environment().at("FOLDER") + "\n"),
                    HasSubstr("\nEnvironment=HGROS_DOMAIN=")));
  EXPECT_THAT(robot.Read("units/robot-p.service"), HasSubstr("\nEnvironment=FOLDER=mine\n"));
}

TEST(HgrosExportSystemd, OneHostHasItsPart) {
  const RobotFolder robot(
      "hosts: {cart: {address: 10.0.0.1, home: true}, base: {address: 10.0.0.2}}\n"
      "components: {a: {type: relay/Does}, b: {type: relay/Does}}\nprocesses: {p: {components: [a], host: base}}\n");
  EXPECT_THAT(ExportUnits(robot), Ends(1, HasSubstr("runs on the host \"base\"")));
  ASSERT_EQ(ExportUnits(robot, {"--host", "base"}).status, 0);
  EXPECT_THAT(robot.Read("units/robot-p.service"), HasSubstr(" --process=p --host=base\n"));
  EXPECT_FALSE(std::filesystem::exists(robot.path("units/robot-main.service")));
}

TEST(HgrosExportSystemd, ReplacesNoOtherFile) {
  const RobotFolder robot(kAll);
  ASSERT_EQ(ExportUnits(robot).status, 0);
  ASSERT_EQ(ExportUnits(robot).status, 0) << "They are the same.";
  std::ofstream(robot.path("units/robot-main.service"), std::ios::app) << "# Mine\n";
  std::filesystem::remove(robot.path("units/robot.target"));
  EXPECT_THAT(ExportUnits(robot), Ends(1, HasSubstr("robot-main.service is there already, with another text.")));
  EXPECT_FALSE(std::filesystem::exists(robot.path("units/robot.target"))) << "All or none.";
  EXPECT_EQ(ExportUnits(robot, {"--force"}).status, 0);
  EXPECT_THAT(robot.Read("units/robot-main.service"), AllOf(HasSubstr("[Unit]"), Not(HasSubstr("# Mine"))));
}

TEST(HgrosExportSystemd, SaysWhatNoUnitCanHave) {
  const RobotFolder variable("components: {a: {type: relay/Does}}\nprograms: {p: {command: [ls], env: {a-b: 1}}}\n");
  EXPECT_THAT(ExportUnits(variable).err, HasSubstr("systemd accepts no variable \"a-b\"."));
  const RobotFolder program("components: {a: {type: relay/Does}}\nprograms: {p: {command: [a=b]}}\n");
  EXPECT_THAT(ExportUnits(program).err, HasSubstr("its name has a \"=\""));
}

}  // namespace
}  // namespace hgros::cli
