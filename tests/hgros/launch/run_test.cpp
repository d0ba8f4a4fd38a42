#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "support/await.hpp"
#include "support/cable.hpp"
#include "support/path.hpp"
#include "support/seed.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kThree = R"(
components:
  numbers: {type: relay/Numbers}
  one: {type: relay/Checker}
  two: {type: relay/Checker}
)";

TEST(HgrosRun, NoticesTheEndOfItsProcessesAlthoughItsParentIgnoresTheirSignal) {
  const RobotFolder folder("components: {bad: {type: relay/Does, params: {what: exit}}}\n");
  auto environment = folder.environment();
  environment["ROBOT"] = folder.file();
  EXPECT_THAT(
      RunInShell(R"(exec bash -c 'trap "" CHLD; exec "$HGROS" run "$ROBOT"')", environment),  // Not every sh can.
      Prints(1, HasSubstr("it ended with exit code 7.")));
}

TEST(HgrosRun, OnlyYamlDiffersBetweenOneProcessAndThreeThatRunUntilAllHaveFinished) {
  const auto run = [](const RobotFolder& robot, const std::string& of_numbers, const std::string& of_one) {
    const CommandEnd end = robot.Run();
    EXPECT_THAT(
        end,
        Prints(0, AllOf(HasSubstr("COMPONENT  TYPE           PROCESS"),
                        HasSubstr("numbers    relay/Numbers  " + of_numbers),
                        HasSubstr("one        relay/Checker  " + of_one), HasSubstr("two        relay/Checker  main"),
                        HasSubstr("It has finished: 100 numbers"), HasSubstr("one      It has finished: all 100"),
                        HasSubstr("two      It has finished: all 100"))));
    return end.err;
  };
  EXPECT_EQ(run(RobotFolder(kThree), "main", "main"), "");
  const RobotFolder three(std::string(kThree) + "processes: {a: {components: [numbers]}, b: {components: [one]}}\n");
  for (int round = 0; round < test::Rounds(1, 5); ++round) (void)run(three, "a", "b");
}

TEST(HgrosRun, CutsLinesOfTheLogThatAreVeryLongAndEndsInOrderIfASignalComesTwice) {
  RunningRobot robot("components: {a: {type: relay/Does, params: {what: log much}}}\n");
  EXPECT_TRUE(robot.Prints(" ... and 73334784 bytes more."));
  robot.Signal(SIGTERM);
  robot.End(SIGTERM);  // A signal that comes twice within a moment ends in order.
  EXPECT_THAT(robot.out(), HasSubstr("I end."));
}

constexpr const char* kCartAndBase =
    "hosts: {cart: {address: 10.198.0.1, home: true}, base: {address: 10.198.0.2}}\n"
    "discovery: {local: false}\n";  // The file system is shared.

// Starts the part of `host` in a network namespace.
std::unique_ptr<CommandRun> StartOn(const RobotFolder& robot, const std::string& host, const std::string& space) {
  return std::make_unique<CommandRun>(std::vector<std::string>{"netns", "exec", space, test::Path("hgros"), "run",
                                                               robot.file(), "--host", host, "--name", host},
                                      robot.environment(), -1, "/sbin/ip");
}

TEST(HgrosRun, HostsStartTheirPartsInAnyOrder) {
  const test::Cable cable;
  if (!cable.ready || !cable.Set("up")) GTEST_SKIP() << "Network namespaces need root.";
  for (const bool home_first : {true, false}) {
    const RobotFolder robot(std::string(kCartAndBase) +
                            "components: {numbers: {type: relay/Numbers}, one: {type: relay/Checker}}\n"
                            "processes: {p: {components: [numbers], host: base}}\n");
    const auto base_before = home_first ? nullptr : StartOn(robot, "base", cable.right);
    const auto cart = StartOn(robot, "cart", cable.left);
    const auto base_after = home_first ? StartOn(robot, "base", cable.right) : nullptr;
    CommandRun& base = home_first ? *base_after : *base_before;
    EXPECT_TRUE(cart->Prints("It has finished: all 100")) << cart->out() << cart->err() << base.out() << base.err();
    EXPECT_EQ(cart->Wait(), 0) << cart->out() << cart->err();
    EXPECT_EQ(base.Wait(), 0) << base.out() << base.err();
  }
}

TEST(HgrosRun, TransformsPassBetweenHosts) {
  const test::Cable cable;
  if (!cable.ready || !cable.Set("up")) GTEST_SKIP() << "Network namespaces need root.";
  const RobotFolder robot(
      std::string(kCartAndBase) +
      "components:\n"
      "  one: {type: relay/Frames, params: {sets: a, sees: b}}\n"
      "  two: {type: relay/Frames, params: {sets: b, sees: a}}\n"
      "  late: {type: relay/Frames, params: {sets: c, sees: a, declares: false}}\n"
      "processes: {p: {components: [two], host: base, restart: on-failure}, q: {components: [late]}}\n");
  const auto cart = StartOn(robot, "cart", cable.left);
  const auto base = StartOn(robot, "base", cable.right);
  EXPECT_TRUE(cart->Prints(" It sees b.")) << cart->out() << base->out();
  EXPECT_TRUE(base->Prints(" It sees a.")) << cart->out() << base->out();
  EXPECT_TRUE(
      cart->Prints("late  warning: It uses transforms, but its constructor did not ask for them, so "
                   "they do not pass between the hosts of the robot."))
      << cart->out();
  // A process that is killed and started again does not share its static edges with the dead one.
  ASSERT_EQ(kill(PidsIn(base->out()).at(0), SIGKILL), 0);
  EXPECT_TRUE(test::Await([&] { return Times(base->out(), " It sees a.") == 2; })) << base->out();
  test::Linger(std::chrono::seconds(3));  // The other host takes 5 s to know that it has died.
  for (const auto& run : {std::ref(*cart), std::ref(*base)}) {
    run.get().Signal(SIGINT);
    (void)run.get().Wait();
  }
  const std::string out = cart->out() + base->out();
  EXPECT_EQ(Times(out, "It uses transforms, but"), 1U) << out;
  EXPECT_EQ(Times(out, "Two sessions set"), 0U) << out;
}

TEST(HgrosRun, HostsWithKeysExchangeMessages) {
  const test::Cable cable;
  if (!cable.ready || !cable.Set("up")) GTEST_SKIP() << "Network namespaces need root.";
  const RobotWithKeys robot;
  robot.WriteKey("base");
  const auto refused = StartOn(robot, "desk", cable.left);
  EXPECT_NE(refused->Wait(), 0);
  EXPECT_THAT(refused->err(), HasSubstr("desk.key\", which cannot be read"));
  robot.WriteKey("desk");
  const auto base = StartOn(robot, "base", cable.right);
  const auto desk = StartOn(robot, "desk", cable.left);
  EXPECT_EQ(desk->Wait(), 0) << desk->out() << desk->err();
  EXPECT_EQ(base->Wait(), 0) << base->out() << base->err();
  EXPECT_THAT(desk->out(), HasSubstr("It has finished: all 100"));
}

// The configuration of its session comes from the starter; the file system is shared, so that nothing else may join
// them.
TEST(HgrosRun, ProgramsExchangeWhatTheySayWithOtherHosts) {
  const test::Cable cable;
  if (!cable.ready || !cable.Set("up")) GTEST_SKIP() << "Network namespaces need root.";
  const std::string hgros = test::Path("hgros");
  const RobotFolder robot(std::string(kCartAndBase) +
                          "components: {counting: {type: moving/Counting}, counter: {type: relay/Counter}}\n"
                          "processes: {p: {components: [counting, counter]}}\n"
                          "programs:\n"
                          "  hears: {host: base, subscribes: [number], command: [" +
                          hgros +
                          ", echo, number, -n, 3, --field, value]}\n"
                          "  says: {host: base, publishes: [word], command: [" +
                          hgros +
                          ", pub, word, '{value: one}', --type, foxglove.KeyValuePair, --timeout, 15]}\n"
                          "  deaf: {host: base, command: [" +
                          hgros + ", echo, number, --once, --timeout, 3]}\n");
  const auto cart = StartOn(robot, "cart", cable.left);
  const auto base = StartOn(robot, "base", cable.right);
  EXPECT_EQ(base->Wait(), 1) << "What says nothing gets nothing: " << base->out() << base->err();
  const auto exits = [&](const std::string& program) {
    return testing::ContainsRegex(program + " +error: The process has failed: it ended with exit code");
  };
  EXPECT_THAT(base->out(), AllOf(ContainsRegex("hears +\"[0-9]+\"\n.*hears +\"[0-9]+\"\n.*hears +\"[0-9]+\"\n"),
                                 Not(exits("hears")), Not(exits("says")), exits("deaf")));
  EXPECT_TRUE(cart->Prints("counts 1.")) << cart->out() << base->out();
  cart->End();
}

TEST(HgrosRun, CheckShowsWhatIsDerivedForHosts) {
  const RobotFolder robot(
      "hosts: {cart: {address: 10.198.0.1, home: true}, base: {address: 10.198.0.2}}\n"
      "components: {numbers: {type: relay/Numbers}, one: {type: relay/Checker}}\n"
      "processes: {p: {components: [numbers], host: base, network: {publisher: {ip: '*:6000'}}}}\n");
  EXPECT_THAT(robot.Ask({"check", "--verbose", robot.file()}),
              Prints(0, AllOf(HasSubstr("3:13: note: \"p\" publishes for other hosts at tcp://*:5650: number."),
                              HasSubstr("\"main\" hears another host at tcp://10.198.0.2:5650: number."))));
}

TEST(HgrosRun, SetsValuesAndLeavesOut) {
  const RobotFolder robot(kThree);
  EXPECT_THAT(robot.Run({"--set", "numbers.params.count=7", "--set", "one.params.count=7", "--except", "two"}),
              Prints(0, AllOf(HasSubstr("all 7"), Not(HasSubstr("two")))));
  EXPECT_THAT(robot.Run({"--only", "numbers"}).out, AllOf(HasSubstr("100 numbers"), Not(HasSubstr("one"))));
  EXPECT_EQ(robot.Run({"--only", "numbrs"}).status, 2);
}

// robot_errors.txt has the sentences.
TEST(HgrosRun, TellsEveryFaultBeforeAnythingRuns) {
  const RobotFolder robot(
      "components:\n"
      "  a: {type: relay/Number}\n"
      "  b: {type: relay/Does, params: {what: throw at start}}\n"
      "  c: {type: relay/Numbers}\n"
      "  d: {type: relay/Pose}\n");
  EXPECT_THAT(robot.Run(), AllOf(Prints(""), Ends(1, AllOf(HasSubstr("robot.yaml:2:3: Component \"a\": There is no"),
                                                           HasSubstr("there is no laser at /dev/ttyUSB0"),
                                                           HasSubstr("foxglove.PoseInFrame")))));
}

TEST(HgrosRun, WarnsOfChannelsAndServicesWithOneEnd) {
  RunningRobot robot("components: {a: {type: relay/Pose}}\n");
  EXPECT_TRUE(robot.Prints("relay/Pose"));
  for (const char* part : {"warning: ", "No component publishes the channel \"number\"",
                           "No component serves \"plan\", which \"a\" calls."}) {
    EXPECT_TRUE(test::Await([&] { return robot.err().find(part) != std::string::npos; })) << part << robot.err();
  }
}

TEST(HgrosRun, FaultsOfTheFileAreAllTold) {
  const RobotFolder robot("components:\n  a: {type: x, esential: true}\nprocesses: {p: {nice: 99}}\n");
  EXPECT_THAT(robot.Run(),
              Ends(2, AllOf(HasSubstr("robot.yaml:2:16: Unknown key \"esential\""), HasSubstr("robot.yaml:3:23: "))));
}

TEST(HgrosRun, ShowsLogsWithTheComponentsName) {
  RunningRobot robot(
      "components:\n"
      "  a: {type: relay/Does, params: {what: log}}\n"
      "  b: {type: relay/Does, params: {what: throw}}\n"
      "  c: {type: relay/Does, params: {what: print}}\n"
      "programs: {says: {command: [sh, -c, 'echo ${GREETING:-hello}; printf \"back\\rand\\r\\n\"; printf last']}}\n");
  EXPECT_TRUE(robot.Prints("says  last"));
  EXPECT_TRUE(robot.Prints("in two lines"));
  EXPECT_TRUE(robot.Prints("it is too dark"));
  EXPECT_TRUE(robot.Prints("a     warning: It is\\n\\x1b[31mdark."));
  EXPECT_THAT(robot.out(),
              AllOf(ContainsRegex("[0-9][0-9]:[0-9][0-9]:[0-9][0-9]\\.[0-9]{3} a     I run\\."),
                    HasSubstr("main  printed, and\n"), HasSubstr("says  hello"), HasSubstr("says  back\\rand\n")));
}

TEST(HgrosRun, EndsInReverseOrder) {
  RunningRobot robot(
      "components: {a: {type: relay/Does}, b: {type: relay/Does}, c: {type: relay/Does}}\n"
      "processes: {p: {components: [c]}, q: {components: [a]}, r: {components: [b]}}\n"
      "programs: {waits: {command: [sh, -c, 'trap \"echo goodbye; exit\" TERM; echo ready; while :; do sleep 0.05; "
      "done']}}\n");
  ASSERT_TRUE(robot.Prints("b      I run."));
  ASSERT_TRUE(robot.Prints("waits  ready"));
  const std::vector<pid_t> pids = PidsIn(robot.out());
  ASSERT_EQ(pids.size(), 4U) << robot.out();
  robot.End();
  const std::string out = robot.out();
  EXPECT_LT(out.find("goodbye"), out.find("b      I end."));
  EXPECT_LT(out.find("b      I end."), out.find("a      I end."));
  EXPECT_LT(out.find("a      I end."), out.find("c      I end."));
  EXPECT_NE(out.find("c      I end."), std::string::npos);
  for (const pid_t pid : pids) EXPECT_FALSE(Runs(pid));
}

TEST(HgrosRun, KillsWhatDoesNotEndAndLetsOthersEndMeanwhile) {
  RunningRobot robot(
      "components: {a: {type: relay/Does}, b: {type: relay/Does}, c: {type: relay/Does, params: {what: hang at end}}}\n"
      "processes: {p: {components: [a]}, q: {components: [b]}}\n"
      "programs: {told: {command: [sh, -c, 'trap \"echo goodbye; exit\" TERM; echo ready; while :; do sleep 0.05; "
      "done']},\n"
      "  deaf: {command: [sh, -c, 'trap \"\" TERM; echo ready; sleep 60 & wait; sleep 60']}}\n");
  for (const char* line : {"c     I run.", "told  ready", "deaf  ready"}) ASSERT_TRUE(robot.Prints(line));
  robot.End(SIGTERM);
  const std::string killed = " warning: It did not end in time, and is killed.";
  for (const std::string& last : {std::string("goodbye"), std::string("a     I end."), std::string("b     I end."),
                                  "main " + killed, "deaf " + killed}) {
    EXPECT_THAT(robot.out(), HasSubstr(last));
  }
  for (const pid_t pid : PidsIn(robot.out())) EXPECT_FALSE(Runs(pid));
  EXPECT_THAT(robot.FilesLeft(), testing::IsEmpty());
}

TEST(HgrosRun, DeactivatesComponentsThatWaitForOneOfTheirProcess) {
  const auto text = [](const std::string& what) {
    return "components:\n  a: {type: relay/Does}\n  b: {type: relay/Does, params: {what: " + what +
           "}}\n  c: {type: relay/Does, params: {what: " + what + "}}\nprocesses: {p: {components: [a, b, c]}}\n";
  };
  RunningRobot hangs(text("hang"));
  RunningRobot at_start(text("hang at start"));
  RunningRobot at_end(text("hang at end"));
  ASSERT_TRUE(hangs.Prints("I hang.")) << hangs.out();
  ASSERT_TRUE(at_start.Prints("I hang.")) << at_start.out();
  ASSERT_TRUE(at_end.Prints("c  I run.")) << at_end.out();
  for (const RunningRobot* robot : {&hangs, &at_start, &at_end}) robot->Signal(SIGINT);
  for (RunningRobot* robot : {&hangs, &at_start, &at_end}) {
    EXPECT_EQ(robot->Wait(), 128 + SIGINT);
    EXPECT_THAT(robot->out(), AllOf(HasSubstr("a  I end."), HasSubstr("It holds up the end of its process."),
                                    HasSubstr("did not end in time, and is killed.")));
  }
}

TEST(HgrosRun, TellsOfACrashAtItsEnd) {
  RunningRobot robot("components: {a: {type: relay/Does, params: {what: crash at end}}}\n");
  ASSERT_TRUE(robot.Prints("I run."));
  robot.Signal(SIGINT);
  (void)robot.Wait();
  EXPECT_THAT(robot.out(), HasSubstr("The process has failed: it was ended by"));
}

TEST(HgrosRun, TellsWhatDoesNotBeginToRun) {
  const RobotFolder robot(
      "components: {a: {type: relay/Does}, b: {type: relay/Does, params: {what: hang at start}},\n"
      "  c: {type: relay/Does}}\n"
      "processes: {p: {components: [b]}, q: {components: [c], env: {RELAY_DOOR: \"${FOLDER}/door\"}}}\n");
  ASSERT_EQ(mkfifo(robot.path("door").c_str(), 0600), 0);
  CommandRun run(robot.Arguments(), robot.environment());
  EXPECT_TRUE(run.Prints("q     warning: It still constructs its components. The robot waits for it.")) << run.out();
  std::ofstream(robot.path("door")).close();
  EXPECT_TRUE(run.Prints("p     warning: An Activate() of its components has not returned.")) << run.out();
  run.End();
  EXPECT_EQ(run.out().find("subscribers"), std::string::npos) << "p waited for q.";
}

TEST(HgrosRun, ASecondSignalLeavesNothing) {
  RunningRobot robot(
      "components: {a: {type: relay/Does, params: {what: hang at end}}}\n"
      "programs: {deaf: {command: [sh, -c, 'trap \"\" TERM; sleep 100 & trap \"echo heard\" TERM; echo left $!; "
      "while :; do wait; done']}}\n");
  std::smatch left;
  std::string out;
  ASSERT_TRUE(test::Await([&] {
    out = robot.out();
    return std::regex_search(out, left, std::regex("left ([0-9]+)\n"));
  }));
  robot.Signal(SIGINT);
  ASSERT_TRUE(robot.Prints("heard"));            // It has come; two that wait are one.
  test::Linger(std::chrono::milliseconds(200));  // One right after it would be taken for the same.
  robot.End();
  EXPECT_THAT(robot.out(), Not(HasSubstr("did not end in time"))) << "The first alone would have killed it later.";
  std::vector<pid_t> pids = PidsIn(out);
  pids.push_back(std::stoi(left[1]));
  for (const pid_t pid : pids) EXPECT_TRUE(test::Await([pid] { return !Runs(pid); })) << pid;
}

TEST(HgrosRun, NothingIsLeftWhenItIsKilled) {
  RunningRobot robot(
      "components: {a: {type: relay/Does}, b: {type: relay/Does}}\n"
      "processes: {p: {components: [a]}}\n"
      "programs: {sleeps: {command: [sleep, 100]}}\n");
  ASSERT_TRUE(robot.Prints("b       I run."));
  const std::vector<pid_t> pids = PidsIn(robot.out());
  ASSERT_EQ(pids.size(), 3U);
  robot.End(SIGKILL);
  for (const pid_t pid : pids) EXPECT_TRUE(test::Await([pid] { return !Runs(pid); }));
  EXPECT_EQ(robot.Run({"--only", "sleeps", "--set", "programs.sleeps.command=[\"true\"]"}).status, 0)
      << "Its name is free again.";
}

// One child stays in the process group; the other leaves it and its session, and only a control group holds it.
TEST(HgrosRun, NothingIsLeftOfWhatProgramsStart) {
  const RobotFolder robot(
      "components: {does: {type: relay/Does}}\n"
      "programs:\n"
      "  starts: {command: [sh, -c, 'sleep 100 & echo has $!; setsid sleep 100 & echo has $!; cat /proc/self/cgroup;"
      " echo up; wait']}\n");
  const auto expect_ended = [](const std::string& out, const std::string& why) {
    std::vector<pid_t> children;
    const std::regex row(R"(has (\d+)\n)");
    for (std::sregex_iterator at(out.begin(), out.end(), row), end; at != end; ++at) {
      children.push_back(std::stoi((*at)[1]));
    }
    ASSERT_EQ(children.size(), 2U) << out;
    if (out.find("/hgros-") == std::string::npos) {  // No control group may be made here.
      (void)kill(children.back(), SIGKILL);          // Nobody else does.
      children.pop_back();
    }
    for (const pid_t child : children) EXPECT_TRUE(test::Await([child] { return !Runs(child); })) << why;
  };
  for (const int number : {SIGINT, SIGKILL}) {
    CommandRun run(robot.Arguments(), robot.environment());
    ASSERT_TRUE(run.Prints("  up\n"));
    const std::string first = run.out();
    EXPECT_EQ(robot.Ask({"restart", "starts"}).status, 0);
    expect_ended(first, "A restart.");
    ASSERT_TRUE(test::Await([&] { return Times(run.out(), "  up\n") == 2; }));
    run.End(number);
    expect_ended(run.out().substr(first.size()), std::to_string(number));
  }
}

TEST(HgrosRun, ProcessesHaveNoDescriptorsOfOthers) {
  RunningRobot robot(
      "components: {a: {type: relay/Does}, b: {type: relay/Does}}\nprocesses: {p: {components: [a]}}\n"
      "programs: {lists: {command: [sh, -c, 'ls /proc/self/fd; sleep 100']}}\n");
  ASSERT_TRUE(robot.Prints("lists  3"));  // The folder that ls reads.
  EXPECT_THAT(robot.out(), Not(HasSubstr("lists  4")));
}

TEST(HgrosRun, SixtyComponentsRunInTwentyProcesses) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr int kProcesses = 6;
#else
  constexpr int kProcesses = 20;
#endif
  std::string text = "components:\n";
  for (int i = 0; i < kProcesses; ++i) {
    const std::string number = std::to_string(i);
    text += "  numbers" + number + ": {type: relay/Numbers, remap: {number: n" + number + "}}\n";
    text += "  one" + number + ": {type: relay/Checker, remap: {number: n" + number + "}}\n";
    text += "  does" + number + ": {type: relay/Does, params: {what: finish}}\n";
  }
  text += "processes:\n";
  for (int i = 0; i < kProcesses; ++i) {
    const std::string number = std::to_string(i);
    text += "  p" + number + ": {components: [numbers" + number + ", one" + std::to_string((i + 1) % kProcesses) +
            ", does" + number + "]}\n";
  }
  const CommandEnd end = RobotFolder(text).Run();
  EXPECT_EQ(end.status, 0) << end.out << end.err;
  for (int i = 0; i < kProcesses; ++i) {
    EXPECT_THAT(end.out, ContainsRegex("one" + std::to_string(i) + " +It has finished: all 100"));
  }
}

TEST(HgrosRun, ReportsFailuresWithTheLastLines) {
  const RobotFolder robot(
      "components: {a: {type: relay/Does, params: {what: crash}}, b: {type: relay/Does, params: {what: finish}},\n"
      "  c: {type: relay/Does, params: {what: exit well}}}\n"
      "processes: {p: {components: [a]}, q: {components: [c]}}\n");
  EXPECT_THAT(robot.Run(),
              Prints(1, AllOf(HasSubstr("p     error: The process has failed: it was ended by SIGABRT."),
                              HasSubstr("The last lines of \"p\":\n"), HasSubstr("b     It has finished: enough"),
                              HasSubstr("it ended with exit code 0, but its components had not ended."))));
  EXPECT_EQ(robot.Run({"--except", "p"}).status, 1) << "Code 0, but too early.";
}

TEST(HgrosRun, AnEssentialFailureEndsTheRobot) {
  const RobotFolder component(
      "components: {a: {type: relay/Does, params: {what: fail}, essential: true}, b: {type: relay/Does}}\n"
      "processes: {p: {components: [a]}}\n");
  EXPECT_THAT(
      component.Run(),
      AllOf(Prints(AllOf(HasSubstr("a     error: It has failed: the laser is broken"), HasSubstr("b     I end."))),
            Ends(1, HasSubstr("The robot ends, because \"a\" is essential."))));
  const RobotFolder finishes(
      "components: {a: {type: relay/Does, params: {what: finish}, essential: true}, b: {type: relay/Does}}\n");
  EXPECT_EQ(finishes.Run().status, 0);
  const RobotFolder program(
      "components: {b: {type: relay/Does}}\nprograms: {x: {command: [sh, -c, exit 3], essential: true}}\n");
  EXPECT_THAT(program.Run(), Prints(1, HasSubstr("it ended with exit code 3")));
}

TEST(HgrosRun, StartsAgainWhatHasFailed) {
  RunningRobot robot(
      "components: {a: {type: relay/Does}, b: {type: relay/Does}}\n"
      "processes: {p: {components: [a], restart: on-failure}}\n"
      "programs:\n"
      "  once: {command: [sh, -c, 'test -e ${FOLDER}/mark && exit 0; touch ${FOLDER}/mark; exit 3'], restart: "
      "on-failure}\n");
  ASSERT_TRUE(robot.Prints("b     I run."));
  ASSERT_TRUE(robot.Prints("once  warning: It is started again."));
  const std::vector<pid_t> pids = PidsIn(robot.out());
  ASSERT_EQ(pids.size(), 3U) << robot.out();
  ASSERT_EQ(kill(pids[0], SIGKILL), 0);
  ASSERT_TRUE(robot.Prints("p     warning: It is started again."));
  EXPECT_TRUE(robot.Prints("a     I run.", 2));
}

TEST(HgrosRun, GivesUpOnWhatAlwaysFails) {
  const RobotFolder robot(
      "components: {b: {type: relay/Does}}\n"
      "programs: {x: {command: [sh, -c, exit 3], restart: always, essential: true}}\n");
  EXPECT_THAT(robot.Run(), AllOf(Ends(1, HasSubstr("\"x\" is essential")),
                                 Prints(AllOf(HasSubstr("started again in 800 ms"),
                                              HasSubstr("5 times within a minute, and now is not.")))));
}

TEST(HgrosRun, AStoppedStarterDoesNotStopTheRobot) {
  RunningRobot robot(
      "components: {numbers: {type: relay/Numbers, params: {count: 20000}}, one: {type: relay/Checker, params: {count: "
      "20000}}, a: {type: relay/Does, params: {what: finish}}}\n"
      "processes: {p: {components: [numbers]}}\n");
  ASSERT_TRUE(robot.Prints("COMPONENT"));
  robot.Signal(SIGSTOP);
  test::Linger(std::chrono::milliseconds(300));
  robot.Signal(SIGCONT);
  EXPECT_EQ(robot.Wait(), 0) << robot.out() << robot.err();
  EXPECT_THAT(robot.out(), HasSubstr("all 20000"));
}

TEST(HgrosRun, MemoryOfEachHasALimit) {
  const std::string allocate = "{command: [python3, -c, 'len(bytearray(300_000_000)); print(\"enough\")'], ";
  RunningRobot robot(
      "components: {a: {type: relay/Does, params: {what: allocate}}, b: {type: relay/Does, params: {what: allocate}}}\n"
      "processes: {p: {components: [a], memory: 500MiB}}\n"
      "programs:\n  few: " +
      allocate + "memory: 200MB}\n  many: " + allocate + "memory: 1GB}\n");
  EXPECT_TRUE(robot.Prints("many  enough")) << robot.out();
  EXPECT_TRUE(robot.Prints("few   MemoryError")) << robot.out();
  EXPECT_TRUE(robot.Prints("std::bad_alloc")) << robot.out();
  EXPECT_THAT(robot.out(), AllOf(Not(HasSubstr("few   enough")), Not(HasSubstr("b/soon"))));
}

TEST(HgrosRun, WritesJson) {
  const RobotFolder robot("components: {a: {type: relay/Does, params: {what: finish}}}\n");
  EXPECT_THAT(robot.Run({"--json"}),
              Prints(0, AllOf(ContainsRegex("^\\{\"event\":\"started\",\"process\":\"main\",\"pid\":[^\n]*"
                                            "\"components\":\\[\"a\"\\]\\}\n"),
                              HasSubstr("\"component\":\"a\",\"level\":\"info\",\"text\":\"I run.\"}\n"))));
}

TEST(HgrosRun, AFullDiskDoesNotEndTheRobot) {
  const RobotFolder robot("components: {a: {type: relay/Does, params: {what: finish}}}\n");
  for (const char* more : {"", " --json"}) {
    EXPECT_THAT(RunInShell("\"$HGROS\" run " + robot.file() + more + " > /dev/full", robot.environment()),
                Ends(0, HasSubstr("The robot runs on; `hgros logs` shows its log.")));
  }
}

TEST(HgrosRun, EndsQuietlyWhenNobodyReads) {
  const RobotFolder robot("components: {a: {type: relay/Does, params: {what: log}}}\n");
  EXPECT_THAT(RunInShell("\"$HGROS\" run " + robot.file() + " | head -n 1", robot.environment()),
              Writes(HasSubstr("COMPONENT")));
}

}  // namespace
}  // namespace hgros::cli
