// Robots of two hosts that hgros run starts over ssh: real sshd, two network namespaces.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "hgros/remote/ssh_host.hpp"
#include "hgros/transport/curve_key_pair.hpp"
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

TEST(HgrosRemote, StartsProcessesAndProgramsOverSshAndBringsTheirLogBack) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) +
                          "components: {numbers: {type: relay/Numbers, params: {count: ${COUNT:-50}}},\n"
                          "             one: {type: relay/Checker, params: {count: 50}}}\n"
                          "processes: {p: {components: [numbers], host: base, env: {A: far away}}}\n"
                          "programs: {q: {host: base, env: {A: far away}, command: [sh, -c, "
                          "'echo $A; ip -o addr; exit 3']}}\n");
  const auto run = host.Run(robot);
  EXPECT_EQ(run->Wait(), 1) << "The program fails.";
  EXPECT_THAT(run->out(), AllOf(HasSubstr("numbers  It has finished: 50 numbers"), HasSubstr("q        far away"),
                                HasSubstr("one      It has finished: all 50"), HasSubstr("inet 10.198.0.2/24"),
                                HasSubstr("The process has failed: it ended with exit code 3.")))
      << run->err();
  EXPECT_TRUE(host.IsLeftClean()) << host.Left();
}

TEST(HgrosRemote, ProgramsExchangeWhatTheySay) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const std::string hgros = test::Path("hgros");
  const RobotFolder robot(std::string(kHosts) +
                          "components: {counting: {type: moving/Counting}, counter: {type: relay/Counter}}\n"
                          "programs:\n"
                          "  hears: {host: base, subscribes: [number], command: [" +
                          hgros +
                          ", echo, number, -n, 3, --field, value]}\n"
                          "  says: {host: base, publishes: [word], command: [" +
                          hgros + ", pub, word, '{value: one}', --type, foxglove.KeyValuePair, --timeout, 15]}\n");
  const auto run = host.Run(robot);
  EXPECT_TRUE(run->Prints("counts 1.")) << run->out() << run->err();
  EXPECT_TRUE(test::Await([&] {
    const std::string out = run->out();
    return std::regex_search(out, std::regex("hears +\"[0-9]+\"\n[^]*hears +\"[0-9]+\"\n[^]*hears +\"[0-9]+\"\n"));
  })) << run->out();
  run->Signal(SIGINT);
  EXPECT_EQ(run->Wait(), 128 + SIGINT) << run->out();
  EXPECT_TRUE(host.IsLeftClean()) << host.Left();
}

TEST(HgrosRemote, HostsWithKeysExchangeMessages) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const CurveKeyPair desk = GenerateCurveKeyPair();
  const CurveKeyPair base = GenerateCurveKeyPair();
  const RobotFolder robot("hosts:\n  desk: {address: 10.198.0.1, home: true, key: \"" + desk.public_key +
                          "\", secret_key_file: \"${FOLDER}/desk.key\"}\n  base: {address: 10.198.0.2, key: \"" +
                          base.public_key +
                          "\", secret_key_file: \"${FOLDER}/base.key\"}\n"
                          "discovery: {local: false}\n"
                          "components: {numbers: {type: relay/Numbers}, one: {type: relay/Checker}}\n"
                          "processes: {p: {components: [numbers], host: base}}\n");
  const auto write = [&](const std::string& name, const std::string& key) {
    std::ofstream(robot.path(name)) << key;
    std::filesystem::permissions(robot.path(name), std::filesystem::perms::owner_read);
  };
  write("desk.key", desk.secret_key);
  const auto refused = host.Run(robot);
  EXPECT_EQ(refused->Wait(), 1);
  EXPECT_THAT(refused->out(), AllOf(HasSubstr("p        error:"), HasSubstr("base.key\", which cannot be read")));
  write("base.key", base.secret_key);
  const auto run = host.Run(robot);
  EXPECT_EQ(run->Wait(), 0) << run->out() << run->err();
  EXPECT_THAT(run->out(), HasSubstr("It has finished: all 100"));
}

TEST(HgrosRemote, AComponentMovesToAnotherHostAndBack) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) +
                          "components:\n"
                          "  counting: {type: moving/Counting}\n"
                          "  passing: {type: moving/Passing, params: {bytes: 100000}}\n"
                          "  judging: {type: moving/Judging}\n"
                          "processes:\n"
                          "  near: {components: [counting, judging, passing]}\n"
                          "  far: {host: base}\n");
  const auto run = host.Run(robot);
  ASSERT_TRUE(run->Prints("far")) << run->out() << run->err();
  ASSERT_TRUE(test::Await([&] {
    const auto ps = host.OnDesk(robot, {"ps"});
    return ps->Wait() == 0 && ps->out().find("starting") == std::string::npos;
  }));
  for (const std::string to : {"base", "desk", "far", "near"}) {
    const auto move = host.OnDesk(robot, {"move", "passing", "--to", to});
    EXPECT_EQ(move->Wait(), 0) << move->err() << run->out();
  }
  std::size_t thousands = 1;
  while (run->out().find("has " + std::to_string(thousands * 1000)) != std::string::npos) ++thousands;
  EXPECT_TRUE(run->Prints("has " + std::to_string((thousands + 1) * 1000))) << run->out();
  run->Signal(SIGINT);
  EXPECT_EQ(run->Wait(), 128 + SIGINT) << run->out();
  EXPECT_THAT(run->out(), AllOf(HasSubstr("It has moved here from \"near\""), Not(HasSubstr("lost ")),
                                Not(HasSubstr("again ")), Not(HasSubstr("refused"))));
  EXPECT_TRUE(host.IsLeftClean()) << host.Left();
}

// A robot whose passing component moves between two hosts.
class MovingBetweenHosts {
 public:
  explicit MovingBetweenHosts(const SshHost& host) : host_(host) {}

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
  const RobotFolder robot_{std::string(kHosts) +
                           "components:\n"
                           "  counting: {type: moving/Counting}\n"
                           "  passing: {type: moving/Passing, checkpoint: 50ms}\n"
                           "  judging: {type: moving/Judging}\n"
                           "processes:\n"
                           "  near: {components: [counting, judging, passing], restart: on-failure}\n"
                           "  far: {host: base, restart: on-failure}\n"};
  const std::unique_ptr<CommandRun> run_ = host_.Run(robot_);
};

TEST(HgrosRemote, TriesAgainUntilAHostCanBeReached) {
  SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) +
                          "components: {does: {type: relay/Does}}\n"
                          "processes: {p: {components: [does], host: base, restart: on-failure}}\n");
  const pid_t listener = FindOn(host.cable.right, "sshd");
  const auto run = host.Run(robot);
  ASSERT_TRUE(run->Prints("does  I run.")) << run->out() << run->err();
  ASSERT_EQ(kill(listener, SIGKILL), 0);
  ASSERT_EQ(kill(FindOn(host.cable.right, "p"), SIGKILL), 0);
  ASSERT_TRUE(run->Prints("It is started again in 2000 ms.")) << run->out() << run->err();
  host.StartSshd();
  EXPECT_TRUE(test::Await([&] {
    const std::string out = run->out();
    const std::size_t first = out.find("does  I run.");
    return out.find("does  I run.", first + 1) != std::string::npos;
  })) << run->out()
      << run->err();
  run->Signal(SIGINT);
  EXPECT_EQ(run->Wait(), 128 + SIGINT) << run->out() << run->err();
}

// A process that the test kills or stops during a move.
struct Victim {
  std::string space;
  std::string name;
};

// More rounds: HGROS_MOVE_ROUNDS=200.
TEST(HgrosRemote, WhoeverIsKilledOrStoppedInAMoveOnePlaceRunsIt) {
  constexpr int kRoundsOfARobot = 4;  // A process that is killed more often is not started again.
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const std::string& desk = host.cable.left;
  const std::string& base = host.cable.right;
  const std::vector<Victim> victims{{desk, "ssh"}, {base, "sshd"}, {base, "hgros"}, {base, "far"},
                                    {desk, "far"}, {desk, "near"}, {desk, "hgros"}};
  const char* wanted = std::getenv("HGROS_MOVE_ROUNDS");
  std::mt19937 random(test::Seed());
  const pid_t listener = FindOn(base, "sshd");
  int left = wanted == nullptr ? 2 * kRoundsOfARobot : std::stoi(wanted);
  while (left > 0 && !testing::Test::HasFailure()) {
    const MovingBetweenHosts robot(host);
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
    EXPECT_TRUE(host.IsLeftClean()) << host.Left();
  }
}

std::string HashesIn(const std::string& out) {
  std::smatch found;
  return std::regex_search(out, found, std::regex("hashes +map [0-9a-f]{16}, trajectory [0-9a-f]{16}")) ? found.str()
                                                                                                        : out;
}

// The paper's first use case: a node of the demo moves to another host and back, during operation.
TEST(HgrosRemote, AMapperThatMovesBetweenHostsDrawsTheSameMap) {
  const SshHost host(std::map<std::string, std::string>{{"HGROS_COMPONENT_PATH", test::Path("slam2d_manifests")}});
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const std::string include = "include: " + test::Path("slam2d") + "/slam2d.yaml\n";
  const RobotFolder alone(include, test::Path("slam2d_manifests"));
  const RobotFolder robot(include + kHosts +
                              "processes:\n"
                              "  front: {components: [source, matcher, writer], essential: true}\n"
                              "  back: {host: base, components: [mapper], essential: true}\n",
                          test::Path("slam2d_manifests"));
  const std::vector<std::string> scans{"--set", "source.params.scans=60"};
  const auto out = [](const RobotFolder& folder) {
    return std::vector<std::string>{"--set", "writer.params.out=" + folder.path("out").string()};
  };
  std::vector<std::string> words = robot.Arguments(scans);
  for (const std::string& word : out(robot)) words.push_back(word);
  words.insert(words.end(), {"--set", "source.params.rate=5"});
  const auto run = host.OnDesk(robot, words);
  ASSERT_TRUE(test::Await([&] {
    const auto ps = host.OnDesk(robot, {"ps"});
    return ps->Wait() == 0 && std::regex_search(ps->out(), std::regex(R"(mapper [^\n]* running)"));
  })) << run->out()
      << run->err();
  for (const std::string to : {"desk", "base", "front"}) {
    const auto move = host.OnDesk(robot, {"move", "mapper", "--to", to});
    ASSERT_EQ(move->Wait(), 0) << move->err() << run->out();
  }
  EXPECT_EQ(run->Wait(), 0) << run->out() << run->err();
  words = scans;
  for (const std::string& word : out(alone)) words.push_back(word);
  const CommandEnd reference = alone.Run(words);
  ASSERT_EQ(reference.status, 0) << reference.out << reference.err;
  EXPECT_EQ(HashesIn(run->out()), HashesIn(reference.out));
}

TEST(HgrosRemote, CtrlCEndsTheOtherHostsProcessesInOrder) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) + kDoes +
                          "programs: {q: {host: base, command: [sh, -c, 'echo up; sleep 100d']}}\n");
  const auto run = host.Run(robot);
  ASSERT_TRUE(run->Prints("does  I run.")) << run->out() << run->err();
  ASSERT_TRUE(run->Prints("q     up"));
  run->Signal(SIGINT);
  EXPECT_EQ(run->Wait(), 128 + SIGINT);
  EXPECT_THAT(run->out(), AllOf(HasSubstr("does  I end."), Not(HasSubstr("killed")), Not(HasSubstr("failed"))));
  EXPECT_TRUE(host.IsLeftClean()) << host.Left();
}

TEST(HgrosRemote, NothingIsLeftWhenAnyPartIsKilled) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) +
                          "components: {does: {type: relay/Does, params: {what: hang at end}}}\n"
                          "processes: {p: {components: [does], host: base}}\n");
  const auto& desk = host.cable.left;
  const auto& base = host.cable.right;
  struct Kill {
    std::string space;
    std::string name;
    std::string says;
  };
  for (const Kill& one : {Kill{desk, "hgros", ""}, Kill{desk, "p", "it was ended by SIGKILL"},
                          Kill{desk, "ssh", "The connection to the host \"base\" is lost: ssh has failed"},
                          Kill{base, "p", "The process has failed: it was ended by SIGKILL."},
                          Kill{base, "hgros", "The connection to the host \"base\" is lost."}}) {
    const auto run = host.Run(robot);
    ASSERT_TRUE(run->Prints("does  I run.")) << run->out() << run->err();
    ASSERT_EQ(kill(FindOn(one.space, one.name), SIGKILL), 0) << one.name;
    EXPECT_EQ(run->Wait(), one.says.empty() ? 128 + SIGKILL : 1);
    EXPECT_THAT(run->out(), HasSubstr(one.says)) << run->err();
    EXPECT_TRUE(host.IsLeftClean()) << one.name << "\n" << host.Left();
  }
}

TEST(HgrosRemote, NothingIsLeftWheneverItEnds) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) + kDoes + "programs: {q: {host: base, command: [sleep, 100d]}}\n");
  std::mt19937 random(test::Seed());
  for (int round = 0; round < 12; ++round) {
    const auto run = host.Run(robot);
    const int after_ms = std::uniform_int_distribution(0, 1000)(random);
    test::Linger(std::chrono::milliseconds(after_ms));
    const int number = round % 2 == 0 ? SIGINT : SIGKILL;
    run->Signal(number);
    EXPECT_EQ(run->Wait(), 128 + number) << after_ms << " ms\n" << run->out() << run->err();
    EXPECT_TRUE(host.IsLeftClean()) << after_ms << " ms\n" << host.Left();
  }
}

TEST(HgrosRemote, ADeadNetworkEndsBothSides) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) + kDoes);
  const auto run = host.Run(robot);
  ASSERT_TRUE(run->Prints("does  I run.")) << run->out() << run->err();
  ASSERT_TRUE(host.cable.Set("down"));
  EXPECT_EQ(run->Wait(), 1);
  EXPECT_THAT(run->out(), HasSubstr("The connection to the host \"base\" is lost."));
  EXPECT_TRUE(test::Await([&] { return FindOn(host.cable.right, "p") == 0; })) << host.Left();
  EXPECT_TRUE(test::Await([&] { return FindOn(host.cable.right, "hgros") == 0; })) << host.Left();
}

TEST(HgrosRemote, AStoppedStarterDoesNotStopTheRobot) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) + kDoes);
  const auto run = host.Run(robot);
  ASSERT_TRUE(run->Prints("does  I run.")) << run->out() << run->err();
  run->Signal(SIGSTOP);
  test::Linger(std::chrono::seconds(9));  // Longer than the other end waits for a sign of life.
  EXPECT_NE(FindOn(host.cable.right, "p"), 0);
  run->Signal(SIGCONT);
  run->Signal(SIGINT);
  EXPECT_EQ(run->Wait(), 128 + SIGINT);
  EXPECT_THAT(run->out(), HasSubstr("does  I end."));
}

TEST(HgrosRemote, AProcessGoesOnFromItsCheckpoint) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(
      "hosts: {desk: {address: 10.198.0.1, home: true}, base: {address: 10.198.0.2}}\n"
      "components: {counter: {type: relay/Counter, checkpoint: 1h, params: {step: 3}}}\n"
      "processes: {p: {components: [counter], host: base, restart: on-failure}}\n");
  const auto run = host.Run(robot);
  ASSERT_TRUE(run->Prints("begins at 0.")) << run->out() << run->err();
  const auto say_word = [&] {
    CommandRun pub(
        {"netns", "exec", host.cable.right, test::Path("hgros"), "pub", "word", "{value: a}", "--timeout", "30"},
        robot.environment(), -1, "/sbin/ip");
    EXPECT_EQ(pub.Wait(), 0) << pub.err();
  };
  say_word();
  ASSERT_TRUE(run->Prints("counts 3."));
  const auto ps = host.OnDesk(robot, {"ps"});
  EXPECT_EQ(ps->Wait(), 0);
  EXPECT_THAT(ps->out(), HasSubstr("relay/Counter  p on base"));
  const auto restart = host.OnDesk(robot, {"restart", "counter"});
  EXPECT_EQ(restart->Wait(), 0) << restart->err();
  EXPECT_TRUE(run->Prints("begins at 3."));
  // The same when only the connection ends.
  ASSERT_EQ(kill(FindOn(host.cable.left, "ssh"), SIGKILL), 0);
  EXPECT_TRUE(run->Prints("It is started again."));
  EXPECT_TRUE(test::Await([&] {
    const std::string out = run->out();
    return out.find("begins at 3.", out.find("It is started again.")) != std::string::npos;
  })) << run->out();
  say_word();
  EXPECT_TRUE(run->Prints("counts 6.")) << run->out();
  run->Signal(SIGINT);
  EXPECT_EQ(run->Wait(), 128 + SIGINT);
}

TEST(HgrosRemote, WhatHasLostItsConnectionHasEndedBeforeItIsStartedAgain) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) +
                          "components: {does: {type: relay/Does, params: {what: hang at end}}}\n"
                          "processes: {p: {components: [does], host: base, restart: on-failure}}\n");
  for (const char* killed : {"ssh", "p"}) {  // p is the relay here.
    const auto run = host.Run(robot);
    ASSERT_TRUE(run->Prints("does  I run.")) << run->out() << run->err();
    const pid_t before = FindOn(host.cable.right, "p");
    ASSERT_GT(before, 0);
    ASSERT_EQ(kill(FindOn(host.cable.left, killed), SIGKILL), 0);
    EXPECT_TRUE(run->Prints("It is started again."));
    EXPECT_FALSE(Runs(before)) << killed;
    EXPECT_TRUE(test::Await([&] { return FindOn(host.cable.right, "p") > 0; })) << run->out();
    run->Signal(SIGINT);
    EXPECT_EQ(run->Wait(), 128 + SIGINT);
    EXPECT_TRUE(host.IsLeftClean()) << host.Left();
  }
}

TEST(HgrosRemote, WhatHangsAtItsEndIsRestartedThere) {
  const SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) +
                          "components: {does: {type: relay/Does, params: {what: hang at end}}}\n"
                          "processes: {p: {components: [does], host: base}}\n");
  const auto run = host.Run(robot);
  ASSERT_TRUE(run->Prints("does  I run.")) << run->out() << run->err();
  const auto restart = host.OnDesk(robot, {"restart", "p"});
  EXPECT_EQ(restart->Wait(), 0) << restart->err();
  run->Signal(SIGINT);
  EXPECT_EQ(run->Wait(), 128 + SIGINT);
}

TEST(HgrosRemote, SaysWhichLibraryDiffers) {
  const RobotFolder other("");
  const std::filesystem::path library = other.path("libhgros_test_relay.so");
  std::filesystem::copy(std::filesystem::path(test::Path("words_library")).parent_path() / library.filename(), library);
  const std::string before = BuildOf(library).id;
  ASSERT_EQ(before.size(), 40U);
  {
    std::ifstream in(library, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), {});
    std::string id;
    for (std::size_t i = 0; i < before.size(); i += 2)
      id += static_cast<char>(std::stoi(before.substr(i, 2), nullptr, 16));
    bytes[bytes.find(id)] = static_cast<char>(bytes[bytes.find(id)] ^ 1);
    std::ofstream(library, std::ios::binary) << bytes;
  }
  std::ofstream(other.path("relay.yaml")) << "library: libhgros_test_relay.so\ncomponents: [relay/Does]\n";
  const SshHost host({{"HGROS_COMPONENT_PATH", library.parent_path()}});
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const RobotFolder robot(std::string(kHosts) + kDoes);
  const auto run = host.Run(robot);
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

TEST(HgrosRemote, SaysWhyItCannotConnect) {
  SshHost host;
  if (!host.missing.empty()) GTEST_SKIP() << host.missing;
  const auto says = [&](const std::string& hosts, const auto& matcher) {
    const RobotFolder robot("hosts: {" + hosts + "}\n" + kDoes);
    const auto run = host.Run(robot);
    EXPECT_EQ(run->Wait(), 1);
    EXPECT_THAT(run->out(), matcher) << run->err();
    EXPECT_THAT(run->err(), HasSubstr("The robot cannot start without \"p\"."));
    EXPECT_TRUE(test::Await([&] { return ProcessesOn(host.cable.left).empty(); })) << host.Left();
  };
  says("base: {address: 10.198.0.2, hgros: /nowhere/hgros}",
       AllOf(HasSubstr("/nowhere/hgros"), HasSubstr("The host \"base\" has no command `/nowhere/hgros`. Install hgros "
                                                    "there, or name the command: `hosts: {base: {hgros: PATH}}`.")));
  says("base: {address: 10.198.0.2, hgros: echo Welcome to this robot; hgros}",
       HasSubstr("What has come from the host \"base\" is not from hgros."));
  says(
      "base: {address: 10.198.0.2, hgros: \"printf '\\\\007\\\\0\\\\0\\\\0\\\\012\\\\0050.0.9'; cat > /dev/null; :\"}",
      HasSubstr("The host \"base\" has hgros 0.0.9, and this is " HGROS_VERSION ". Install the same version on both."));
  says("base: {address: 10.198.0.2, hgros: \"false\"}", HasSubstr("`false` on the host \"base\" does not answer"));
  says("base: {address: 10.198.0.1, ssh: nobody@10.198.0.2}",
       AllOf(HasSubstr("Permission denied"), HasSubstr("`ssh nobody@10.198.0.2 hgros --version`")));
  host.Trust("user_key.pub");
  says("base: {address: 10.198.0.2}", HasSubstr("Host key verification failed."));
  ASSERT_TRUE(host.cable.Set("down"));
  says("base: {address: 10.198.0.2}", AllOf(HasSubstr("ssh: connect to host 10.198.0.2 port 22: "),
                                            HasSubstr("ssh cannot connect to the host \"base\"")));
  ASSERT_TRUE(host.cable.Set("up"));
  host.StopSshd();
  says("base: {address: 10.198.0.2}",
       AllOf(HasSubstr("Connection refused"),
             HasSubstr("ssh cannot connect to the host \"base\"; its own words are above. This must work without a "
                       "question: `ssh 10.198.0.2 hgros --version`.")));
  std::filesystem::remove(host.folder / "bin/ssh");
  host.path = (host.folder / "bin").string();
  says("base: {address: 10.198.0.2}",
       HasSubstr("ssh cannot be run: No such file or directory. Install the package openssh-client."));
}

}  // namespace
}  // namespace hgros::cli
