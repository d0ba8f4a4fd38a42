// hgros run: what the robot file says of processes, libraries that cannot be used, and a graph with a cycle.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "support/await.hpp"
#include "support/path.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(HgrosRunProcesses, HaveTheirCpusNicenessAndPriority) {
  const RobotFolder robot(
      "components: {a: {type: relay/Does}, b: {type: relay/Does}}\n"
      "processes:\n"
      "  p: {components: [a], cpus: [0], nice: 5}\n"
      "  q: {components: [b]}\n"
      "programs: {says: {command: [sh, -c, echo I run.; exec sleep 100d], cpus: [0], nice: 7}}\n");
  CommandRun run(robot.Arguments(), robot.environment());
  // A table comes before. Then each of them is set up, in any order.
  for (const char* line : {"a     I run.", "b     I run.", "says  I run."}) ASSERT_TRUE(run.Prints(line)) << run.out();
  const std::vector<pid_t> pids = PidsIn(run.out());  // In the order of the file.
  ASSERT_EQ(pids.size(), 3U) << run.out();
  const std::vector<int> nice{5, getpriority(PRIO_PROCESS, 0), 7};
  for (std::size_t i = 0; i < pids.size(); ++i) {
    EXPECT_EQ(getpriority(PRIO_PROCESS, static_cast<id_t>(pids[i])), nice[i]) << run.out();
    cpu_set_t cpus;
    ASSERT_EQ(sched_getaffinity(pids[i], sizeof cpus, &cpus), 0);
    EXPECT_TRUE(CPU_ISSET(0, &cpus));
    cpu_set_t all;
    ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
    EXPECT_EQ(CPU_COUNT(&cpus), i == 1 ? CPU_COUNT(&all) : 1);
  }
  run.Signal(SIGINT);
  EXPECT_EQ(run.Wait(), 128 + SIGINT);
}

TEST(HgrosRunProcesses, HaveARealTimePriority) {
  const sched_param least{1};
  if (sched_setscheduler(0, SCHED_FIFO, &least) != 0) GTEST_SKIP() << "no real-time priorities here";
  const sched_param none{0};
  ASSERT_EQ(sched_setscheduler(0, SCHED_OTHER, &none), 0);
  const RobotFolder robot(
      "components: {a: {type: relay/Does}}\n"
      "processes: {p: {components: [a], priority: 3}}\n");
  CommandRun run(robot.Arguments(), robot.environment());
  ASSERT_TRUE(run.Prints("I run."));
  const std::vector<pid_t> pids = PidsIn(run.out());
  ASSERT_EQ(pids.size(), 1U) << run.out();
  EXPECT_EQ(sched_getscheduler(pids[0]) & ~SCHED_RESET_ON_FORK, SCHED_FIFO);
  sched_param priority{};
  ASSERT_EQ(sched_getparam(pids[0], &priority), 0);
  EXPECT_EQ(priority.sched_priority, 3);
  run.Signal(SIGINT);
  EXPECT_EQ(run.Wait(), 128 + SIGINT);
}

// Manifests in a folder of their own, for the bad libraries.
class BadLibraries : public testing::Test {
 protected:
  BadLibraries() : manifests_(testing::TempDir() + "hgros_bad_" + std::to_string(getpid())) {
    std::filesystem::create_directories(manifests_);
  }
  ~BadLibraries() override { std::filesystem::remove_all(manifests_); }
  BadLibraries(const BadLibraries&) = delete;
  BadLibraries& operator=(const BadLibraries&) = delete;
  void Name(const std::string& library, const std::string& type) const {
    std::ofstream(manifests_ / "bad.yaml") << "library: " << library << "\ncomponents: [" << type << "]\n";
  }
  [[nodiscard]] CommandEnd Run(const std::string& type) const {
    return RobotFolder("components: {a: {type: " + type + "}}\n", manifests_.string()).Run();
  }

  const std::filesystem::path manifests_;
};

TEST_F(BadLibraries, NothingRunsWithoutTheLibrary) {
  Name("/nowhere/libmissing.so", "bad/Missing");
  const CommandEnd end = Run("bad/Missing");
  EXPECT_EQ(end.status, 1);
  EXPECT_EQ(end.out, "");
  EXPECT_THAT(end.err, AllOf(HasSubstr("robot.yaml:1:"), HasSubstr("/nowhere/libmissing.so")));
}

TEST_F(BadLibraries, ConstructorsThatEndTheProcessAreNamedBeforeAnythingRuns) {
  const std::map<std::string, std::string> reasons{
      {"bad/Exits", "it ended with exit code 3"}, {"bad/Crashes", "SIGSEGV"}, {"bad/Throws", "there is no"}};
  for (const auto& [type, reason] : reasons) {
    Name(test::Path("bad_library"), type);
    const CommandEnd end = Run(type);
    EXPECT_EQ(end.status, 1) << type;
    EXPECT_EQ(end.out, "") << type;
    EXPECT_THAT(end.err, AllOf(HasSubstr("robot.yaml:1:"), HasSubstr("Component \"a\""), HasSubstr(reason))) << type;
  }
}

// The channels of this robot are a circle. One message goes round and round.
TEST(HgrosRunProcesses, AGraphWithACycleRunsAndEnds) {
  const RobotFolder robot(
      "components:\n"
      "  there: {type: moving/Passing, remap: {number: ping, passed: pong}}\n"
      "  back: {type: moving/Passing, remap: {number: pong, passed: ping, count: rounds}}\n"
      "processes: {p: {components: [there]}, q: {components: [back]}}\n");
  CommandRun run(robot.Arguments(), robot.environment());
  const auto ask = [&] { return RunToEnd({"call", "rounds", "{}"}, robot.environment()); };
  ASSERT_TRUE(test::Await([&] { return ask().status == 0; })) << run.out() << run.err();
  EXPECT_EQ(RunToEnd(Patiently({"pub", "ping", "{value: \"1\"}"}), robot.environment()).status, 0);
  const auto rounds = [&] {
    const std::string text = ask().out;
    const std::size_t number = text.find_first_of("0123456789");
    return number == std::string::npos ? 0 : std::stoi(text.substr(number));
  };
  EXPECT_TRUE(test::Await([&] { return rounds() > 100; })) << run.out() << run.err();
  run.Signal(SIGINT);
  EXPECT_EQ(run.Wait(), 128 + SIGINT) << run.out() << run.err();
}

}  // namespace
}  // namespace hgros::cli
