// What of a component outlives its end: checkpoints, changed parameters, restarts of one component alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <functional>
#include <regex>
#include <string>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "support/at_once.hpp"
#include "support/await.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// The robot's counter hears a word.
void Say(const RunningRobot& robot, const std::string& word) {
  EXPECT_THAT(robot.Ask(Patiently({"pub", "word", "{value: " + word + "}"})), Ends(0));
}

// Whether the counter has counted so much when it has heard the word.
bool CountsAfter(const RunningRobot& robot, const std::string& word, int count) {
  Say(robot, word);
  return robot.Prints("counts " + std::to_string(count) + ".");
}

// Whether the starter gets a checkpoint with this count.
bool HasCheckpoint(const RunningRobot& robot, int count) {
  return robot.Prints("has saved " + std::to_string(count) + ".");
}

TEST(HgrosCheckpoint, AKilledProcessGoesOnFromTheLastCheckpointWithChangedParameters) {
  RunningRobot robot(
      "components: {counter: {type: relay/Counter, checkpoint: 20ms}, other: {type: relay/Does}}\n"
      "processes: {p: {components: [counter], restart: on-failure}}\n");
  ASSERT_TRUE(robot.Prints("other    I run."));
  Say(robot, "one");
  ASSERT_TRUE(CountsAfter(robot, "two", 2));
  ASSERT_TRUE(HasCheckpoint(robot, 2));
  ASSERT_THAT(robot.Ask(Patiently({"param", "set", "counter", "step", "5"})), Ends(0));
  Say(robot, "echo");
  ASSERT_TRUE(robot.Prints("holds 2."));  // What was said before has reached the starter, too.
  ASSERT_EQ(kill(PidsIn(robot.out()).at(0), SIGKILL), 0);
  EXPECT_TRUE(robot.Prints("begins at 2."));
  EXPECT_TRUE(CountsAfter(robot, "three", 7));
  Say(robot, "secret");
  const std::string told = "its state is secret";
  ASSERT_TRUE(robot.Prints(told));
  test::Linger(std::chrono::milliseconds(600));  // Many more checkpoints.
  EXPECT_THAT(robot.out(), HasSubstr("There is no new checkpoint: "));
  EXPECT_EQ(Times(robot.out(), told), 1U) << "A save that fails each time is told now and then.\n" << robot.out();
}

// Its messages arrive at once, but the one that takes what it publishes has no time to connect.
TEST(HgrosCheckpoint, WhatAKilledProcessPublishesWhenItIsBackReachesAll) {
  RunningRobot robot(
      "components:\n"
      "  counting: {type: moving/Counting}\n"
      "  passing: {type: moving/Passing, params: {tells: true}}\n"
      "  judging: {type: moving/Judging}\n"
      "processes:\n"
      "  p: {components: [passing], restart: on-failure}\n"
      "  q: {components: [judging]}\n");
  ASSERT_TRUE(robot.Prints("judging   has 1000."));
  const pid_t passing = PidsIn(robot.out()).at(0);
  const pid_t judging = PidsIn(robot.out()).at(1);
  ASSERT_EQ(kill(judging, SIGSTOP), 0);
  ASSERT_EQ(kill(passing, SIGKILL), 0);
  const auto first = [&] {
    std::smatch found;
    const std::string out = robot.out();
    const bool told = std::regex_search(out, found, std::regex("is started again[\\s\\S]*passes from (\\d+)"));
    return told ? std::stoi(found[1]) : 0;
  };
  (void)test::Await([&] { return first() > 0; }, std::chrono::seconds(1));
  ASSERT_EQ(kill(judging, SIGCONT), 0);
  ASSERT_TRUE(test::Await([&] { return first() > 0; })) << robot.out();
  EXPECT_TRUE(test::Await([&] {
    return std::regex_search(robot.out(),
                             std::regex("judging +warning: lost \\d+ to " + std::to_string(first() - 1) + "\\b"));
  })) << robot.out();
}

// One state is larger than what the starter's socket takes at once.
TEST(HgrosCheckpoint, ARestartOnRequestLosesNothing) {
  RunningRobot robot(
      "components:\n"
      "  counter: {type: relay/Counter, checkpoint: 1h}\n"
      "  largest: {type: relay/Counter, checkpoint: 1h, params: {ballast_bytes: 20000000}}\n"
      "  other: {type: relay/Does}\n"
      "processes: {p: {components: [counter, largest]}}\n");
  ASSERT_TRUE(robot.Prints("other    I run."));
  Say(robot, "one");
  ASSERT_TRUE(robot.Prints("counts 1.", 2));
  EXPECT_EQ(robot.Ask({"restart", "p"}).status, 0);
  EXPECT_TRUE(robot.Prints("counter  begins at 1."));
  EXPECT_TRUE(robot.Prints("largest  begins at 1.")) << robot.out();
  Say(robot, "two");
  ASSERT_TRUE(robot.Prints("counts 2.", 2));
  EXPECT_EQ(robot.Ask({"restart", "counter"}).status, 0);
  EXPECT_TRUE(robot.Prints("counter  begins at 2.")) << "The component alone.";
}

TEST(HgrosCheckpoint, LargeStatesCostNoLinesOfTheLog) {
  RunningRobot robot(
      "components:\n"
      "  counting: {type: moving/Counting}\n"
      "  counter: {type: relay/Counter, remap: {word: number}, checkpoint: 50ms, params: {ballast_bytes: 20000000}}\n"
      "processes: {p: {components: [counter]}}\n");
  ASSERT_TRUE(robot.Prints("counts 3000."));
  EXPECT_THAT(robot.out(), Not(HasSubstr("lines of the log were lost")));
}

TEST(HgrosCheckpoint, ComponentsOfAProcessAreConstructedAgainAtOnce) {
  RunningRobot robot(
      "components: {a: {type: relay/Counter}, b: {type: relay/Counter}, c: {type: relay/Does}}\n"
      "processes: {p: {components: [a, b, c]}}\n");
  ASSERT_TRUE(robot.Prints("c  I run."));
  for (int round = 0; round < 5; ++round) {
    std::vector<std::function<void()>> restarts;
    for (const char* name : {"a", "b", "c", "a"}) {
      restarts.emplace_back([&robot, name] { EXPECT_THAT(robot.Ask({"restart", name}), Ends(0)); });
    }
    test::AtOnce(restarts);
  }
  EXPECT_THAT(robot.Ask({"ps"}).out, Not(HasSubstr("ended")));
  EXPECT_THAT(robot.out(), Not(HasSubstr("is killed")));
}

TEST(HgrosCheckpoint, AFailureIsForgottenAtARestart) {
  RunningRobot robot(
      "components: {a: {type: relay/Does, params: {what: \"fail, then finish\"}}, other: {type: relay/Does}}\n"
      "processes: {p: {components: [a]}}\n");
  ASSERT_TRUE(robot.Prints("It has failed: the laser is cold"));
  (void)robot.Ask({"restart", "p"});
  ASSERT_TRUE(robot.Prints("It has finished: enough"));
  EXPECT_TRUE(test::Await([&] { return robot.Ask({"ps"}).out.find("finished") != std::string::npos; }));
  EXPECT_THAT(robot.Ask({"ps"}).out, Not(HasSubstr("failed")));
}

// Also without checkpoints.
TEST(HgrosCheckpoint, ARestartOfAComponentKeepsItsStateAndItsParameters) {
  RunningRobot robot(
      "components: {counter: {type: relay/Counter}, other: {type: relay/Does}}\n"
      "processes: {p: {components: [counter]}}\n");
  ASSERT_TRUE(robot.Prints("other    I run."));
  ASSERT_TRUE(CountsAfter(robot, "one", 1));
  ASSERT_EQ(robot.Ask(Patiently({"param", "set", "counter", "step", "5"})).status, 0);
  EXPECT_EQ(robot.Ask({"restart", "counter"}).status, 0);
  EXPECT_TRUE(robot.Prints("begins at 1."));
  EXPECT_THAT(robot.Ask(Patiently({"param", "get", "counter", "step"})).out, HasSubstr("5"));
  EXPECT_TRUE(CountsAfter(robot, "two", 6));
  ASSERT_EQ(robot.Ask(Patiently({"param", "set", "counter", "step", "7"})).status, 0) << "Changes are still kept.";
  EXPECT_EQ(robot.Ask({"restart", "counter"}).status, 0);
  EXPECT_TRUE(CountsAfter(robot, "three", 13));
}

TEST(HgrosCheckpoint, AParameterThatTheComponentRefusesIsNotKept) {
  const std::string refusal =
      "(what: \"throw at start\"), so it begins without them. Component \"a\" (relay/Does): there is no laser";
  for (const std::string restarted : {"a", "p"}) {  // The component alone, and its process.
    RunningRobot robot(
        "components: {a: {type: relay/Does}, other: {type: relay/Does}}\nprocesses: {p: {components: [a]}}\n");
    ASSERT_TRUE(robot.Prints("other  I run."));
    ASSERT_EQ(robot.Ask(Patiently({"param", "set", "a", "what", "throw at start"})).status, 0);
    EXPECT_EQ(robot.Ask({"restart", restarted}).status, 0);
    ASSERT_TRUE(robot.Prints(refusal));
    EXPECT_THAT(robot.Ask(Patiently({"param", "get", "a", "what"})).out, HasSubstr("nothing"));
    EXPECT_EQ(robot.Ask({"restart", "p"}).status, 0);
    EXPECT_EQ(Times(robot.out(), refusal), 1U) << "It was forgotten everywhere.";
  }
}

TEST(HgrosCheckpoint, AComponentThatThrowsIsConstructedAgainAlone) {
  RunningRobot robot(
      "components: {counter: {type: relay/Counter, checkpoint: 20ms, restart: on-exception}, other: {type: "
      "relay/Does}}\n");
  ASSERT_TRUE(robot.Prints("I run."));
  const std::vector<pid_t> pids = PidsIn(robot.out());
  ASSERT_TRUE(CountsAfter(robot, "one", 1));
  ASSERT_TRUE(HasCheckpoint(robot, 1));
  Say(robot, "throw");
  EXPECT_TRUE(robot.Prints("begins at 1."));
  EXPECT_TRUE(CountsAfter(robot, "two", 2));
  for (const pid_t pid : pids) EXPECT_TRUE(Runs(pid));
  EXPECT_THAT(robot.out(),
              AllOf(HasSubstr("It is constructed again, because it has failed: it does not know this word"),
                    Not(HasSubstr("I end."))));
}

TEST(HgrosCheckpoint, AComponentThatIsLateIsConstructedAgainAlone) {
  RunningRobot robot(
      "components:\n  counter: {type: relay/Counter, checkpoint: 20ms, deadline: 200ms, restart: on-deadline}\n"
      "  other: {type: relay/Does}\n");
  ASSERT_TRUE(robot.Prints("I run."));
  ASSERT_TRUE(CountsAfter(robot, "one", 1));
  ASSERT_TRUE(HasCheckpoint(robot, 1));
  Say(robot, "slow");
  EXPECT_TRUE(robot.Prints("Its deadline is 200.0 ms."));
  EXPECT_TRUE(
      robot.Prints("It is constructed again, because it has failed: A callback took longer than its deadline."));
  EXPECT_TRUE(robot.Prints("begins at "));
  EXPECT_THAT(robot.out(), Not(HasSubstr("I end.")));
}

void AComponentThatCannotBeConstructedAgainEndsNoOther() {
  RunningRobot robot(
      "components:\n"
      "  bad: {type: relay/Does, deadline: 100ms, params: {what: throw at restart}}\n"
      "  other: {type: relay/Does}\n"
      "processes: {p: {components: [bad, other]}}\n");
  ASSERT_TRUE(robot.Prints("other  I run."));
  (void)robot.Ask({"restart", "bad"});
  ASSERT_TRUE(robot.Prints("It has failed"));
  test::Linger(std::chrono::milliseconds(1500));  // Meanwhile the process looks for callbacks that hang, each second.
  EXPECT_THAT(robot.Ask({"ps"}).out, testing::ContainsRegex("other[^\n]*running"));
}

void ARestartOfOneComponentEndsWhenTheNextInstanceRuns() {
  RunningRobot robot("components: {bad: {type: relay/Does, params: {what: throw late}}, other: {type: relay/Does}}\n");
  ASSERT_TRUE(robot.Prints("I wait."));
  EXPECT_EQ(robot.Ask({"restart", "bad"}).status, 0) << "Meanwhile a callback of the last one throws.";
  EXPECT_EQ(Times(robot.out(), "bad    I run."), 2U) << robot.out();
}

void ARestartOfAComponentWhoseProcessEndsAtThatMomentStartsItAgain() {
  RunningRobot robot(
      "components: {a: {type: relay/Does, params: {what: finish once}}, other: {type: relay/Does}}\n"
      "processes: {p: {components: [a]}}\n");
  ASSERT_TRUE(robot.Prints("It has finished: enough"));
  const CommandEnd end = robot.Ask({"restart", "a"});  // Its process still ends, for a second.
  EXPECT_EQ(end.status, 0) << end.err << robot.out();
  EXPECT_THAT(robot.Ask({"ps"}).out, testing::ContainsRegex("a +relay/Does[^\n]*running"));
  EXPECT_THAT(robot.out(), Not(HasSubstr("has failed")));
}

void AComponentThatFailsIsConstructedAgainUntilItIsTooOften() {
  const RobotFolder folder(
      "components: {a: {type: relay/Does, params: {what: fail}, restart: on-failure, essential: true}, b: {type: "
      "relay/Does}}\n");
  const CommandEnd end = folder.Run();
  EXPECT_THAT(end, Ends(1, HasSubstr("\"a\" is essential")));
  EXPECT_THAT(end.out, AllOf(HasSubstr("It is constructed again, because it has failed: the laser is broken"),
                             HasSubstr("It has failed: the laser is broken")));
  EXPECT_EQ(Times(end.out, "It is constructed again"), 5U);
}

void AComponentThatThrowsAgainAndAgainEndsWhenItIsTooOften() {
  RunningRobot robot(
      "components: {dark: {type: relay/Does, params: {what: throw always}, restart: on-exception}, other: {type: "
      "relay/Does}}\n");
  ASSERT_TRUE(robot.Prints("It has failed: Its callbacks still throw exceptions."));
  EXPECT_EQ(Times(robot.out(), "It is constructed again"), 5U);
  EXPECT_EQ(Times(robot.out(), "dark   I end."), 6U);
  EXPECT_THAT(robot.Ask({"ps"}).out, AllOf(testing::ContainsRegex("dark +relay/Does +main +[0-9]+  failed +5"),
                                           testing::ContainsRegex("other +relay/Does +main +[0-9]+  running +0")));
}

TEST(HgrosCheckpoint, ComponentsFailAndAreConstructedAgain) {
  test::AtOnce({AComponentThatCannotBeConstructedAgainEndsNoOther, ARestartOfOneComponentEndsWhenTheNextInstanceRuns,
                ARestartOfAComponentWhoseProcessEndsAtThatMomentStartsItAgain,
                AComponentThatFailsIsConstructedAgainUntilItIsTooOften,
                AComponentThatThrowsAgainAndAgainEndsWhenItIsTooOften});
}

void ARestartOfAComponentThatHangsAtItsEndLosesNoState() {
  RunningRobot robot(
      "components: {other: {type: relay/Does}, counter: {type: relay/Counter, params: {hangs_at_end: true}}}\n"
      "processes: {p: {components: [other, counter]}}\n");
  ASSERT_TRUE(robot.Prints("other    I run."));
  ASSERT_TRUE(CountsAfter(robot, "one", 1));
  EXPECT_EQ(robot.Ask({"restart", "counter"}).status, 0);
  EXPECT_TRUE(robot.Prints("other    I end."));
  EXPECT_TRUE(robot.Prints("It did not end in time, and is killed."));
  EXPECT_TRUE(robot.Prints("begins at 1."));
}

void ARestartOfAComponentThatHangsStartsItsProcessAgain() {
  RunningRobot robot(
      "components: {counter: {type: relay/Counter, checkpoint: 20ms}, other: {type: relay/Does}}\n"
      "processes: {p: {components: [counter]}}\n");
  ASSERT_TRUE(robot.Prints("other    I run."));
  ASSERT_TRUE(CountsAfter(robot, "one", 1));
  ASSERT_TRUE(HasCheckpoint(robot, 1));
  Say(robot, "hang");
  ASSERT_TRUE(robot.Prints("There is no new checkpoint: ")) << "It hangs.";
  EXPECT_EQ(robot.Ask({"restart", "counter"}).status, 0);
  EXPECT_TRUE(robot.Prints("It ends first, so the messages that wait for it are lost."));
  EXPECT_TRUE(robot.Prints("It did not end in time, and is killed."));
  EXPECT_TRUE(robot.Prints("begins at 1."));
  EXPECT_TRUE(CountsAfter(robot, "two", 2));
}

void TheProcessOfACallbackThatDoesNotReturnIsKilledAndStartsAgain() {
  RunningRobot robot(
      "components:\n  counter: {type: relay/Counter, checkpoint: 20ms, deadline: 200ms, restart: on-deadline}\n"
      "  other: {type: relay/Does}\n");
  ASSERT_TRUE(robot.Prints("I run."));
  ASSERT_TRUE(CountsAfter(robot, "one", 1));
  ASSERT_TRUE(HasCheckpoint(robot, 1));
  Say(robot, "hang");
  EXPECT_TRUE(robot.Prints("has run for "));
  EXPECT_TRUE(robot.Prints("A component was not constructed again in time, so it ends and starts again."));
  EXPECT_TRUE(robot.Prints("other    I end."));
  EXPECT_TRUE(robot.Prints("It did not end in time, and is killed."));
  EXPECT_TRUE(robot.Prints("begins at 1."));
  EXPECT_TRUE(CountsAfter(robot, "two", 2));
}

TEST(HgrosCheckpoint, WhatHangsIsKilledAndGoesOn) {
  test::AtOnce({ARestartOfAComponentThatHangsAtItsEndLosesNoState, ARestartOfAComponentThatHangsStartsItsProcessAgain,
                TheProcessOfACallbackThatDoesNotReturnIsKilledAndStartsAgain});
}

}  // namespace
}  // namespace hgros::cli
