// hgros run: what the robot file says of processes, libraries that cannot be used, and a graph with a cycle.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>

#include <string>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "support/await.hpp"
#include "support/path.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(HgrosRunProcesses, HaveTheirCpusNicenessAndPriority) {
  RunningRobot robot(
      "components: {a: {type: relay/Does}, b: {type: relay/Does}}\n"
      "processes:\n"
      "  p: {components: [a], cpus: [0], nice: 5}\n"
      "  q: {components: [b]}\n"
      "programs: {says: {command: [sh, -c, echo I run.; exec sleep 100d], cpus: [0], nice: 7}}\n");
  // A table comes before. Then each of them is set up, in any order.
  for (const char* line : {"a     I run.", "b     I run.", "says  I run."})
    ASSERT_TRUE(robot.Prints(line)) << robot.out();
  const std::vector<pid_t> pids = PidsIn(robot.out());  // In the order of the file.
  ASSERT_EQ(pids.size(), 3U) << robot.out();
  const std::vector<int> nice{5, getpriority(PRIO_PROCESS, 0), 7};
  for (std::size_t i = 0; i < pids.size(); ++i) {
    EXPECT_EQ(getpriority(PRIO_PROCESS, static_cast<id_t>(pids[i])), nice[i]) << robot.out();
    cpu_set_t cpus;
    ASSERT_EQ(sched_getaffinity(pids[i], sizeof cpus, &cpus), 0);
    EXPECT_TRUE(CPU_ISSET(0, &cpus));
    cpu_set_t all;
    ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
    EXPECT_EQ(CPU_COUNT(&cpus), i == 1 ? CPU_COUNT(&all) : 1);
  }
}

TEST(HgrosRunProcesses, HaveARealTimePriority) {
  const sched_param least{1};
  if (sched_setscheduler(0, SCHED_FIFO, &least) != 0) GTEST_SKIP() << "no real-time priorities here";
  const sched_param none{0};
  ASSERT_EQ(sched_setscheduler(0, SCHED_OTHER, &none), 0);
  RunningRobot robot(
      "components: {a: {type: relay/Does}}\n"
      "processes: {p: {components: [a], priority: 3}}\n");
  ASSERT_TRUE(robot.Prints("I run."));
  const std::vector<pid_t> pids = PidsIn(robot.out());
  ASSERT_EQ(pids.size(), 1U) << robot.out();
  EXPECT_EQ(sched_getscheduler(pids[0]) & ~SCHED_RESET_ON_FORK, SCHED_FIFO);
  sched_param priority{};
  ASSERT_EQ(sched_getparam(pids[0], &priority), 0);
  EXPECT_EQ(priority.sched_priority, 3);
}

TEST(HgrosRunProcesses, ThatEndInAConstructorAndMissingLibrariesAreNamedBeforeAnythingRuns) {
  struct Bad {
    std::string type;
    std::string library;
    std::string reason;
  };
  const std::string bad = test::Path("bad_library");
  for (const Bad& one : {Bad{"bad/Missing", "/nowhere/libmissing.so", "/nowhere/libmissing.so"},
                         Bad{"bad/Exits", bad, "it ended with exit code 3"}, Bad{"bad/Crashes", bad, "SIGSEGV"},
                         Bad{"bad/Throws", bad, "there is no"}}) {
    const test::ScratchFolder manifests;
    manifests.Write("bad.yaml", "library: " + one.library + "\ncomponents: [" + one.type + "]\n");
    EXPECT_THAT(RobotFolder("components: {a: {type: " + one.type + "}}\n", manifests.path()).Run(),
                AllOf(Ends(1, AllOf(HasSubstr("robot.yaml:1:"), HasSubstr("Component \"a\""), HasSubstr(one.reason))),
                      Prints("")))
        << one.type;
  }
}

// The channels of this robot are a circle. One message goes round and round.
TEST(HgrosRunProcesses, AGraphWithACycleRunsAndEnds) {
  RunningRobot robot(
      "components:\n"
      "  there: {type: moving/Passing, remap: {number: ping, passed: pong}}\n"
      "  back: {type: moving/Passing, remap: {number: pong, passed: ping, count: rounds}}\n"
      "processes: {p: {components: [there]}, q: {components: [back]}}\n");
  const auto ask = [&] { return robot.Ask({"call", "rounds", "{}"}); };
  ASSERT_TRUE(test::Await([&] { return ask().status == 0; })) << robot.out() << robot.err();
  EXPECT_EQ(robot.Ask(Patiently({"pub", "ping", "{value: \"1\"}"})).status, 0);
  const auto rounds = [&] {
    const std::string text = ask().out;
    const std::size_t number = text.find_first_of("0123456789");
    return number == std::string::npos ? 0 : std::stoi(text.substr(number));
  };
  EXPECT_TRUE(test::Await([&] { return rounds() > 100; })) << robot.out() << robot.err();
}

}  // namespace
}  // namespace hgros::cli
