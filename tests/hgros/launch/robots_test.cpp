// The commands for robots that hgros run has started: ps, logs, restart, stop and wait.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "processes/message_stream.hpp"
#include "support/await.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kTwo =
    "components: {a: {type: relay/Does}, b: {type: relay/Does, params: {what: finish}}}\n"
    "processes: {p: {components: [a]}}\n"
    "programs: {sleeps: {command: [sleep, 100]}}\n";

// A robot that was started in the background. Ends it.
class DetachedRobot : public RobotFolder {
 public:
  explicit DetachedRobot(const std::string& text) : RobotFolder(text) {
    const CommandEnd end = Run({"--detach"});
    EXPECT_EQ(end.status, 0) << end.out << end.err;
    started_ = end.out;
  }
  ~DetachedRobot() { (void)Ask({"stop"}); }

  [[nodiscard]] const std::string& started() const noexcept { return started_; }

 private:
  std::string started_;
};

TEST(HgrosRobots, PsTellsHowAProcessHasEnded) {
  const DetachedRobot robot(
      "components: {a: {type: relay/Does}, b: {type: relay/Does}}\nprocesses: {p: {components: [a]}}\n"
      "programs: {ends: {command: [sh, -c, 'exit 3']}, done: {command: [\"true\"]}}\n");
  ASSERT_EQ(kill(PidsIn(robot.started()).at(0), SIGKILL), 0);
  const auto shows = [](const std::string& name, const std::string& state) {
    return ContainsRegex("\"" + name + "\"[^\n]*\"state\":\"" + state + "\"");
  };
  robot.AskUntil(
      {"ps", "--json"},
      Prints(AllOf(shows("component\":\"a", "ended by SIGKILL"), shows("process\":\"ends", "ended with code 3"),
                   shows("process\":\"done", "ended"), shows("component\":\"b", "running"))));
}

TEST(HgrosRobots, ADetachedRobotIsListedAndStoppedAlsoBesideAnother) {
  const DetachedRobot robot(kTwo);
  EXPECT_THAT(robot.started(), HasSubstr("COMPONENT"));
  const std::vector<pid_t> pids = PidsIn(robot.started());
  ASSERT_EQ(pids.size(), 3U);
  robot.AskUntil({"ps"}, Prints(0, AllOf(HasSubstr("ROBOT  COMPONENT  TYPE"), HasSubstr("finished"),
                                         ContainsRegex("robot  a +relay/Does +p +[0-9]+  running"),
                                         ContainsRegex("robot +sleep 100 +sleeps +[0-9]+  running"))));
  EXPECT_THAT(robot.Ask({"ps", "--json"}).out,
              HasSubstr("\"robot\":\"robot\",\"component\":\"a\",\"type\":\"relay/Does\""));
  EXPECT_THAT(robot.Run(), Ends(1, HasSubstr("A robot \"robot\" is running already. End it with `hgros stop robot`")));
  EXPECT_EQ(robot.Run({"--detach", "--name", "other"}).status, 0);
  EXPECT_THAT(robot.Ask({"stop"}).err, HasSubstr("Several robots run: other, robot. Name one"));
  EXPECT_THAT(robot.Ask({"stop", "othr"}).err, HasSubstr("Did you mean \"other\"?"));
  EXPECT_EQ(robot.Ask({"stop", "other"}).status, 0);
  EXPECT_THAT(robot.Run({"--name", "a/b"}).err, HasSubstr("cannot be the name of a robot"));
  EXPECT_EQ(robot.Ask({"stop"}).status, 0);
  for (const pid_t pid : pids) EXPECT_FALSE(Runs(pid));
  EXPECT_EQ(robot.Ask({"ps"}).out, "");
  for (const std::string& domain : std::vector<std::string>{"a b", "..", std::string(300, 'x'), "a/b"}) {
    EXPECT_THAT(RunToEnd({"ps"}, {{"HGROS_DOMAIN", domain}}), Ends(1, HasSubstr("HGROS_DOMAIN sets it"))) << domain;
  }
  EXPECT_THAT(robot.Ask({"stop"}).err,
              HasSubstr("The robot \"robot\" has ended. `hgros logs --robot robot` shows why"));
  EXPECT_THAT(RunToEnd({"stop"}, OwnDomain()).err, HasSubstr("No robot was started here by this user in the domain"));
}

TEST(HgrosRobots, WithoutAHomeThereIsNoReportAndNoOtherFileIsTouched) {
  const test::ScratchFolder folder;
  folder.Write("robot.yaml", "programs: {done: {command: [\"true\"]}}\n");
  folder.Write(".new", "ours");
  EXPECT_THAT(RunInShell("cd $FOLDER && unset HOME XDG_STATE_HOME && $HGROS run robot.yaml && cat .new",
                         {{"FOLDER", folder.path()}}),
              Writes(HasSubstr("ours")));
}

TEST(HgrosRobots, ADetachedRobotThatDiesLeavesItsReportUntilItsNextStart) {
  const DetachedRobot robot("components: {a: {type: relay/Does}}\n");
  ASSERT_EQ(kill(PidsIn(robot.started()).at(0), SIGKILL), 0);
  robot.AskUntil({"ps"}, Ends(0, HasSubstr("`hgros ps --all` lists")));
  EXPECT_THAT(robot.Ask({"wait"}), Ends(1, HasSubstr("main: ended by SIGKILL")));
  const CommandEnd logs = robot.Ask({"logs", "main", "-f"});
  EXPECT_THAT(logs, Ends(0, HasSubstr("The robot \"robot\" ended on 20")));
  EXPECT_THAT(logs.out, AllOf(HasSubstr("I run."), HasSubstr("The process has failed: it was ended by SIGKILL.")));
  EXPECT_THAT(robot.Ask({"logs", "b"}).err, HasSubstr("no component, process or program \"b\""));
  EXPECT_THAT(robot.Ask({"ps", "--all"}).out, ContainsRegex("robot  a +relay/Does +main +-? +ended by SIGKILL"));
  EXPECT_EQ(robot.Run({"--detach"}).status, 0);
  EXPECT_THAT(robot.Ask({"logs"}).out, Not(HasSubstr("SIGKILL")));
  EXPECT_EQ(robot.Ask({"stop"}).status, 0);
  EXPECT_THAT(robot.Ask({"wait"}), Ends(0, HasSubstr("main: ended\n")));
}

TEST(HgrosRobots, ADetachedRobotRunsWhenItsCommandReturns) {
  const DetachedRobot robot("components: {a: {type: relay/Does, params: {what: run late}}}\n");
  EXPECT_THAT(robot.Ask({"ps"}).out, ContainsRegex("robot  a +relay/Does +main +[0-9]+  running"));
}

TEST(HgrosRobots, ShowsAndFollowsTheLogWhichMayHaveAnyBytes) {
  const DetachedRobot robot(
      "components: {a: {type: relay/Does, params: {what: log bytes}}, b: {type: relay/Does}}\n"
      "programs: {says: {command: [sh, -c, 'echo one; sleep 0.3; printf \"a\\377b\\000c\\n\"; echo two; sleep "
      "100']}}\n");
  CommandRun follows({"logs", "-f"}, robot.environment());
  for (const char* line : {"one", "two", "a             I run.", "b             I run.", "after it"}) {
    EXPECT_TRUE(follows.Prints(line)) << follows.out();
  }
  EXPECT_THAT(robot.Ask({"logs"}), Writes(AllOf(HasSubstr("a\\xffb\\x00c"), HasSubstr("\\xfe\\xff is no text"))));
  EXPECT_THAT(robot.Ask({"logs", "--json"}).out, HasSubstr("a\\uFFFDb\\u0000c"));
  EXPECT_THAT(robot.Ask({"logs", "a"}).out, AllOf(HasSubstr("I run."), Not(HasSubstr("one"))));
  EXPECT_THAT(robot.Ask({"logs", "says", "--json"}).out, HasSubstr("\"process\":\"says\""));
  EXPECT_THAT(robot.Ask({"logs", "nothing"}).err, HasSubstr("no component, process or program \"nothing\""));
  EXPECT_EQ(robot.Ask({"stop"}).status, 0);
  EXPECT_EQ(follows.Wait(), 0);
  EXPECT_THAT(follows.out(), HasSubstr("I end."));
}

TEST(HgrosRobots, RestartsProcessesAndPrograms) {
  const DetachedRobot robot(kTwo);
  const std::vector<pid_t> before = PidsIn(robot.started());
  ASSERT_EQ(before.size(), 3U);
  for (const char* name : {"p", "sleeps"}) {
    EXPECT_THAT(robot.Ask({"restart", name}), Ends(0)) << name;
  }
  EXPECT_FALSE(Runs(before[0]));
  EXPECT_FALSE(Runs(before[2]));
  EXPECT_THAT(robot.Ask({"ps"}).out, AllOf(ContainsRegex("a +relay/Does +p +[0-9]+  running +1"),
                                           ContainsRegex("sleeps +[0-9]+  running +1")));
  EXPECT_THAT(robot.Ask({"restart", "c"}).err, HasSubstr("no component, process or program \"c\""));
  EXPECT_THAT(robot.Ask({"restart", "sleps"}).err, HasSubstr("Did you mean \"sleeps\"?"));
}

TEST(HgrosRobots, RestartsNothingWhileTheRobotStarts) {
  const RobotFolder folder(
      "components: {a: {type: relay/Does}, b: {type: relay/Does}}\n"
      "processes: {p: {components: [a]}, q: {components: [b], env: {RELAY_DOOR: \"${FOLDER}/door\"}}}\n");
  ASSERT_EQ(mkfifo(folder.path("door").c_str(), 0600), 0);
  CommandRun run(folder.Arguments(), folder.environment());
  ASSERT_TRUE(test::Await([&] { return folder.Ask({"ps"}).out.find("starting") != std::string::npos; }));
  for (const char* name : {"a", "b", "p"}) {
    EXPECT_THAT(folder.Ask({"restart", name}).err, HasSubstr("The robot still starts, or ends already."));
  }
  std::ofstream(folder.path("door")).close();
  ASSERT_TRUE(run.Prints("b  I run.")) << run.out();
  ASSERT_TRUE(test::Await([&] { return folder.Ask({"restart", "a"}).status == 0; }));
  run.End();
}

TEST(HgrosRobots, RestartsAComponentAloneInItsProcess) {
  const DetachedRobot robot(
      "components: {a: {type: relay/Does}, b: {type: relay/Does}, c: {type: relay/Does, params: {what: fail}}}\n");
  const std::vector<pid_t> before = PidsIn(robot.started());
  // One that has not started yet would start again with its process.
  ASSERT_TRUE(test::Await([&] { return robot.Ask({"ps"}).out.find("starting") == std::string::npos; }));
  for (const char* name : {"a", "a", "b"}) {
    EXPECT_THAT(robot.Ask({"restart", name}), Ends(0)) << name;
  }
  EXPECT_THAT(before, testing::Each(testing::ResultOf(Runs, true)));
  const auto times = [&](const std::string& name, const std::string& what) {
    return Times(robot.Ask({"logs", name}).out, what);
  };
  EXPECT_EQ(times("a", "I run."), 3U);
  EXPECT_EQ(times("a", "I end."), 2U);
  EXPECT_EQ(times("b", "I run."), 2U);
  const std::string failed = "It has failed: the laser is broken";
  ASSERT_TRUE(test::Await([&] { return times("c", failed) > 0; }));
  const std::size_t once = times("c", failed);
  const CommandEnd again = robot.Ask({"restart", "c"});  // It fails later, but perhaps before the starter looks.
  EXPECT_TRUE(again.status == 0 || again.err.find("has ended again") != std::string::npos) << again.err;
  EXPECT_TRUE(test::Await([&] { return times("c", failed) == 2 * once; }));
  EXPECT_THAT(robot.Ask({"ps"}).out, ContainsRegex("c +relay/Does +main +[0-9]+  failed"));
}

TEST(HgrosRobots, WaitsForTheEndAndItsCode) {
  RunningRobot robot("components: {a: {type: relay/Does, params: {what: fail}}, b: {type: relay/Does}}\n");
  ASSERT_TRUE(robot.Prints("It has failed"));
  CommandRun waits({"wait"}, robot.environment());
  EXPECT_EQ(waits.Wait(std::chrono::milliseconds(200)), -1);
  robot.Signal(SIGTERM);
  EXPECT_EQ(waits.Wait(), 1);
  EXPECT_EQ(robot.Wait(), 128 + SIGTERM);
}

TEST(HgrosRobots, ADetachedRobotThatCannotStartSaysWhy) {
  const RobotFolder folder(
      "components: {a: {type: relay/Does}}\nprograms: {x: {command: [sh, -c, exit 3], essential: true}}\n"
      "processes: {p: {components: [a], nice: 5}}\ndiscovery: {local: false}\n");
  EXPECT_THAT(folder.Run({"--detach", "--set", "a.type=relay/None"}),
              Ends(1, HasSubstr("There is no component type \"relay/None\"")));
}

TEST(HgrosRobots, ARobotCanBeStartedWithoutStandardStreams) {
  const RobotFolder folder(kTwo);
  EXPECT_EQ(RunInShell("\"$HGROS\" run -d " + folder.file() + " <&- >&- 2>&-", folder.environment()).status, 0);
  EXPECT_THAT(folder.Ask({"ps"}).out, HasSubstr("relay/Does"));
  EXPECT_EQ(folder.Ask({"stop"}).status, 0);
}

TEST(HgrosRobots, AReaderThatDoesNotReadHoldsUpNobody) {
  const RobotFolder folder("components: {a: {type: relay/Does}}\nprograms: {p: {command: [yes, again and again]}}\n");
  std::array<int, 2> pipe{};
  ASSERT_EQ(pipe2(pipe.data(), O_CLOEXEC), 0);
  CommandRun run(folder.Arguments(), folder.environment(), pipe[1]);
  const auto ask = [&folder](const std::string& what) { return folder.Ask({what}); };
  ASSERT_TRUE(test::Await([&] { return ask("logs").out.find("and again") != std::string::npos; }));
  EXPECT_THAT(ask("ps").out, HasSubstr("yes again and again"));
  EXPECT_EQ(ask("stop").status, 0);
  EXPECT_EQ(run.Wait(), 0);
  EXPECT_THAT(run.err(), ContainsRegex("[0-9]+ lines were not written, because nobody read the output."));
  close(pipe[0]);
  close(pipe[1]);
}

TEST(HgrosRobots, AProgramThatPrintsWithoutEndHoldsUpNobodyButAFollowerSaysWhatIsMissing) {
  const DetachedRobot robot("components: {a: {type: relay/Does}}\nprograms: {p: {command: [yes, again and again" +
                            std::string(1000, '.') + "]}}\n");
  CommandRun follows({"logs", "-f", "p"}, robot.environment());
  ASSERT_TRUE(follows.Prints("again and again"));
  // Until `yes` has printed far more than waits for the command.
  EXPECT_TRUE(test::Await([&, time = std::chrono::milliseconds(50)]() mutable {
    follows.Signal(SIGSTOP);
    test::Linger(time *= 2);
    follows.Signal(SIGCONT);
    return follows.Prints(" lines were left out here, because nobody read the output.", time);
  }));
  follows.End();
  EXPECT_THAT(robot.Ask({"logs", "p"}).out, HasSubstr("and again"));
  EXPECT_THAT(robot.Ask({"ps"}).out, HasSubstr("yes again and again"));
  EXPECT_EQ(robot.Ask({"stop"}).status, 0);
}

TEST(HgrosRobots, CommandsNameARobotThatDoesNotAnswer) {
  const RobotFolder folder(kTwo);
  CommandRun run(folder.Arguments(), folder.environment());
  ASSERT_TRUE(run.Prints("a       I run."));
  run.Signal(SIGSTOP);
  const CommandEnd end = RunInShell(
      "for command in ps logs 'logs -f' stop 'restart a' 'move a --to p'; do\n"
      "  (timeout 30 $HGROS $command > /dev/null; echo $?) &\n"
      "done; wait",
      folder.environment());
  run.Signal(SIGCONT);
  EXPECT_EQ(end.out, "3\n3\n3\n3\n3\n3\n");
  EXPECT_THAT(end.err, HasSubstr("The robot \"robot\" does not answer: its hgros run is stopped"));
}

// Where the starter of a robot listens.
std::pair<sockaddr_un, socklen_t> AddressOf(const std::string& domain) {
  const std::string name = "hgros-run/" + std::to_string(getuid()) + "/" + domain + "/robot";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, name.data(), name.size());
  return {address, static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size())};
}

// A connection to it; none if it cannot be made.
std::unique_ptr<MessageStream> Connect(const std::string& domain, int flags = 0) {
  auto stream = std::make_unique<MessageStream>(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | flags, 0));
  const auto [address, size] = AddressOf(domain);
  if (connect(stream->descriptor(), reinterpret_cast<const sockaddr*>(&address), size) != 0) stream.reset();
  return stream;
}

// Another user who has taken the name of the robot.
class Squatter {
 public:
  explicit Squatter(const std::string& domain) {
    std::array<int, 2> ends{};
    EXPECT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
    const auto [address, size] = AddressOf(domain);
    pid_ = fork();
    if (pid_ == 0) {
      constexpr uid_t kNobody = 65534;
      const int taken = socket(AF_UNIX, SOCK_STREAM, 0);
      const bool done = setuid(kNobody) == 0 && bind(taken, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                        listen(taken, 1) == 0;
      (void)!write(ends[1], done ? "y" : "n", 1);
      while (true) (void)pause();
    }
    char done = 0;
    EXPECT_EQ(read(ends[0], &done, 1), 1);
    EXPECT_EQ(done, 'y');
    close(ends[0]);
    close(ends[1]);
  }
  ~Squatter() {
    (void)kill(pid_, SIGKILL);
    (void)waitpid(pid_, nullptr, 0);
  }
  Squatter(const Squatter&) = delete;
  Squatter& operator=(const Squatter&) = delete;

 private:
  pid_t pid_ = -1;
};

TEST(HgrosRobots, AnotherUserCannotPassForARobot) {
  if (getuid() != 0) GTEST_SKIP() << "Only root can act as another user.";
  const RobotFolder folder(kTwo);
  const Squatter squatter(folder.domain());
  EXPECT_THAT(folder.Run().err, HasSubstr("Another user of this host has taken the name of the robot \"robot\"."));
  EXPECT_EQ(folder.Run({"--detach", "--name", "mine"}).status, 0);
  std::vector<std::unique_ptr<MessageStream>> waiting;  // It never accepts.
  do {
    waiting.push_back(Connect(folder.domain(), SOCK_NONBLOCK));
  } while (waiting.back() != nullptr && waiting.size() < 100);
  EXPECT_THAT(folder.Ask({"ps"}).out, HasSubstr("relay/Does"));
  EXPECT_EQ(folder.Ask({"stop"}).status, 0) << "It is the only one.";
}

TEST(HgrosRobots, SurvivesCommandsThatLieAndSaysThatItServesNoMore) {
  const DetachedRobot robot(kTwo);
  std::vector<std::unique_ptr<MessageStream>> clients;
  for (const std::string& bytes : {std::string("\x05\0\0\0\xff\xff\xff\xff\xff", 9), std::string("\xff\xff\xff\xff"),
                                   std::string("\x10"), std::string(400, '\0')}) {
    clients.push_back(Connect(robot.domain()));
    ASSERT_NE(clients.back(), nullptr);
    (void)send(clients.back()->descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  EXPECT_THAT(robot.Ask({"ps"}).out, HasSubstr("relay/Does"));
  clients.push_back(Connect(robot.domain()));  // And says nothing.
  ASSERT_NE(clients.back(), nullptr);
  EXPECT_EQ(robot.Ask({"restart", "a"}).status, 0);
  clients.clear();
  while (clients.size() < 64) {
    clients.push_back(Connect(robot.domain()));
    ASSERT_NE(clients.back(), nullptr);
    if (clients.size() % 16 != 0 || clients.size() == 64) continue;
    EXPECT_EQ(robot.Ask({"ps"}).status, 0);  // All are accepted by then.
  }
  for (const char* command : {"ps", "logs", "wait", "stop"}) {
    EXPECT_THAT(robot.Ask({command}),
                Ends(1, HasSubstr("The robot \"robot\" serves 64 commands, and no more. End some, such as")))
        << command;
  }
  clients.clear();
  EXPECT_TRUE(test::Await([&] { return robot.Ask({"stop"}).status == 0; })) << "Those that leave make room.";
}

TEST(HgrosRobots, SleepsAndSaysWhenItCanOpenNoMoreFiles) {
  const RobotFolder folder("components: {a: {type: relay/Does}}\n");
  const CommandEnd end = RunInShell(
      "$HGROS run $FOLDER/robot.yaml > /dev/null & run=$!\n"
      "for i in $(seq 200); do $HGROS ps 2>&1 | grep -q running && break; sleep 0.1; done\n"
      "prlimit --pid $run --nofile=$(($(ls /proc/$run/fd | wc -l) + 3))\n"
      "for i in $(seq 24); do $HGROS wait > /dev/null 2>&1 & waits=\"$waits $!\"; done\n"
      "for i in $(seq 200); do $HGROS ps 2>&1 | grep 'no more files' >&2 && break; sleep 0.1; done\n"
      "set -- $(cut -d')' -f2 < /proc/$run/stat); before=$((${12} + ${13}))\n"
      "sleep 1\n"
      "set -- $(cut -d')' -f2 < /proc/$run/stat); echo ticks=$((${12} + ${13} - before))\n"
      "kill $waits $run 2> /dev/null; wait $run",
      folder.environment());
  EXPECT_THAT(end.err, HasSubstr("The robot \"robot\" can open no more files. Raise the limit of its hgros run"));
  EXPECT_THAT(end.out, ContainsRegex("ticks=[0-9]?[0-9]?\n")) << "It does not spin: a second has 100.";
}

}  // namespace
}  // namespace hgros::cli
