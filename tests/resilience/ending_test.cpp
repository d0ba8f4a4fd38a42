// A program that ends inside a callback of its session: see ending_worker.cpp.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/hgros.hpp"
#include "resilience/places.hpp"
#include "support/await.hpp"
#include "support/path.hpp"
#include "support/seed.hpp"

namespace hgros::resilience {
namespace {

using foxglove::Log;
using test::Await;
using test::kPatience;

constexpr int kStatus = 7;  // Of the worker.

struct Ending {
  std::string owner;
  std::string end;
  std::string kind;
};

/// A running ending_worker. Killed when this object ends.
class Worker {
 public:
  explicit Worker(const Ending& how) : ending(how) {
    std::vector<std::string> command = {test::Path("ending_worker"), "--session=" + ending.owner, "--end=" + ending.end,
                                        "--in=" + ending.kind, "--bus=" + folder.path().string()};
    std::vector<char*> arguments;
    for (std::string& argument : command) arguments.push_back(argument.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, (folder / "out").c_str(), O_WRONLY | O_CREAT, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, (folder / "log").c_str(), O_WRONLY | O_CREAT, 0600);
    if (posix_spawn(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&actions);
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    if (pid_ < 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

  /// Its exit status; what stopped it if it did not end by itself.
  std::string Result() {
    int status = 0;
    if (!Await([&] { return waitpid(pid_, &status, WNOHANG) == pid_; })) return "it hangs";
    pid_ = -1;
    return WIFEXITED(status) ? std::to_string(WEXITSTATUS(status)) : "signal " + std::to_string(WTERMSIG(status));
  }
  [[nodiscard]] std::string Output() const { return folder.Read("out"); }
  [[nodiscard]] std::string Errors() const { return folder.Read("log"); }

  const ScratchFolder folder;
  const Ending ending;

 private:
  pid_t pid_ = -1;
};

TEST(EndingInACallback, KeepsTheExitStatus) {
  std::vector<Ending> endings = {{"main", "exit", "wiring"}};
  for (const std::string kind : {"tbb", "inline", "dedicated", "timer", "inline-timer", "service", "peer-event",
                                 "remote", "remote-tbb", "locked"}) {
    endings.insert(endings.end(), {{"static", "exit", kind}, {"main", "exit", kind}, {"main", "destroy", kind}});
  }
  for (const std::string kind : {"tbb", "inline"}) {
    endings.insert(endings.end(), {{"default", "exit", kind}, {"default", "destroy", kind}});
  }
  const auto rounds = static_cast<std::size_t>(test::Rounds(1, 20));
  const std::size_t at_once = std::max<std::size_t>(rounds, 4);
  for (std::size_t next = 0; next < endings.size() * rounds;) {
    std::list<Worker> workers;
    for (; workers.size() < at_once && next < endings.size() * rounds; ++next) {
      workers.emplace_back(endings[next / rounds]);
    }
    for (Worker& worker : workers) {
      SCOPED_TRACE(worker.ending.owner + " " + worker.ending.end + " " + worker.ending.kind);
      ASSERT_EQ(worker.Result(), std::to_string(kStatus)) << worker.Errors();
      EXPECT_EQ(worker.Output(), "ending\nstatic object ended\n");
      const std::string errors = worker.Errors();
      const std::string said = "was destroyed inside the callback of its node \"fatal\" on channel";
      EXPECT_EQ(errors.find(said) != std::string::npos, worker.ending.end == "destroy") << errors;
      EXPECT_EQ(errors.find("Shutting down waits"), std::string::npos) << errors;
    }
  }
}

TEST(EndingItsThread, IsLoggedWithTheCallback) {
  for (const std::string kind : {"tbb", "inline", "dedicated", "timer", "service"}) {
    SCOPED_TRACE(kind);
    Worker worker({"main", "thread", kind});
    EXPECT_EQ(worker.Result(), "signal " + std::to_string(SIGABRT)) << worker.Errors();
    const std::string errors = worker.Errors();
    EXPECT_NE(errors.find("called pthread_exit()"), std::string::npos) << errors;
    EXPECT_EQ(errors.find("the node continues"), std::string::npos) << errors;
    EXPECT_NE(errors.find("fatal\" on channel"), std::string::npos) << errors;
  }
}

TEST(PeerOfAnEndingSession, HearsAGoodbye) {
  const Ending endings[] = {{"static", "exit", "outside"}, {"main", "exit", "outside"}, {"main", "destroy", "outside"}};
  for (const Ending& ending : endings) {
    SCOPED_TRACE(ending.owner + " " + ending.end);
    Worker worker(ending);
    std::mutex mutex;
    std::vector<std::string> reasons;
    Session peer(Config::Parse("network: {publisher: {ip: \"" + worker.folder.Ipc("other") +
                               "\"}, subscribers: [{ip: \"" + worker.folder.Ipc("subject") + "\"}]}"),
                 {"peer", [](LogLevel, std::string_view) {}});
    const auto events = peer.FromGraph<PeerEvent>(kPeerEventsChannel, Invoke::kSerial, [&](const PeerEvent& event) {
      const std::scoped_lock lock(mutex);
      if (event.kind == PeerEvent::Kind::kGone) reasons.push_back(event.reason);
    });
    // They are connected in both directions: a session says goodbye to those that it knows.
    std::atomic<bool> hears{false};
    const auto busy = peer.FromAny<Log>("busy", Invoke::kSerial, [&hears](const Log&) { hears = true; });
    const auto fatal = peer.Advertise<Log>("fatal");
    ASSERT_TRUE(peer.WaitForSubscribers("fatal", 1, kPatience)) << worker.Errors();
    ASSERT_TRUE(Await([&] { return hears.load(); })) << worker.Errors();
    (void)fatal(std::make_unique<Log>());
    EXPECT_EQ(worker.Result(), std::to_string(kStatus)) << worker.Errors();
    EXPECT_TRUE(Await([&] {
      const std::scoped_lock lock(mutex);
      return !reasons.empty();
    }));
    const std::scoped_lock lock(mutex);
    EXPECT_EQ(reasons, std::vector<std::string>{"it said goodbye"});
  }
}

}  // namespace
}  // namespace hgros::resilience
