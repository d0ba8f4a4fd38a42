// Many sessions on one host, and sessions that cannot reach each other.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hgros/session/session.hpp"
#include "resilience/places.hpp"
#include "resilience/worker_process.hpp"

namespace hgros::resilience {
namespace {

using test::Await;
using Workers = std::vector<std::unique_ptr<WorkerProcess>>;

constexpr std::uint64_t kMostFiles = 30;  // Of one session, beyond those of its partners.

bool CanMakeNamespaces() {
  const pid_t child = fork();
  if (child == 0) _exit(unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0 ? 0 : 1);
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

class Crowd : public testing::Test {
 protected:
  static std::unique_ptr<WorkerProcess> Start(const std::vector<std::string>& arguments) {
    return std::make_unique<WorkerProcess>(arguments);
  }
  const OwnDomain domain_;
};

TEST_F(Crowd, SessionsThatOnlyFollowDoNotPairAndWriteNothing) {
  constexpr std::uint64_t kProcesses = 6;
  constexpr std::uint64_t kSessions = 10;
  constexpr std::uint64_t kAll = kProcesses * kSessions + 1;
  Workers followers;
  for (std::uint64_t i = 0; i < kProcesses; ++i)
    followers.push_back(Start({"--sessions=" + std::to_string(kSessions)}));
  const auto publisher = Start({"--sessions=1", "--publishers=1"});
  for (const auto& one : followers) {
    ASSERT_TRUE(one->Reaches({{"known", kAll}, {"received", 3}})) << *one;
    EXPECT_EQ((*one)["peers"], 1U) << "only the publisher; " << *one;
    EXPECT_LE((*one)["files"], kMostFiles) << *one;
  }
  ASSERT_TRUE(publisher->Reaches({{"known", kAll}, {"peers", kAll - 1}})) << *publisher;
  EXPECT_EQ(publisher->Finish(), 0);
  EXPECT_TRUE(publisher->Reaches({{"ended", 1}})) << *publisher;
  EXPECT_EQ((*publisher)["lines"], 0U) << *publisher;
  for (const auto& one : followers) {
    EXPECT_TRUE(Await([&] { return (*one)["known"] == kAll - 1 && (*one)["peers"] == 0; })) << *one;
  }
  for (const auto& one : followers) {
    EXPECT_EQ(one->Finish(), 0) << *one;
    EXPECT_TRUE(one->Reaches({{"ended", 1}})) << *one;
    EXPECT_EQ((*one)["lines"], 0U) << *one;
  }
}

TEST_F(Crowd, FiveHundredSessionsKnowEachOther) {
  constexpr std::uint64_t kProcesses = 25;
  constexpr std::uint64_t kAll = 501;
  const auto follow = [](std::uint64_t sessions) {
    return Start({"--sessions=" + std::to_string(sessions), "--total=" + std::to_string(kAll + 1), "--every=2"});
  };
  Workers followers;
  for (std::uint64_t i = 0; i < kProcesses; ++i) followers.push_back(follow((kAll - 1) / kProcesses));
  followers.push_back(follow(1));  // Shares its descriptors with no other session.
  const auto publisher = Start({"--sessions=1", "--publishers=1", "--total=" + std::to_string(kAll + 1)});
  for (const auto& one : followers) ASSERT_TRUE(one->Reaches({{"ready", 1}}, std::chrono::minutes(1))) << *one;
  ASSERT_TRUE(publisher->Reaches({{"ready", 1}})) << *publisher;
  for (const auto& one : followers) {
    EXPECT_TRUE(one->Reaches({{"known", kAll + 1}, {"received", 1}})) << one->pid() << " knows " << (*one)["known"];
    EXPECT_EQ((*one)["peers"], 1U) << "only the publisher";
    EXPECT_LE((*one)["files"], kMostFiles);
  }
  EXPECT_TRUE(publisher->Reaches({{"known", kAll + 1}, {"peers", kAll}})) << *publisher;
  constexpr std::uint64_t kOfAPartner = 4;  // At most: docs/shared-memory.md.
  EXPECT_LE((*publisher)["files"], kMostFiles + kOfAPartner * kAll) << *publisher;
  EXPECT_GT((*publisher)["files"], kAll) << "it counts them";
}

TEST_F(Crowd, DiscoveryWorksWithoutInotify) {
  if (!CanMakeNamespaces()) GTEST_SKIP() << "no user namespaces here";
  constexpr std::uint64_t kProcesses = 3;
  constexpr std::uint64_t kSessions = 5;
  constexpr std::uint64_t kAll = kProcesses * kSessions + 1;
  Workers followers;
  for (std::uint64_t i = 0; i < kProcesses; ++i) {
    followers.push_back(Start({"--sessions=" + std::to_string(kSessions), "--inotify=1"}));
    ASSERT_TRUE(followers.back()->Reaches({{"ready", 1}})) << *followers.back();
  }
  const auto last = Start({"--sessions=1", "--publishers=1", "--inotify=0"});
  for (const auto& one : followers) {
    EXPECT_TRUE(one->Reaches({{"known", kAll}, {"received", 3}, {"peers", 1}})) << *one;
    EXPECT_EQ((*one)["lines"], kSessions - 1) << "one line for each session without inotify; " << *one;
    EXPECT_TRUE(one->Says("fs.inotify.max_user_instances")) << *one;
  }
  EXPECT_TRUE(last->Reaches({{"known", kAll}, {"peers", kAll - 1}, {"lines", 1}})) << *last;
  followers.pop_back();  // Killed: nobody says goodbye.
  EXPECT_TRUE(Await([&] { return (*last)["known"] == kAll - kSessions; })) << *last;
  EXPECT_TRUE(Await([&] { return (*followers.front())["known"] == kAll - kSessions; })) << *followers.front();
}

TEST_F(Crowd, SessionsAppearWhenTheFullDiskHasRoom) {
  if (!CanMakeNamespaces()) GTEST_SKIP() << "no user and mount namespaces here";
  const auto worker = Start({"--sessions=2", "--publishers=1", "--disk=full"});
  EXPECT_TRUE(worker->ComesToSay("do not find this one")) << *worker;
  EXPECT_TRUE(worker->Says("No space left on device")) << *worker;
  EXPECT_TRUE(worker->Reaches({{"known", 2}, {"peers", 1}, {"received", 3}})) << *worker;
}

TEST_F(Crowd, ReportNamesAStoppedProcess) {
  const auto stopped = Start({"--sessions=1", "--publishers=1"});
  ASSERT_TRUE(stopped->Reaches({{"received", 3}})) << *stopped;
  stopped->Stop();
  const auto follower = Start({"--sessions=1"});
  EXPECT_TRUE(follower->ComesToSay("its process is stopped")) << *follower;
  stopped->Continue();
  EXPECT_TRUE(follower->Reaches({{"received", 3}})) << *follower;
}

// The session with the larger id waits for the other one, which connects.
TEST_F(Crowd, AnExchangeThatEndsBeforeTheOtherSideSeesItIsNoFault) {
  const auto publisher = Start({"--sessions=1", "--publishers=1"});
  ASSERT_TRUE(publisher->Reaches({{"known", 1}})) << *publisher;
  std::mutex mutex;
  std::string said;
  const auto log = [&](LogLevel, std::string_view line) {
    const std::scoped_lock lock(mutex);
    said += std::string(line) + "\n";
  };
  std::vector<std::unique_ptr<Session>> sessions;
  for (int i = 0; i < 4; ++i) sessions.push_back(std::make_unique<Session>(Config(), SessionOptions{"brief", log}));
  for (const auto& one : sessions) {
    ASSERT_TRUE(Await([&] {
      const auto channels = one->Channels();
      return std::ranges::any_of(channels,
                                 [](const KnownChannel& of) { return of.name == "tf" && !of.publishers.empty(); });
    }));
  }
  publisher->Stop();
  for (const auto& one : sessions) {
    const Subscription brief = one->FromAnyRaw("tf", Invoke::kSerial, [](const RawMessage&) {});
    test::Linger(std::chrono::milliseconds(200));
  }
  publisher->Continue();
  test::Linger(std::chrono::seconds(12));  // Sessions of one host are given up after 10 s.
  const std::scoped_lock lock(mutex);
  EXPECT_EQ(said.find("does not reach it"), std::string::npos) << said;
}

TEST_F(Crowd, ReportNamesAnotherNetworkNamespace) {
  if (!CanMakeNamespaces()) GTEST_SKIP() << "no user and network namespaces here";
  const auto apart = Start({"--sessions=1", "--publishers=1", "--network=apart"});
  const auto follower = Start({"--sessions=1"});
  for (const WorkerProcess* const one : {apart.get(), follower.get()}) {
    EXPECT_TRUE(one->ComesToSay("is in another network namespace")) << *one;
  }
}

TEST_F(Crowd, ReportNamesTheLimitOfOpenFilesAndNotTheUser) {
  const auto full = Start({"--sessions=1", "--publishers=1", "--files=1"});
  ASSERT_TRUE(full->Reaches({{"received", 7}})) << *full;
  const auto follower = Start({"--sessions=1"});
  EXPECT_TRUE(full->ComesToSay("the limit of open files is reached")) << *full;
  test::Linger(std::chrono::seconds(3));  // Longer than sessions are left to shared memory.
  for (const WorkerProcess* const one : {full.get(), follower.get()}) {
    EXPECT_FALSE(one->Says("one user")) << *one;
  }
}

}  // namespace
}  // namespace hgros::resilience
