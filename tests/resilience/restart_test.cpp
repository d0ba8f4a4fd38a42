// Processes that are killed at any moment and started again.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "resilience/places.hpp"
#include "resilience/worker_process.hpp"

namespace hgros::resilience {
namespace {

using test::Await;

class Restart : public testing::TestWithParam<std::string> {
 protected:
  Restart() {
    const bool ipc = GetParam() == "ipc";
    up = ipc ? folder.Endpoint("up") : TcpEndpoint(FreePort());
    down = ipc ? folder.Endpoint("down") : TcpEndpoint(FreePort());
  }
  [[nodiscard]] std::unique_ptr<WorkerProcess> Publisher() const {
    return std::make_unique<WorkerProcess>(std::vector<std::string>{Publishing(up, kImpatient), "--out=up"});
  }
  // Every other one is lossless: when it is killed, it does not return its credit.
  [[nodiscard]] std::unique_ptr<WorkerProcess> Subscriber(bool lossless) const {
    return std::make_unique<WorkerProcess>(std::vector<std::string>{Subscribing(down, kImpatient), "--in=down",
                                                                    lossless ? "--keep-all=32" : "--keep-last=32"});
  }

  ScratchFolder folder;
  std::string up;    // From the restarted publisher to the survivor.
  std::string down;  // From the survivor to the restarted subscriber.
};

TEST_P(Restart, ASurvivorSendsReceivesAndLeaksNothingAfterAHundredKills) {
  constexpr int kKills = 100;
  constexpr int kSettled = 20;  // After this number of kills the survivor's own memory no longer grows.
  constexpr std::size_t kSpareFiles = 4;
  constexpr std::size_t kSpareBytes = 12 << 20;
  const WorkerProcess survivor({Both(down, up, kImpatient), "--out=down", "--in=up", "--keep-last=32"});
  auto publisher = Publisher();
  auto subscriber = Subscriber(false);
  std::size_t files = 0;
  std::size_t bytes = 0;
  for (int round = 0; round <= kKills; ++round) {
    if (round % 2 == 0) {
      subscriber->Kill();
      subscriber = Subscriber(round % 4 == 0);
    } else {
      publisher->Kill();
      publisher = Publisher();
    }
    const auto heard = [&] { return survivor["from"] == static_cast<std::uint64_t>(publisher->pid()); };
    ASSERT_TRUE(Await(heard)) << "round " << round << survivor << *publisher;
    ASSERT_TRUE(survivor.Gains("received", 5)) << "round " << round << survivor << *publisher;
    ASSERT_TRUE(subscriber->Gains("received", 5)) << "round " << round << survivor << *subscriber;
    if (round != kSettled && round != kKills) continue;
    // Wait until the survivor has noticed all killed processes.
    ASSERT_TRUE(Await([&] { return survivor["subscribers"] == 1 && survivor["peers"] == 2; })) << survivor;
    if (round == kSettled) {
      files = survivor.open_files();
      bytes = survivor.resident_bytes();
    }
  }
  EXPECT_TRUE(Await([&] { return survivor.open_files() <= files + kSpareFiles; }))
      << survivor.open_files() << " files are open, " << files << " were" << survivor;
  EXPECT_LE(survivor.resident_bytes(), bytes + kSpareBytes) << bytes << " before" << survivor;
  EXPECT_EQ(survivor["corrupt"] + survivor["disorder"] + survivor["refused"], 0U) << survivor;
  EXPECT_EQ((*subscriber)["corrupt"] + (*subscriber)["disorder"], 0U) << *subscriber;
}

TEST_P(Restart, NewProcessesWorkAtOnceAfterAllWereKilled) {
  for (int life = 0; life < 5; ++life) {
    const WorkerProcess relay({Both(down, up), "--out=down", "--in=up"});
    const auto publisher = Publisher();
    const auto subscriber = Subscriber(true);
    ASSERT_TRUE(relay.Reaches({{"received", 20}})) << "life " << life << relay << *publisher;
    ASSERT_TRUE(subscriber->Reaches({{"received", 20}})) << "life " << life << relay << *subscriber;
  }
}

TEST_P(Restart, AWorkerEndsInOrderWhileItsPeersAreStopped) {
  WorkerProcess relay({Both(down, up), "--out=down", "--in=up"});
  auto publisher = Publisher();
  auto subscriber = Subscriber(true);
  ASSERT_TRUE(relay.Reaches({{"received", 20}})) << relay;
  ASSERT_TRUE(subscriber->Reaches({{"received", 20}})) << relay;
  subscriber->Stop();
  publisher->Stop();
  EXPECT_EQ(relay.Finish(), 0) << "with peers that do not answer" << relay;
  publisher->Continue();
  EXPECT_EQ(publisher->Finish(), 0) << *publisher;
  subscriber->Continue();
  EXPECT_EQ(subscriber->Finish(), 0) << *subscriber;
}

INSTANTIATE_TEST_SUITE_P(Over, Restart, testing::Values("ipc", "tcp"), [](const auto& test) { return test.param; });

}  // namespace
}  // namespace hgros::resilience
