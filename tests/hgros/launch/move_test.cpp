// hgros move: real processes, messages that flow, and processes that are killed and stopped meanwhile.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <random>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "hgros/params/remote_params.hpp"
#include "support/await.hpp"
#include "support/seed.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// The passing component moves between a, b and c. Nothing happens to "ends" and "beside", so nothing that goes from one
// to the other is lost or repeated, whatever happens to the rest.
constexpr const char* kMoving =
    "components:\n"
    "  counting: {type: moving/Counting}\n"
    "  passing: {type: moving/Passing, checkpoint: 50ms}\n"
    "  judging: {type: moving/Judging}\n"
    "  witness: {type: moving/Judging, remap: {passed: number, ask: ask_witness}}\n"
    "  does: {type: relay/Does}\n"
    "processes:\n"
    "  ends: {components: [counting, judging]}\n"
    "  beside: {components: [witness]}\n"
    "  a: {components: [passing], restart: on-failure}\n"
    "  b: {restart: on-failure}\n"
    "  c: {components: [does], restart: on-failure}\n";

class MovingRobot : public RunningRobot {
 public:
  explicit MovingRobot(const std::string& text = kMoving) : RunningRobot(text) {
    EXPECT_TRUE(Prints("judging"));
    AskUntil({"ps"}, cli::Prints(0, Not(HasSubstr("starting"))));
    EXPECT_TRUE(Flows()) << out();
  }

  [[nodiscard]] CommandEnd Move(const std::string& to, const std::string& component = "passing") const {
    return Ask({"move", component, "--to", to});
  }
  // Where the component runs, of each process that has it.
  [[nodiscard]] std::vector<std::string> Places() const {
    return Matches(Ask({"ps"}).out, R"(passing +moving/Passing +(\w+) +\d+ +running)");
  }
  [[nodiscard]] pid_t PidOf(const std::string& process) const {
    const auto pids = Matches(Ask({"ps"}).out, " " + process + R"( +(\d+) +)");
    return pids.empty() ? 0 : std::stoi(pids.front());
  }
  // How far the messages have come. Asks.
  [[nodiscard]] int Count() {
    const std::string question = std::to_string(++questions_);
    EXPECT_EQ(Ask(Patiently({"pub", "ask", "{value: " + question + "}"})).status, 0);
    std::vector<std::string> numbers;
    const auto answered = [&] {
      numbers = Matches(out(), "answers " + question + R"(: up to (-?\d+)\.)");
      return !numbers.empty();
    };
    return test::Await(answered) ? std::stoi(numbers.front()) : -1;
  }
  // Whether messages still come through.
  [[nodiscard]] bool Flows() {
    const int now = Count();
    return test::Await([&] { return Count() > now; });
  }
  // Whether the state of the component has all messages that have come through.
  [[nodiscard]] bool HasCountedAll() {
    const int before = Count();
    const CommandEnd count = Ask(Patiently({"call", "count", "{}"}));
    EXPECT_EQ(count.status, 0) << count.err;
    const std::vector<std::string> numbers = Matches(count.out, R"((\d+))");
    return !numbers.empty() && std::stoi(numbers.front()) >= before;
  }
  [[nodiscard]] std::vector<std::string> Faults(const std::string& component = "judging") const {
    return Matches(out(), component + R"( +warning: ((?:lost|again) \d.*))");
  }

 private:
  [[nodiscard]] static std::vector<std::string> Matches(const std::string& text, const std::string& pattern) {
    std::vector<std::string> found;
    const std::regex regex(pattern);
    for (std::sregex_iterator at(text.begin(), text.end(), regex), end; at != end; ++at) found.push_back((*at)[1]);
    return found;
  }

  int questions_ = 0;
};

TEST(HgrosMove, LosesNothingAndRepeatsNothingAsARestartOfTheComponent) {
  MovingRobot robot;
  const pid_t process = robot.PidOf("a");
  int before = robot.Count();
  const int restarts = test::Rounds(4, 8);
  for (int times = 0; times < restarts; ++times) {  // One right after the other, and while many messages come.
    EXPECT_THAT(robot.Ask({"restart", "passing"}), Writes("")) << robot.out();
    if (times % 2 == 0) continue;
    ASSERT_TRUE(test::Await([&] { return robot.Count() > before + 1000; }));
    before = robot.Count();
  }
  EXPECT_EQ(robot.PidOf("a"), process);
  EXPECT_THAT(robot.Faults(), IsEmpty()) << robot.out();
  for (const std::string to : {"b", "c"}) {  // A restart waits for the end of the move.
    EXPECT_EQ(robot.Move(to).status, 0) << robot.out();
    EXPECT_THAT(robot.Ask({"restart", "passing"}), Ends(0));
    EXPECT_EQ(robot.Places(), std::vector{to});
  }
  EXPECT_TRUE(robot.Flows());
  EXPECT_THAT(robot.Faults(), IsEmpty()) << robot.out();
  EXPECT_TRUE(robot.HasCountedAll());
  for (const std::string to : {"a", "ends", "b", "a", "a"}) {
    const CommandEnd end = robot.Move(to);
    if (end.status != 0 && end.err.find("at this moment") != std::string::npos) {
      EXPECT_TRUE(test::Await([&] { return robot.Places().size() == 1; }));
      continue;
    }
    EXPECT_THAT(end, Writes("")) << robot.out();
    EXPECT_EQ(robot.Places(), std::vector{to});
  }
  EXPECT_TRUE(robot.Flows());
  EXPECT_THAT(robot.Faults(), IsEmpty()) << robot.out();
  EXPECT_TRUE(robot.HasCountedAll()) << "Its state went along.";
  robot.End();
  EXPECT_THAT(
      robot.out() + robot.err(),
      AllOf(HasSubstr("It has moved here from \"a\". No message of it was handled for"), Not(HasSubstr("error"))));
}

// What the old place has published comes before what the new one does.
TEST(HgrosMove, WaitsForALosslessSubscriberThatStandsStill) {
  MovingRobot robot(
      "components:\n"
      "  counting: {type: moving/Counting}\n"
      "  passing: {type: moving/Passing}\n"
      "  judging: {type: moving/Judging}\n"
      "processes:\n"
      "  takes: {components: [judging]}\n"
      "  a: {components: [passing]}\n"
      "  b: {}\n");
  const pid_t takes = robot.PidOf("takes");
  ASSERT_GT(takes, 0);
  for (const std::string to : {"b", "a"}) EXPECT_EQ(robot.Move(to).status, 0) << "Both places are connected then.";
  EXPECT_TRUE(robot.Flows());
  ASSERT_EQ(kill(takes, SIGSTOP), 0);
  auto moves = std::async(std::launch::async, [&] { return robot.Move("b"); });
  test::Linger(std::chrono::milliseconds(600));
  ASSERT_EQ(kill(takes, SIGCONT), 0);
  EXPECT_EQ(moves.get().status, 0) << robot.out();
  EXPECT_TRUE(robot.Flows());
  ASSERT_EQ(kill(takes, SIGSTOP), 0);
  const CommandEnd refused = robot.Move("a");
  ASSERT_EQ(kill(takes, SIGCONT), 0);
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("its subscribers let messages wait"));
  EXPECT_TRUE(robot.Flows());
  EXPECT_EQ(robot.Places(), std::vector<std::string>{"b"});
  EXPECT_THAT(robot.Faults(), IsEmpty()) << robot.out();
}

TEST(HgrosMove, ASubscriberWhoseProcessHasEndedHoldsNothingUp) {
  std::string text = kMoving;
  text.replace(text.find("  does:"), 0, "  other: {type: moving/Judging, remap: {ask: ask_other}}\n");
  text.replace(text.find("[witness]"), 9, "[witness, other]");
  MovingRobot robot(text);
  const pid_t beside = robot.PidOf("beside");
  ASSERT_GT(beside, 0);
  ASSERT_EQ(kill(beside, SIGKILL), 0);
  ASSERT_TRUE(robot.Prints("it was ended by SIGKILL")) << robot.out();
  EXPECT_THAT(robot.Move("b"), Ends(0));
  EXPECT_TRUE(robot.Flows()) << robot.out();
}

// A session stays a publisher when its component has left, so the old place counts the new one.
TEST(HgrosMove, AComponentFollowsItsPublisherToAPlaceWhichThatHasLeft) {
  MovingRobot robot(
      "components:\n"
      "  counting: {type: moving/Counting}\n"
      "  first: {type: moving/Passing, remap: {passed: between}}\n"
      "  passing: {type: moving/Passing, remap: {number: between, count: count_again}}\n"
      "  judging: {type: moving/Judging}\n"
      "processes:\n"
      "  ends: {components: [counting, judging]}\n"
      "  a: {components: [first]}\n"
      "  b: {components: [passing]}\n"
      "  c: {}\n");
  for (const auto& [component, to] : std::vector<std::pair<std::string, std::string>>{
           {"first", "c"}, {"first", "a"}, {"passing", "c"}, {"passing", "a"}, {"passing", "b"}}) {
    EXPECT_THAT(robot.Move(to, component), Ends(0)) << robot.out();
  }
  EXPECT_TRUE(robot.Flows());
  EXPECT_THAT(robot.Faults(), IsEmpty()) << robot.out();
}

TEST(HgrosMove, APublisherFollowsItsSlowSubscriberWithoutOvertakingWhatWaits) {
  MovingRobot robot(
      "components:\n"
      "  source: {type: moving/Source}\n"
      "  slow: {type: moving/Slow}\n"
      "  judging: {type: moving/Judging, remap: {passed: number}}\n"
      "processes:\n"
      "  ends: {components: [judging]}\n"
      "  a: {components: [source, slow]}\n"
      "  b: {}\n");
  ASSERT_TRUE(robot.Prints("has 50.")) << robot.out();  // Its queue is full.
  for (const std::string to : {"b", "a", "b"}) {
    for (const std::string component : {"slow", "source"}) {
      EXPECT_THAT(robot.Move(to, component), Ends(0)) << robot.out();
    }
  }
  const int now = robot.Count();
  EXPECT_TRUE(test::Await([&] { return robot.Count() > now + 100; }));
  EXPECT_THAT(robot.out(), Not(HasSubstr("warning: got "))) << robot.out();
}

TEST(HgrosMove, StaysIfNothingLeadsFromItsPublisherToTheNewPlace) {
  MovingRobot robot(
      "channels: {number: {transports: [zmq]}}\n"  // And no endpoint.
      "components:\n"
      "  source: {type: moving/Source}\n"
      "  slow: {type: moving/Slow}\n"
      "  judging: {type: moving/Judging, remap: {passed: number}}\n"
      "processes:\n"
      "  a: {components: [source, slow, judging]}\n"
      "  b: {}\n");
  EXPECT_THAT(robot.Move("b", "slow"),
              Ends(1, HasSubstr("Not all publishers of the channel \"number\" were connected after 10 s.")));
  EXPECT_THAT(robot.Ask({"ps"}).out, testing::ContainsRegex("slow +moving/Slow +a "));
  EXPECT_TRUE(robot.Flows());
  EXPECT_THAT(robot.out(), Not(HasSubstr("warning: got "))) << robot.out();
}

TEST(HgrosMove, ParametersThatAreSetMeanwhileAreKept) {
  MovingRobot robot;
  RobotForCommands desk("desk", robot.domain());
  RemoteParams params(desk.session(), "passing");
  std::mt19937 random(11);
  int last = 0;
  for (int round = 0; round < test::Rounds(8, 24); ++round) {
    const std::string to = std::vector<std::string>{"a", "b", "c"}[random() % 3];
    const bool moves = round % 2 == 0;
    const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(random() % 80'000);
    auto done = std::async(std::launch::async, [&] {
      return moves ? robot.Move(to) : robot.Ask({"restart", "passing"});
    });
    std::vector<int> possible{last};  // One that fails may have been set, or not.
    do {
      const bool ok = params.Set("bytes", ++last).ok();
      if (ok) possible.clear();
      possible.push_back(last);
    } while (std::chrono::steady_clock::now() < end);
    EXPECT_EQ(done.get().status, 0);
    const auto value = params.Get<int>("bytes");
    ASSERT_TRUE(value.ok()) << value.refusal;
    EXPECT_THAT(possible, testing::Contains(*value)) << "round " << round << (moves ? ", moved to " + to : "");
    last = std::max(last, *value);
  }
}

TEST(HgrosMove, StaysAndSaysWhyItCannot) {
  MovingRobot robot(std::string(kMoving) + "programs: {program: {command: [sleep, 100d]}}\n");
  const auto fault = [&](const std::vector<std::string>& words) {
    const CommandEnd end = robot.Ask(words);
    EXPECT_NE(end.status, 0);
    return end.err;
  };
  EXPECT_THAT(fault({"move", "passing"}), HasSubstr("Say where: `hgros move passing --to PROCESS`."));
  EXPECT_THAT(fault({"move", "pasing", "--to", "b"}),
              HasSubstr("The robot has no component \"pasing\". Did you mean \"passing\"?"));
  EXPECT_THAT(
      fault({"move", "passing", "--to", "end"}),
      HasSubstr(
          "This hgros run has started no process \"end\", and the robot has no such host. Did you mean \"ends\"?"));
  EXPECT_THAT(fault({"move", "passing", "--to", "program"}), HasSubstr("\"program\" is a program."));
  EXPECT_THAT(fault({"move", "does", "--to", "a"}),
              AllOf(HasSubstr("\"does\" was not moved to \"a\". It runs on in \"c\"."),
                    HasSubstr("Give it Save() and Restore().")));
  ASSERT_EQ(robot.Ask(Patiently({"param", "set", "passing", "activate", "false"})).status, 0);
  EXPECT_THAT(
      robot.Move("b"),
      Ends(1, HasSubstr("It runs on in \"a\". Component \"passing\" (moving/Passing): it does not want to be here")));
  EXPECT_EQ(robot.Places(), std::vector<std::string>{"a"});
  EXPECT_TRUE(robot.Flows()) << robot.out();
  EXPECT_THAT(robot.Faults(), IsEmpty()) << robot.out();
  ASSERT_EQ(robot.Ask(Patiently({"param", "set", "passing", "activate", "true"})).status, 0);
  EXPECT_EQ(robot.Move("b").status, 0);
  EXPECT_TRUE(robot.Flows());
  EXPECT_THAT(robot.Faults(), IsEmpty()) << robot.out();
}

// A process that is killed or stopped during a move.
struct Fault {
  bool kills;
  bool old;  // The process that the component leaves.
  std::chrono::microseconds after;
  std::chrono::milliseconds stopped;
};

// A move while something happens.
void MoveWith(MovingRobot& robot, const std::string& from, const std::string& to, const Fault& fault) {
  const pid_t victim = robot.PidOf(fault.old ? from : to);
  ASSERT_GT(victim, 0);
  const std::size_t faults = robot.Faults().size();
  const std::size_t said = robot.out().size();
  auto moved = std::async(std::launch::async, [&] { return robot.Move(to); });
  test::Linger(fault.after);
  ASSERT_EQ(kill(victim, fault.kills ? SIGKILL : SIGSTOP), 0);
  if (!fault.kills) {
    test::Linger(fault.stopped);
    ASSERT_EQ(kill(victim, SIGCONT), 0);
  }
  const CommandEnd end = moved.get();
  std::vector<std::string> at;
  EXPECT_TRUE(test::Await([&] {
    at = robot.Places();
    return at.size() == 1 && robot.PidOf("a") > 0 && robot.PidOf("b") > 0 && robot.PidOf("c") > 0;
  }));
  if (end.status == 0 && !fault.kills) {
    EXPECT_EQ(at, std::vector{to});
  }
  if (end.status != 0) {
    EXPECT_THAT(end.err, HasSubstr("\"" + (at.empty() ? "" : at[0]) + "\"")) << "It says where it runs.";
  }
  EXPECT_TRUE(robot.Flows());
  if (!fault.kills) {
    EXPECT_EQ(robot.Faults().size(), faults) << "Nobody has died.";
  }
  if (robot.Faults().size() > faults) {
    EXPECT_THAT(robot.out().substr(said), HasSubstr("messages of the lossless channel")) << "It is counted, and said.";
  }
  EXPECT_THAT(robot.Faults("witness"), IsEmpty()) << "Neither end has died.";
}

// 200 rounds: HGROS_MOVE_ROUNDS=200.
TEST(HgrosMove, WhoeverIsKilledOrStoppedOnePlaceRunsIt) {
  constexpr int kRoundsOfARobot = 5;  // A process that is killed more often is not started again.
  const char* wanted = std::getenv("HGROS_MOVE_ROUNDS");
  std::mt19937 random(test::Seed());
  const std::vector<std::string> processes{"a", "b", "c"};
  int left = wanted == nullptr ? kRoundsOfARobot : std::stoi(wanted);
  while (left > 0 && !testing::Test::HasFailure()) {
    MovingRobot robot;
    for (int round = 0; round < kRoundsOfARobot && !testing::Test::HasFailure(); ++round, --left) {
      const std::vector<std::string> at = robot.Places();
      ASSERT_EQ(at.size(), 1U) << robot.out();
      const auto here = std::ranges::find(processes, at[0]) - processes.begin();
      const std::string to = processes[(static_cast<std::size_t>(here) + 1 + random() % 2) % 3];
      const Fault fault{random() % 2 == 0, random() % 2 == 0, std::chrono::microseconds(random() % 30'000),
                        std::chrono::milliseconds(random() % 300)};
      SCOPED_TRACE(at[0] + " to " + to + ", " + (fault.kills ? "kills " : "stops ") + (fault.old ? at[0] : to) +
                   " after " + std::to_string(fault.after.count()) + " us");
      MoveWith(robot, at[0], to, fault);
    }
    const std::string pids = robot.Ask({"ps"}).out;
    robot.End();
    const std::regex pid(R"( (\d{2,}) +running)");
    for (std::sregex_iterator at(pids.begin(), pids.end(), pid), end; at != end; ++at) {
      EXPECT_FALSE(cli::Runs(std::stoi((*at)[1]))) << "An orphan.";
    }
    EXPECT_THAT(robot.FilesLeft(), IsEmpty());
    if (testing::Test::HasFailure()) printf("%s\n", robot.out().c_str());
  }
}

}  // namespace
}  // namespace hgros::cli
