// A process of a robot as a service: without a starter.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "support/await.hpp"
#include "support/path.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

// The socket of a service manager.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path) : path_(path), socket_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    std::strncpy(at.sun_path, path.c_str(), sizeof at.sun_path - 1);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  ~NotifySocket() { close(socket_); }

  [[nodiscard]] std::map<std::string, std::string> EnvironmentOf(const RobotFolder& robot) const {
    std::map<std::string, std::string> environment = robot.environment();
    environment["NOTIFY_SOCKET"] = path_;
    environment["WATCHDOG_USEC"] = "20000";
    return environment;
  }
  // All so far.
  [[nodiscard]] const std::vector<std::string>& notices() {
    std::array<char, 4096> buffer{};
    for (;;) {
      const ssize_t size = recv(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (size < 0) return notices_;
      notices_.emplace_back(buffer.data(), static_cast<std::size_t>(size));
    }
  }
  [[nodiscard]] bool Hears(const std::string& notice, std::ptrdiff_t times = 1) {
    return test::Await([&] { return std::ranges::count(notices(), notice) >= times; });
  }

 private:
  const std::string path_;
  const int socket_;
  std::vector<std::string> notices_;
};

CommandEnd RunProcess(const RobotFolder& robot, const std::string& process) {
  return robot.Run({"--process", process});
}

constexpr const char* kNumbers =
    "components: {numbers: {type: relay/Numbers}, one: {type: relay/Checker}}\n"
    "processes: {p: {components: [numbers]}}\n";

TEST(HgrosService, TellsSystemdWhenItRunsLivesAndEndsButNothingWhileItIsStopped) {
  const RobotFolder robot("components: {a: {type: relay/Does}}\n");
  NotifySocket manager(robot.path("notify"));
  CommandRun run(robot.Arguments({"--process", "main"}), manager.EnvironmentOf(robot));
  EXPECT_TRUE(manager.Hears("READY=1")) << run.err();
  // It runs when it says so; what it has written may be read later.
  EXPECT_TRUE(test::Await([&] { return run.err().find("a: I run.\n") != std::string::npos; })) << run.err();
  ASSERT_TRUE(manager.Hears("WATCHDOG=1", 5));
  EXPECT_THAT(manager.notices(), AllOf(Contains("STATUS=Running."), Not(Contains("STOPPING=1"))));
  run.Signal(SIGSTOP);
  test::Linger(std::chrono::milliseconds(100));
  const std::size_t before = manager.notices().size();
  test::Linger(std::chrono::milliseconds(100));
  EXPECT_EQ(manager.notices().size(), before);
  run.Signal(SIGCONT);
  EXPECT_TRUE(test::Await([&] { return manager.notices().size() > before; }));
  run.End(SIGTERM);
  EXPECT_TRUE(manager.Hears("STOPPING=1"));
  EXPECT_THAT(run.err(), HasSubstr("a: I end.\n"));
}

TEST(HgrosService, ProcessesMeetWithoutAStarter) {
  const RobotFolder robot(kNumbers);
  for (const char* first : {"p", "main"}) {
    CommandRun run(robot.Arguments({"--process", first}), robot.environment());
    const CommandEnd second = RunProcess(robot, std::string(first) == "p" ? "main" : "p");
    EXPECT_EQ(second.status, 0) << second.err;
    EXPECT_EQ(run.Wait(), 0) << run.err();
    EXPECT_THAT(run.err() + second.err, AllOf(HasSubstr("numbers: It has finished: 100 numbers\n"),
                                              HasSubstr("one: It has finished: all 100\n"), Not(HasSubstr("error"))));
  }
}

// As the exports have it: only the network namespace and /tmp are shared.
TEST(HgrosService, ProcessesOfSeparateContainersMeetAndShareMemory) {
  if (RunInShell("unshare --mount --pid --ipc --fork true").status != 0) GTEST_SKIP() << "Namespaces need root.";
  const RobotFolder robot(kNumbers);
  const auto start = [&](const std::string& process) {
    return std::make_unique<CommandRun>(
        std::vector<std::string>{"--mount", "--pid", "--ipc", "--fork", "--kill-child", "--mount-proc", "sh", "-c",
                                 "mount -t tmpfs none /run; unset XDG_RUNTIME_DIR; exec \"$0\" run " + robot.file() +
                                     " --process " + process,
                                 test::Path("hgros")},
        robot.environment(), -1, "/usr/bin/unshare");
  };
  const auto p = start("p");
  const auto main = start("main");
  EXPECT_EQ(main->Wait(), 0) << main->err();
  EXPECT_EQ(p->Wait(), 0) << p->err();
  EXPECT_THAT(main->err(), AllOf(HasSubstr("one: It has finished: all 100\n"), Not(HasSubstr("warning"))));
}

TEST(HgrosService, TheExitCodeSaysWhatHasEnded) {
  const auto end = [](const std::string& what, const std::string& component, const std::string& process) {
    const RobotFolder robot("components: {a: {type: relay/Does, params: {what: " + what + "}" + component +
                            "}, b: {type: relay/Does}}\nprocesses: {p: {components: [a" + process + "}}\n");
    return RunProcess(robot, "p");
  };
  EXPECT_EQ(end("finish", "", "]").status, 0);
  EXPECT_EQ(end("fail", "", "]").status, 1);
  EXPECT_EQ(end("finish", ", essential: true", ", b]").status, 0);
  EXPECT_THAT(end("fail", ", essential: true", ", b]"),
              Ends(1, AllOf(HasSubstr("a: error: It has failed: the laser is broken\n"), HasSubstr("b: I end."))));
  EXPECT_EQ(end("fail", "", ", b], restart: on-failure").status, 1) << "So systemd starts it again.";
  EXPECT_EQ(end("throw at start", "", "]").status, 1);
}

TEST(HgrosService, SystemdHearsByTheExitCodeThatAnEssentialComponentHasEnded) {
  for (const bool fails : {false, true}) {
    const RobotFolder robot("components: {a: {type: relay/Does, essential: true, params: {what: " +
                            std::string(fails ? "fail" : "finish") + "}}, b: {type: relay/Does}}\n");
    NotifySocket manager(robot.path("notify"));
    EXPECT_THAT(RunToEnd(robot.Arguments({"--process", "main"}), manager.EnvironmentOf(robot)), Ends(fails ? 11 : 10));
  }
}

TEST(HgrosService, AComponentIsConstructedAgainInPlaceUntilItIsTooOftenWhichIsSaidOnce) {
  const RobotFolder robot(
      "components: {a: {type: relay/Does, restart: on-exception, params: {what: throw}}, b: {type: relay/Does},\n"
      "  c: {type: relay/Does, restart: on-exception, params: {what: throw always}}}\n");
  CommandRun run(robot.Arguments({"--process", "main"}), robot.environment());
  EXPECT_TRUE(test::Await([&] { return Times(run.err(), "a: I run.") >= 2; })) << run.err();
  EXPECT_THAT(run.err(), HasSubstr("a: error: It is constructed again, because it has failed: it is too dark"));
  const std::string said = "It was constructed again 5 times within a minute, and now is not.";
  ASSERT_TRUE(test::Await([&] { return Times(run.err(), "c: error: " + said) > 0; })) << run.err();
  test::Linger(std::chrono::milliseconds(300));  // Some more exceptions.
  EXPECT_EQ(Times(run.err(), "c: error: " + said), 1U) << run.err();
  run.End(SIGTERM);
}

TEST(HgrosService, AFaultOfAnotherProcessDoesNotMatter) {
  const RobotFolder robot(
      "components: {a: {type: relay/Does, params: {what: finish}}, b: {type: relay/Does, params: {what: throw at "
      "start}}}\nprocesses: {p: {components: [a]}}\n");
  EXPECT_EQ(RunProcess(robot, "p").status, 0);
  EXPECT_THAT(RunProcess(robot, "main"), Ends(1, HasSubstr("there is no laser at /dev/ttyUSB0")));
}

TEST(HgrosService, AProcessAloneIsNotDetached) {
  const RobotFolder robot("components: {a: {type: relay/Does}}\nprocesses: {front: {components: [a]}}\n");
  EXPECT_EQ(robot.Run({"--process", "front", "--detach"}).status, 2);
}

}  // namespace
}  // namespace hgros::cli
