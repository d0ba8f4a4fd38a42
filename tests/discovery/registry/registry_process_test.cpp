// Registries whose processes are killed, or fork.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "discovery/announcing_process.hpp"
#include "discovery/listening.hpp"
#include "hgros/base/error.hpp"
#include "hgros/discovery/registry.hpp"

namespace hgros::discovery {
namespace {

using test::Await;
namespace fs = std::filesystem;

class RegistryProcess : public testing::Test {
 protected:
  [[nodiscard]] AnnouncingProcess Start(int sessions, bool forks = false) const {
    return {options.folder, options.domain, sessions, forks};
  }
  [[nodiscard]] std::unique_ptr<Discovery> Open(Listening& listening) {
    return OpenRegistry(options, listening, log.log);
  }

  ScratchFolder scratch;
  RegistryOptions options{scratch.path() / "hgros", "robot"};
  fs::path folder = options.folder / options.domain;
  KeptLog log;
};

TEST_F(RegistryProcess, KilledProcessIsReportedAndItsFilesAreRemoved) {
  Listening listening;
  auto registry = Open(listening);
  std::optional<AnnouncingProcess> worker;
  worker.emplace(options.folder, options.domain, 5);
  ASSERT_TRUE(listening.AwaitCount(5));
  const std::vector<Announcement> peers = listening.here();
  EXPECT_EQ(peers[0].pid, worker->pid());
  EXPECT_EQ(peers[0].process, "discovery_worker");
  EXPECT_NE(peers[0].pid_start_time, 0U);
  worker->Kill();
  ASSERT_TRUE(listening.AwaitCount(0));
  EXPECT_EQ(listening.gone(peers[0].session), "Its process ended without a goodbye.");
  EXPECT_TRUE(IsEmptyOrGone(folder));
  registry.reset();
  EXPECT_FALSE(fs::exists(folder));
  EXPECT_EQ(listening.broken() + log.text(), "");
}

TEST_F(RegistryProcess, SessionsStayKnownWhileThisProcessCanOpenNoFiles) {
  Listening listening;
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

TEST_F(RegistryProcess, ProcessThatEndsNormallySaysGoodbye) {
  Listening listening;
  auto registry = Open(listening);
  AnnouncingProcess worker = Start(1);
  ASSERT_TRUE(listening.AwaitCount(1));
  const SessionId session = listening.here()[0].session;
  EXPECT_EQ(worker.Finish(), 0);
  ASSERT_TRUE(listening.AwaitCount(0));
  EXPECT_EQ(listening.gone(session), "It said goodbye.");
}

TEST_F(RegistryProcess, LaterRegistryRemovesFilesOfADeadProcess) {
  {
    const AnnouncingProcess worker = Start(3);
    worker.Kill();
  }
  EXPECT_TRUE(fs::exists(folder)) << "no registry was open that could remove the file";
  Listening listening;
  auto registry = Open(listening);
  EXPECT_TRUE(registry->List().empty());
  EXPECT_TRUE(IsEmptyOrGone(folder));
  registry.reset();
  EXPECT_EQ(listening.broken() + log.text(), "");
}

TEST_F(RegistryProcess, ManyRegistriesCleanUpAKilledProcessAndSpareNewOnes) {
  constexpr int kObservers = 6;
  std::vector<std::unique_ptr<Listening>> listening;
  std::vector<std::unique_ptr<Discovery>> observers;
  for (int i = 0; i < kObservers; ++i) {
    listening.push_back(std::make_unique<Listening>());
    observers.push_back(Open(*listening.back()));
  }
  for (int round = 0; round < 10; ++round) {
    const AnnouncingProcess worker = Start(4);
    for (const auto& one : listening) ASSERT_TRUE(one->AwaitCount(4));
    worker.Kill();
    // A session comes, and changes, while the files of the dead process are removed.
    Listening coming_listening;
    const auto coming = Open(coming_listening);
    Announcement own = NewAnnouncement("coming");
    for (int i = 0; i < 5; ++i) {
      own.endpoints = {"tcp://*:" + std::to_string(i + 1)};
      coming->Announce(own);
    }
    for (const auto& one : listening) {
      EXPECT_TRUE(one->AwaitPeer(own));
      EXPECT_TRUE(one->AwaitCount(1));
      EXPECT_EQ(one->came(own.session), 1);
    }
    EXPECT_TRUE(coming_listening.AwaitCount(0));
    EXPECT_EQ(coming_listening.broken(), "");
  }
  for (const auto& one : listening) EXPECT_TRUE(one->AwaitCount(0));
  EXPECT_TRUE(IsEmptyOrGone(folder));
  for (const auto& one : listening) EXPECT_EQ(one->broken(), "");
  EXPECT_EQ(log.text(), "");
}

TEST_F(RegistryProcess, ForkedChildDoesNotKeepItsKilledParentAlive) {
  Listening listening;
  const auto registry = Open(listening);
  AnnouncingProcess worker = Start(2, true);
  ASSERT_TRUE(listening.AwaitCount(2));
  worker.Kill();
  EXPECT_TRUE(listening.AwaitCount(0));
  EXPECT_EQ(kill(worker.child(), 0), 0) << "the child lives";
}

TEST_F(RegistryProcess, ForkDoesNotDisturbTheParent) {
  Listening observer_listening;
  const auto observer = Open(observer_listening);
  Listening listening;
  auto registry = Open(listening);
  Announcement own = NewAnnouncement();
  registry->Announce(own);
  ASSERT_TRUE(observer_listening.AwaitPeer(own));
  (void)std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    int status = 0;
    if (!registry->List().empty()) status |= 1;
    try {
      registry->Announce(own);
      status |= 2;
    } catch (const Error&) {
    }
    registry.reset();
    _exit(status);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  own.channels.clear();
  registry->Announce(own);
  EXPECT_TRUE(observer_listening.AwaitPeer(own));
  EXPECT_EQ(observer_listening.came(own.session), 1);
  EXPECT_EQ(log.text(), "");
}

}  // namespace
}  // namespace hgros::discovery
