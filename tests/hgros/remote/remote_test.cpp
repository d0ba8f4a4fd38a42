// Robots of two hosts that hgros run starts over ssh: real sshd, two network namespaces.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <iterator>
#include <memory>
#include <random>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "hgros/remote/ssh_host.hpp"
#include "remote/library_build.hpp"
#include "support/await.hpp"
#include "support/path.hpp"
#include "support/seed.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// The file system is shared, so that sessions would find each other by it.
constexpr const char* kHosts =
    "hosts: {desk: {address: 10.198.0.1, home: true}, base: {address: 10.198.0.2}}\n"
    "discovery: {local: false}\n";
constexpr const char* kDoes =
    "components: {does: {type: relay/Does}}\nprocesses: {p: {components: [does], host: base}}\n";

std::string HangingAtItsEnd(const std::string& setting = {}) {
  return std::string(kHosts) + "components: {does: {type: relay/Does, params: {what: hang at end}}}\n" +
         "processes: {p: {components: [does], host: base" + setting + "}}\n";
}

class HgrosRemote : public testing::Test {
 protected:
  void SetUp() override {
    if (!host_.missing.empty()) GTEST_SKIP() << host_.missing;
  }
  // Runs it until it says so.
  [[nodiscard]] std::unique_ptr<CommandRun> RunUntil(const RobotFolder& robot, const std::string& said) const {
    auto run = host_.Run(robot);
    if (!run->Prints(said)) throw Error("It does not say it:\n" + run->out() + run->err());
    return run;
  }
  // Ends it by Ctrl-C. Nothing of it is left then.
  void End(CommandRun& run) const {
    run.End();
    EXPECT_TRUE(host_.IsLeftClean()) << host_.Left();
  }
  // A command on the desk.
  void Do(const RobotFolder& robot, const std::vector<std::string>& words) const {
    const auto command = host_.OnDesk(robot, words);
    if (command->Wait() != 0) throw Error("It fails: " + command->err());
  }

  SshHost host_;
};

TEST_F(HgrosRemote, StartsProcessesAndProgramsOverSshAndBringsTheirLogBack) {
  const RobotFolder robot(std::string(kHosts) +
                          "components: {numbers: {type: relay/Numbers, params: {count: ${COUNT:-50}}},\n"
                          "             one: {type: relay/Checker, params: {count: 50}}}\n"
                          "processes: {p: {components: [numbers], host: base, env: {A: far away}}}\n"
                          "programs: {q: {host: base, env: {A: far away}, command: [sh, -c, "
                          "'echo $A; ip -o addr; exit 3']}}\n");
  const auto run = host_.Run(robot);
  EXPECT_EQ(run->Wait(), 1) << "The program fails.";
  EXPECT_THAT(run->out(), AllOf(HasSubstr("numbers  It has finished: 50 numbers"), HasSubstr("q        far away"),
                                HasSubstr("one      It has finished: all 50"), HasSubstr("inet 10.198.0.2/24"),
                                HasSubstr("The process has failed: it ended with exit code 3.")))
      << run->err();
  EXPECT_TRUE(host_.IsLeftClean()) << host_.Left();
}

TEST_F(HgrosRemote, ProgramsExchangeWhatTheySayAndCtrlCEndsAllInOrder) {
  const std::string hgros = test::Path("hgros");
  const RobotFolder robot(std::string(kHosts) +
                          "components: {counting: {type: moving/Counting}, counter: {type: relay/Counter},\n"
                          "             does: {type: relay/Does}}\n"
                          "processes: {p: {components: [does], host: base}}\n"
                          "programs:\n"
                          "  q: {host: base, command: [sh, -c, 'echo up; sleep 100d']}\n"
                          "  hears: {host: base, subscribes: [number], command: [" +
                          hgros +
                          ", echo, number, -n, 3, --field, value]}\n"
                          "  says: {host: base, publishes: [word], command: [" +
                          hgros + ", pub, word, '{value: one}', --type, foxglove.KeyValuePair, --timeout, 15]}\n");
  const auto run = RunUntil(robot, "counts 1.");
  EXPECT_TRUE(test::Await([&] {
    const std::string out = run->out();
    return std::regex_search(out, std::regex("hears +\"[0-9]+\"\n[^]*hears +\"[0-9]+\"\n[^]*hears +\"[0-9]+\"\n"));
  })) << run->out();
  for (const char* line : {"does      I run.", "q         up"}) ASSERT_TRUE(run->Prints(line)) << run->out();
  End(*run);
  EXPECT_THAT(run->out(), AllOf(HasSubstr("does      I end."), Not(HasSubstr("killed")), Not(HasSubstr("failed"))));
}

TEST_F(HgrosRemote, HostsWithKeysExchangeMessages) {
  const RobotWithKeys robot;
  robot.WriteKey("desk");
  const auto refused = host_.Run(robot);
  EXPECT_EQ(refused->Wait(), 1);
  EXPECT_THAT(refused->out(), AllOf(HasSubstr("p        error:"), HasSubstr("base.key\", which cannot be read")));
  robot.WriteKey("base");
  const auto run = host_.Run(robot);
  EXPECT_EQ(run->Wait(), 0) << run->out() << run->err();
  EXPECT_THAT(run->out(), HasSubstr("It has finished: all 100"));
}

TEST_F(HgrosRemote, HostsWithKeysExchangeMessagesOverIpv6) {
  const auto& cable = host_.cable;
  if (!test::Ip("-n " + cable.left + " addr add fd00:198::1/64 nodad dev " + cable.left_interface) ||
      !test::Ip("-n " + cable.right + " addr add fd00:198::2/64 nodad dev " + cable.right_interface)) {
    GTEST_SKIP() << "This system has no IPv6.";
  }
  const RobotWithKeys robot("fd00:198::1", "fd00:198::2");
  for (const char* host : {"desk", "base"}) robot.WriteKey(host);
  const auto run = host_.Run(robot);
  EXPECT_EQ(run->Wait(), 0) << run->out() << run->err();
  EXPECT_THAT(run->out(), HasSubstr("It has finished: all 100"));
}

// A robot whose passing component moves between two hosts.
class MovingBetweenHosts {
 public:
  explicit MovingBetweenHosts(const SshHost& host, const std::string& passing = "checkpoint: 50ms")
      : host_(host),
        robot_(std::string(kHosts) +
               "components:\n"
               "  counting: {type: moving/Counting}\n"
               "  passing: {type: moving/Passing, " +
               passing +
               "}\n"
               "  judging: {type: moving/Judging}\n"
               "processes:\n"
               "  near: {components: [counting, judging, passing], restart: on-failure}\n"
               "  far: {host: base, restart: on-failure}\n") {}

  // Where it runs, if that is one place and nothing is on its way.
  [[nodiscard]] std::string Place() const {
    static const std::regex kPlace(R"(passing +moving/Passing +(\w+)[^\n]* running)");
    const auto ps = host_.OnDesk(robot_, {"ps"});
    (void)ps->Wait();
    const std::string rows = ps->out();
    std::smatch found;
    if (rows.find("starting") != std::string::npos || rows.find("waiting") != std::string::npos) return {};
    if (!std::regex_search(rows, found, kPlace)) return {};
    const std::string rest = found.suffix();
    return std::regex_search(rest, kPlace) ? "" : found[1].str();
  }
  [[nodiscard]] std::unique_ptr<CommandRun> Move(const std::string& to) const {
    return host_.OnDesk(robot_, {"move", "passing", "--to", to});
  }
  // How many thousands have come through.
  [[nodiscard]] std::ptrdiff_t thousands() const { return Count("has \\d+000\\."); }
  [[nodiscard]] std::ptrdiff_t faults() const { return Count("(lost|again) \\d"); }
  [[nodiscard]] bool Flows() const {
    const auto before = thousands();
    return test::Await([&] { return thousands() > before; });
  }
  [[nodiscard]] CommandRun& run() const { return *run_; }

 private:
  [[nodiscard]] std::ptrdiff_t Count(const char* pattern) const {
    const std::string out = run_->out();
    const std::regex regex(pattern);
    return std::distance(std::sregex_iterator(out.begin(), out.end(), regex), std::sregex_iterator());
  }
  const SshHost& host_;
  const RobotFolder robot_;
  const std::unique_ptr<CommandRun> run_ = host_.Run(robot_);
};

TEST_F(HgrosRemote, AComponentMovesToAnotherHostAndBack) {
  const MovingBetweenHosts robot(host_, "params: {bytes: 100000}");
  CommandRun& run = robot.run();
  ASSERT_TRUE(test::Await([&] { return robot.Place() == "near"; })) << run.out() << run.err();
  for (const std::string to : {"base", "desk", "far", "near"}) {
    const auto move = robot.Move(to);
    EXPECT_EQ(move->Wait(), 0) << move->err();
  }
  const auto before = robot.thousands();
  EXPECT_TRUE(test::Await([&] { return robot.thousands() > before + 1; })) << run.out();
  End(run);
  EXPECT_THAT(run.out(), AllOf(HasSubstr("It has moved here from \"near\""), Not(HasSubstr("lost ")),
                               Not(HasSubstr("again")), Not(HasSubstr("refused")), Not(HasSubstr("has failed"))));
}

TEST_F(HgrosRemote, TriesAgainUntilAHostCanBeReached) {
  const RobotFolder robot(std::string(kHosts) +
                          "components: {does: {type: relay/Does}}\n"
                          "processes: {p: {components: [does], host: base, restart: on-failure}}\n");
  const pid_t listener = FindOn(host_.cable.right, "sshd");
  const auto run = RunUntil(robot, "does  I run.");
  ASSERT_EQ(kill(listener, SIGKILL), 0);
  ASSERT_EQ(kill(FindOn(host_.cable.right, "p"), SIGKILL), 0);
  ASSERT_TRUE(run->Prints("It is started again in 2000 ms.")) << run->out() << run->err();
  host_.StartSshd();
  EXPECT_TRUE(test::Await([&] { return Times(run->out(), "does  I run.") >= 2; })) << run->out() << run->err();
  run->End();
}

// A process that the test kills or stops during a move.
struct Victim {
  std::string space;
  std::string name;
};

// More rounds: HGROS_MOVE_ROUNDS=200.
TEST_F(HgrosRemote, WhoeverIsKilledOrStoppedInAMoveOnePlaceRunsIt) {
  constexpr int kRoundsOfARobot = 4;  // A process that is killed more often is not started again.
  const std::string& desk = host_.cable.left;
  const std::string& base = host_.cable.right;
  const std::vector<Victim> victims{{desk, "ssh"}, {base, "sshd"}, {base, "hgros"}, {base, "far"},
                                    {desk, "far"}, {desk, "near"}, {desk, "hgros"}};
  const char* wanted = std::getenv("HGROS_MOVE_ROUNDS");
  std::mt19937 random(test::Seed());
  const pid_t listener = FindOn(base, "sshd");
  int left = wanted == nullptr ? 2 * kRoundsOfARobot : std::stoi(wanted);
  while (left > 0 && !testing::Test::HasFailure()) {
    const MovingBetweenHosts robot(host_);
    ASSERT_TRUE(robot.run().Prints("far")) << robot.run().out() << robot.run().err();
    bool starter_killed = false;
    bool killed = false;
    for (int round = 0; round < kRoundsOfARobot && !starter_killed && !HasFailure(); ++round, --left) {
      std::string at;
      ASSERT_TRUE(test::Await([&] { return !(at = robot.Place()).empty(); })) << robot.run().out();
      const Victim& victim = victims[random() % victims.size()];
      const bool kills = random() % 2 == 0;
      const auto after = std::chrono::microseconds(random() % 40'000);
      SCOPED_TRACE("from " + at + ", " + (kills ? "kills " : "stops ") + victim.name + " after " +
                   std::to_string(after.count()) + " us");
      const auto faults = robot.faults();
      const auto move = robot.Move(at == "near" ? "far" : "near");
      test::Linger(after);
      const bool is_starter =
          victim.space == desk && victim.name == "hgros";  // The command that moves has that name, too.
      starter_killed = kills && is_starter;
      const int signal = kills ? SIGKILL : SIGSTOP;
      if (is_starter) robot.run().Signal(signal);
      if (starter_killed) break;
      const pid_t process = is_starter ? 0 : FindLastOn(victim.space, victim.name);
      // None may run just now, such as no ssh.
      const bool hits = is_starter || (process > 0 && process != listener && kill(process, signal) == 0);
      if (hits && !kills) {
        test::Linger(std::chrono::milliseconds(random() % 300));
        if (is_starter) {
          robot.run().Signal(SIGCONT);
        } else {
          (void)kill(process, SIGCONT);
        }
      }
      (void)move->Wait();
      ASSERT_TRUE(test::Await([&] { return !robot.Place().empty(); })) << move->err() << robot.run().out();
      EXPECT_TRUE(robot.Flows()) << robot.run().out();
      killed = killed || kills;  // Its messages may be missing for some time.
      if (!killed) {
        EXPECT_EQ(robot.faults(), faults) << "Nobody has died.\n" << robot.run().out();
      }
    }
    if (!starter_killed) robot.run().Signal(SIGINT);
    EXPECT_EQ(robot.run().Wait(), 128 + (starter_killed ? SIGKILL : SIGINT)) << robot.run().out();
    EXPECT_TRUE(host_.IsLeftClean()) << host_.Left();
  }
}

std::string HashesIn(const std::string& out) {
  std::smatch found;
  return std::regex_search(out, found, std::regex("hashes +map [0-9a-f]{16}, trajectory [0-9a-f]{16}")) ? found.str()
                                                                                                        : out;
}

// The paper's first use case: a node of the demo moves to another host and back, during operation.
TEST_F(HgrosRemote, AMapperThatMovesBetweenHostsDrawsTheSameMap) {
  host_.StartSshd(test::Path("slam2d_manifests"));
  const std::string include = "include: " + test::Path("slam2d") + "/slam2d.yaml\n";
  const RobotFolder alone(include, test::Path("slam2d_manifests"));
  const RobotFolder robot(include + kHosts +
                              "processes:\n"
                              "  front: {components: [source, matcher, writer], essential: true}\n"
                              "  back: {host: base, components: [mapper], essential: true}\n",
                          test::Path("slam2d_manifests"));
  const auto settings = [](const RobotFolder& folder) {
    return std::vector<std::string>{"--set", "source.params.scans=60", "--set",
                                    "writer.params.out=" + folder.path("out").string()};
  };
  std::vector<std::string> words = robot.Arguments(settings(robot));
  words.insert(words.end(), {"--set", "source.params.rate=1"});
  const auto run = host_.OnDesk(robot, words);
  ASSERT_TRUE(test::Await([&] {
    const auto ps = host_.OnDesk(robot, {"ps"});
    return ps->Wait() == 0 && std::regex_search(ps->out(), std::regex(R"(mapper [^\n]* running)"));
  })) << run->out()
      << run->err();
  for (const std::string to : {"desk", "base", "front"}) Do(robot, {"move", "mapper", "--to", to});
  EXPECT_EQ(run->Wait(), 0) << run->out() << run->err();
  const CommandEnd reference = alone.Run(settings(alone));
  ASSERT_EQ(reference.status, 0) << reference.out << reference.err;
  EXPECT_EQ(HashesIn(run->out()), HashesIn(reference.out));
}

TEST_F(HgrosRemote, NothingIsLeftWhenAnyPartIsKilled) {
  const RobotFolder robot(HangingAtItsEnd());
  const auto& desk = host_.cable.left;
  const auto& base = host_.cable.right;
  for (const auto& [victim, says] : {std::pair<Victim, std::string>{{desk, "hgros"}, ""},
                                     {{desk, "p"}, "it was ended by SIGKILL"},
                                     {{desk, "ssh"}, "The connection to the host \"base\" is lost: ssh has failed"},
                                     {{base, "p"}, "The process has failed: it was ended by SIGKILL."},
                                     {{base, "hgros"}, "The connection to the host \"base\" is lost."}}) {
    const auto run = RunUntil(robot, "does  I run.");
    ASSERT_EQ(kill(FindOn(victim.space, victim.name), SIGKILL), 0) << victim.name;
    EXPECT_EQ(run->Wait(), says.empty() ? 128 + SIGKILL : 1);
    EXPECT_THAT(run->out(), HasSubstr(says)) << run->err();
    EXPECT_TRUE(host_.IsLeftClean()) << victim.name << "\n" << host_.Left();
  }
}

TEST_F(HgrosRemote, NothingIsLeftWheneverItEnds) {
  const RobotFolder robot(std::string(kHosts) + kDoes + "programs: {q: {host: base, command: [sleep, 100d]}}\n");
  std::mt19937 random(test::Seed());
  for (int round = 0; round < 12; ++round) {
    const auto run = host_.Run(robot);
    const int after_ms = std::uniform_int_distribution(0, 1000)(random);
    test::Linger(std::chrono::milliseconds(after_ms));
    const int number = round % 2 == 0 ? SIGINT : SIGKILL;
    run->Signal(number);
    EXPECT_EQ(run->Wait(), 128 + number) << after_ms << " ms\n" << run->out() << run->err();
    EXPECT_TRUE(host_.IsLeftClean()) << after_ms << " ms\n" << host_.Left();
  }
}

TEST_F(HgrosRemote, ADeadNetworkEndsBothSides) {
  const RobotFolder robot(std::string(kHosts) + kDoes);
  const auto run = RunUntil(robot, "does  I run.");
  ASSERT_TRUE(host_.cable.Set("down"));
  EXPECT_EQ(run->Wait(), 1);
  EXPECT_THAT(run->out(), HasSubstr("The connection to the host \"base\" is lost."));
  EXPECT_TRUE(test::Await([&] { return FindOn(host_.cable.right, "p") == 0; })) << host_.Left();
  EXPECT_TRUE(test::Await([&] { return FindOn(host_.cable.right, "hgros") == 0; })) << host_.Left();
}

TEST_F(HgrosRemote, AStoppedStarterDoesNotStopTheRobot) {
  const RobotFolder robot(std::string(kHosts) + kDoes);
  const auto run = RunUntil(robot, "does  I run.");
  run->Signal(SIGSTOP);
  test::Linger(std::chrono::seconds(9));  // Longer than the other end waits for a sign of life.
  EXPECT_NE(FindOn(host_.cable.right, "p"), 0);
  run->Signal(SIGCONT);
  End(*run);
  EXPECT_THAT(run->out(), HasSubstr("does  I end."));
}

TEST_F(HgrosRemote, AProcessGoesOnFromItsCheckpoint) {
  const RobotFolder robot(
      "hosts: {desk: {address: 10.198.0.1, home: true}, base: {address: 10.198.0.2}}\n"
      "components: {counter: {type: relay/Counter, checkpoint: 1h, params: {step: 3}}}\n"
      "processes: {p: {components: [counter], host: base, restart: on-failure}}\n");
  const auto run = RunUntil(robot, "begins at 0.");
  const auto say_word = [&] {
    CommandRun pub(
        {"netns", "exec", host_.cable.right, test::Path("hgros"), "pub", "word", "{value: a}", "--timeout", "30"},
        robot.environment(), -1, "/sbin/ip");
    EXPECT_EQ(pub.Wait(), 0) << pub.err();
  };
  say_word();
  ASSERT_TRUE(run->Prints("counts 3."));
  const auto ps = host_.OnDesk(robot, {"ps"});
  EXPECT_EQ(ps->Wait(), 0);
  EXPECT_THAT(ps->out(), HasSubstr("relay/Counter  p on base"));
  Do(robot, {"restart", "counter"});
  EXPECT_TRUE(run->Prints("begins at 3."));
  // The same when only the connection ends.
  ASSERT_EQ(kill(FindOn(host_.cable.left, "ssh"), SIGKILL), 0);
  EXPECT_TRUE(run->Prints("It is started again."));
  EXPECT_TRUE(test::Await([&] {
    const std::string out = run->out();
    return out.find("begins at 3.", out.find("It is started again.")) != std::string::npos;
  })) << run->out();
  say_word();
  EXPECT_TRUE(run->Prints("counts 6.")) << run->out();
  End(*run);
}

TEST_F(HgrosRemote, WhatHasLostItsConnectionHasEndedBeforeItIsStartedAgain) {
  const RobotFolder robot(HangingAtItsEnd(", restart: on-failure"));
  for (const char* killed : {"ssh", "p"}) {  // p is the relay here.
    const auto run = RunUntil(robot, "does  I run.");
    const pid_t before = FindOn(host_.cable.right, "p");
    ASSERT_GT(before, 0);
    ASSERT_EQ(kill(FindOn(host_.cable.left, killed), SIGKILL), 0);
    EXPECT_TRUE(run->Prints("It is started again."));
    EXPECT_FALSE(Runs(before)) << killed;
    EXPECT_TRUE(test::Await([&] { return FindOn(host_.cable.right, "p") > 0; })) << run->out();
    End(*run);
  }
}

TEST_F(HgrosRemote, WhatHangsAtItsEndIsRestartedThere) {
  const RobotFolder robot(HangingAtItsEnd());
  const auto run = RunUntil(robot, "does  I run.");
  Do(robot, {"restart", "p"});
  End(*run);
}

TEST_F(HgrosRemote, SaysWhichLibraryDiffers) {
  const RobotFolder other("");
  const std::filesystem::path library = other.path("libhgros_test_relay.so");
  std::filesystem::copy(std::filesystem::path(test::Path("words_library")).parent_path() / library.filename(), library);
  const std::string before = BuildOf(library).id;
  ASSERT_EQ(before.size(), 40U);
  std::string id;
  for (std::size_t i = 0; i < before.size(); i += 2) {
    id += static_cast<char>(std::stoi(before.substr(i, 2), nullptr, 16));
  }
  std::string bytes = other.Read("libhgros_test_relay.so");
  bytes[bytes.find(id)] = static_cast<char>(bytes[bytes.find(id)] ^ 1);
  other.Write("libhgros_test_relay.so", bytes);
  other.Write("relay.yaml", "library: libhgros_test_relay.so\ncomponents: [relay/Does]\n");
  host_.StartSshd(library.parent_path());
  const RobotFolder robot(std::string(kHosts) + kDoes);
  const auto run = host_.Run(robot);
  EXPECT_EQ(run->Wait(), 1);
  EXPECT_THAT(run->out(), AllOf(HasSubstr("The library of relay/Does is another one here: " + library.string()),
                                HasSubstr("has build id " + BuildOf(library).id +
                                          ", and where hgros run was started, "
                                          "libhgros_test_relay.so has build id " +
                                          before),
                                HasSubstr("Install the same libraries on both hosts.")))
      << run->err();
  EXPECT_THAT(run->err(), HasSubstr("The robot cannot start without \"p\"."));
}

TEST_F(HgrosRemote, SaysWhyItCannotConnect) {
  struct Case {
    std::string hosts;
    testing::Matcher<std::string> says;
  };
  const auto expect = [&](const std::vector<Case>& cases) {
    std::deque<RobotFolder> robots;
    std::vector<std::unique_ptr<CommandRun>> runs;
    for (const Case& one : cases) {
      runs.push_back(host_.Run(robots.emplace_back("hosts: {" + one.hosts + "}\n" + kDoes)));
    }
    for (std::size_t i = 0; i < cases.size(); ++i) {
      EXPECT_EQ(runs[i]->Wait(), 1);
      EXPECT_THAT(runs[i]->out(), cases[i].says) << runs[i]->err();
      EXPECT_THAT(runs[i]->err(), HasSubstr("The robot cannot start without \"p\"."));
    }
    EXPECT_TRUE(test::Await([&] { return ProcessesOn(host_.cable.left).empty(); })) << host_.Left();
  };
  expect(
      {{"base: {address: 10.198.0.2, hgros: /nowhere/hgros}",
        AllOf(HasSubstr("/nowhere/hgros"), HasSubstr("The host \"base\" has no command `/nowhere/hgros`. Install hgros "
                                                     "there, or name the command: `hosts: {base: {hgros: PATH}}`."))},
       {"base: {address: 10.198.0.2, hgros: echo Welcome to this robot; hgros}",
        HasSubstr("What has come from the host \"base\" is not from hgros.")},
       {"base: {address: 10.198.0.2, hgros: \"printf '\\\\007\\\\0\\\\0\\\\0\\\\012\\\\0050.0.9'; cat > /dev/null; "
        ":\"}",
        HasSubstr("The host \"base\" has hgros 0.0.9, and this is " HGROS_VERSION
                  ". Install the same version on both.")},
       {"base: {address: 10.198.0.2, hgros: \"false\"}", HasSubstr("`false` on the host \"base\" does not answer")},
       {"base: {address: 10.198.0.1, ssh: nobody@10.198.0.2}",
        AllOf(HasSubstr("Permission denied"), HasSubstr("`ssh nobody@10.198.0.2 hgros --version`"))}});
  host_.Trust("user_key.pub");
  expect({{"base: {address: 10.198.0.2}", HasSubstr("Host key verification failed.")}});
  ASSERT_TRUE(host_.cable.Set("down"));
  expect({{"base: {address: 10.198.0.2}", AllOf(HasSubstr("ssh: connect to host 10.198.0.2 port 22: "),
                                                HasSubstr("ssh cannot connect to the host \"base\""))}});
  ASSERT_TRUE(host_.cable.Set("up"));
  host_.StopSshd();
  expect({{"base: {address: 10.198.0.2}",
           AllOf(HasSubstr("Connection refused"),
                 HasSubstr("ssh cannot connect to the host \"base\"; its own words are above. This must work without a "
                           "question: `ssh 10.198.0.2 hgros --version`."))}});
  std::filesystem::remove(host_.folder / "bin/ssh");
  host_.path = (host_.folder / "bin").string();
  expect({{"base: {address: 10.198.0.2}",
           HasSubstr("ssh cannot be run: No such file or directory. Install the package openssh-client.")}});
}

}  // namespace
}  // namespace hgros::cli
