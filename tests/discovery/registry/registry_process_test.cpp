// Registries whose processes are killed, or fork.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <deque>
#include <stdexcept>

#include "discovery/listening.hpp"
#include "hgros/discovery/registry.hpp"
#include "support/path.hpp"

namespace hgros::discovery {
namespace {

using test::Await;
namespace fs = std::filesystem;

/// A discovery_worker that has announced its sessions. Killed when this object ends.
class AnnouncingProcess {
 public:
  AnnouncingProcess(const RegistryOptions& options, int sessions, bool forks) {
    std::vector<std::string> command{test::Path("worker"), options.folder.string(), options.domain,
                                     std::to_string(sessions)};
    if (forks) command.emplace_back("fork");
    std::vector<char*> pointers;
    for (std::string& argument : command) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    int input[2];
    int output[2];
    if (pipe2(input, O_CLOEXEC) != 0 || pipe2(output, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input[0], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
    const bool started = posix_spawn(&pid_, pointers[0], &actions, nullptr, pointers.data(), environ) == 0;
    posix_spawn_file_actions_destroy(&actions);
    close(input[0]);
    close(output[1]);
    input_ = input[1];
    std::string said;
    char byte = 0;
    while (started && read(output[0], &byte, 1) == 1 && byte != '\n') said += byte;
    close(output[0]);
    if (!said.starts_with("ready ")) {
      close(input_);
      if (started) waitpid(pid_, nullptr, 0);
      throw std::runtime_error("the worker did not announce its sessions");
    }
    child_ = std::stoi(said.substr(6));
  }
  AnnouncingProcess(const AnnouncingProcess&) = delete;
  AnnouncingProcess& operator=(const AnnouncingProcess&) = delete;
  ~AnnouncingProcess() {
    close(input_);
    Kill();
    waitpid(pid_, nullptr, 0);
  }

  /// Sends SIGKILL and does not wait.
  void Kill() const { kill(pid_, SIGKILL); }
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] pid_t child() const { return child_; }

 private:
  pid_t pid_ = -1;
  pid_t child_ = 0;
  int input_ = -1;  // Closing it ends the worker.
};

class RegistryProcess : public testing::Test, protected OwnDomain {
 protected:
  [[nodiscard]] AnnouncingProcess Start(int sessions, bool forks = false) const { return {options, sessions, forks}; }
  [[nodiscard]] std::unique_ptr<Discovery> Open(Listening& listener) {
    return OpenRegistry(options, listener, log.log);
  }

  KeptLog log;
  Listening listening;
};

TEST_F(RegistryProcess, KilledProcessIsReportedAndItsFilesAreRemovedAlthoughItsForkedChildLives) {
  auto registry = Open(listening);
  const AnnouncingProcess worker = Start(5, true);
  ASSERT_TRUE(listening.AwaitCount(5));
  const std::vector<Announcement> peers = listening.here();
  EXPECT_EQ(peers[0].pid, worker.pid());
  EXPECT_EQ(peers[0].process, "discovery_worker");
  EXPECT_NE(peers[0].pid_start_time, 0U);
  worker.Kill();
  ASSERT_TRUE(listening.AwaitCount(0));
  EXPECT_EQ(kill(worker.child(), 0), 0) << "the child lives";
  EXPECT_EQ(listening.gone(peers[0].session), "Its process ended without a goodbye.");
  EXPECT_TRUE(IsEmptyOrGone(folder));
  registry.reset();
  EXPECT_FALSE(fs::exists(folder));
  EXPECT_EQ(listening.broken() + log.text(), "");
}

TEST_F(RegistryProcess, SessionsStayKnownWhileThisProcessCanOpenNoFiles) {
  auto registry = Open(listening);
  const AnnouncingProcess worker = Start(3);
  ASSERT_TRUE(listening.AwaitCount(3));
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
  const rlimit none{0, limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
  const pid_t child = fork();
  if (child == 0) {  // Closing a file that is open for writing wakes the registry.
    setrlimit(RLIMIT_NOFILE, &limit);
    for (const std::string& file : files) close(open(file.c_str(), O_WRONLY | O_CLOEXEC));
    _exit(0);
  }
  EXPECT_EQ(waitpid(child, nullptr, 0), child);
  EXPECT_FALSE(Await([&] { return listening.here().size() != 3; }, std::chrono::milliseconds(300)));
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
  worker.Kill();
  EXPECT_TRUE(listening.AwaitCount(0));
  EXPECT_NE(log.text().find("the limit of open files is reached"), std::string::npos) << log.text();
  EXPECT_EQ(listening.broken(), "");
}

TEST_F(RegistryProcess, LaterRegistryRemovesFilesOfADeadProcess) {
  {
    const AnnouncingProcess worker = Start(3);
    worker.Kill();
  }
  EXPECT_TRUE(fs::exists(folder)) << "no registry was open that could remove the file";
  auto registry = Open(listening);
  EXPECT_TRUE(registry->List().empty());
  EXPECT_TRUE(IsEmptyOrGone(folder));
  registry.reset();
  EXPECT_EQ(listening.broken() + log.text(), "");
}

TEST_F(RegistryProcess, ManyRegistriesCleanUpAKilledProcessAndSpareNewOnes) {
  std::deque<Listening> all(6);
  std::vector<std::unique_ptr<Discovery>> observers;
  for (Listening& one : all) observers.push_back(Open(one));
  for (int round = 0; round < 10; ++round) {
    const AnnouncingProcess worker = Start(4);
    for (const auto& one : all) ASSERT_TRUE(one.AwaitCount(4));
    worker.Kill();
    // A session comes, and changes, while the files of the dead process are removed.
    Listening coming_listening;
    const auto coming = Open(coming_listening);
    Announcement own = NewAnnouncement("coming");
    for (int i = 0; i < 5; ++i) {
      own.endpoints = {"tcp://*:" + std::to_string(i + 1)};
      coming->Announce(own);
    }
    for (const auto& one : all) {
      EXPECT_TRUE(one.AwaitPeer(own));
      EXPECT_TRUE(one.AwaitCount(1));
      EXPECT_EQ(one.came(own.session), 1);
    }
    EXPECT_TRUE(coming_listening.AwaitCount(0));
    EXPECT_EQ(coming_listening.broken(), "");
  }
  for (const auto& one : all) EXPECT_TRUE(one.AwaitCount(0));
  EXPECT_TRUE(IsEmptyOrGone(folder));
  for (const auto& one : all) EXPECT_EQ(one.broken(), "");
  EXPECT_EQ(log.text(), "");
}

TEST_F(RegistryProcess, ForkDoesNotDisturbTheParent) {
  Listening observer_listening;
  const auto observer = Open(observer_listening);
  auto registry = Open(listening);
  Announcement own = NewAnnouncement();
  registry->Announce(own);
  ASSERT_TRUE(observer_listening.AwaitPeer(own));
  EXPECT_EQ(UseInForkedChild(registry, own), 0);
  own.channels.clear();
  registry->Announce(own);
  EXPECT_TRUE(observer_listening.AwaitPeer(own));
  EXPECT_EQ(observer_listening.came(own.session), 1);
  EXPECT_EQ(log.text(), "");
}

}  // namespace
}  // namespace hgros::discovery
