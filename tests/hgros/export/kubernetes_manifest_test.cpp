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

constexpr const char* kPod =
    "components: {numbers: {type: relay/Numbers}, checker: {type: relay/Checker}}\n"
    "processes:\n"
    "  Front_1: {components: [numbers], restart: on-failure, memory: 200MB, cpus: [0, 1], nice: -5, env: {LEVEL: 3}}\n"
    "programs:\n"
    "  screen: {command: [python3, -c, 'print(\"$(HOME); 100%\")'], nice: 3}\n";

CommandEnd ExportPod(const RobotFolder& robot, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"export",  "kubernetes", robot.file(),       "--image",
                                 "robot:1", "--path",     "/robot/robot.yaml"};
  words.insert(words.end(), more.begin(), more.end());
  return RunToEnd(words, robot.environment());
}

// What kubectl understands, with a variable that it adds: it refuses wrong types and leaves out unknown keys.
// "no kubectl" if it is not installed.
std::string ReadByKubectl(const RobotFolder& robot, const std::string& text) {
  std::ofstream(robot.path("pod.yaml")) << text;
  return RunInShell(
             "command -v kubectl > /dev/null || { echo no kubectl; exit; }\n"
             "kubectl set env --local -f " +
                 robot.path("pod.yaml").string() + " ADDED=1 -o yaml 2>&1; echo rc $?",
             robot.environment())
      .out;
}

TEST(HgrosExportKubernetes, ContainersHaveWhatTheRobotFileSays) {
  const RobotFolder robot(kPod);
  const CommandEnd end = ExportPod(robot);
  EXPECT_EQ(end.status, 0) << end.err;
  EXPECT_THAT(
      end.out,
      AllOf(HasSubstr("kind: Job\n"), HasSubstr("restartPolicy: OnFailure\n"),
            HasSubstr("command: [\"taskset\", \"--cpu-list\", \"0,1\", \"nice\", \"-n\", \"-5\", \"hgros\", "
                      "\"run\", \"/robot/robot.yaml\", \"--process=Front_1\"]\n"),
            HasSubstr("- name: \"front-1\"\n"), HasSubstr("limits: {memory: \"200000000\"}"),
            HasSubstr("{name: \"LEVEL\", value: \"3\"}"), HasSubstr("add: [SYS_NICE]"), HasSubstr("$$(HOME); 100%")));
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

}  // namespace
}  // namespace hgros::cli
