// Subscribers that are stopped, slow or killed while a publisher is at work.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "resilience/places.hpp"
#include "resilience/worker_process.hpp"
#include "support/at_once.hpp"

namespace hgros::resilience {
namespace {

using test::Await;

constexpr std::size_t kLargeBytes = 256 * 1024;

TEST(StoppedSubscriber, DelaysNoOthersAndUsesLimitedMemoryOfThePublisher) {
  const ScratchFolder folder;
  const std::string bus = folder.Ipc("bus");
  // Longer than this may take on a busy machine. Otherwise the stopped subscriber is dropped meanwhile.
  const std::string patient = ", peer_timeout_ms: 120000";
  const WorkerProcess publisher({Publishing(bus, ", peer_queue_bytes: 4MiB" + patient), "--out=images", "--await=2",
                                 "--size=" + std::to_string(kLargeBytes), "--count=1000", "--period-us=2000"});
  const WorkerProcess other({Subscribing(bus, patient), "--in=images", "--keep-all=16"});
  const WorkerProcess stopped({Subscribing(bus, patient), "--in=images", "--keep-last=1000"});
  ASSERT_TRUE(stopped.Reaches({{"received", 50}})) << publisher << stopped;
  stopped.Stop();
  const std::uint64_t until_then = publisher["published"];
  const std::size_t before = publisher.resident_bytes();
  std::size_t most = before;
  // 250 MB are published in this time.
  ASSERT_TRUE(Await(
      [&] {
        most = std::max(most, publisher.resident_bytes());
        return publisher["published"] == 1000;
      },
      3 * test::kPatience))
      << publisher << other;
  ASSERT_TRUE(other.Reaches({{"received", 1000}})) << publisher << other;
  EXPECT_EQ(other["gaps"] + other["disorder"] + other["corrupt"], 0U) << other;
  // The messages in the ring, those in the socket (limited by credit), and some room for the allocator.
  EXPECT_LE(most, before + (4 << 20) + 64 * kLargeBytes + (24 << 20)) << before << " before" << publisher;
  EXPECT_LE(publisher["queued_bytes"], (4U << 20) + kLargeBytes);
  EXPECT_GT(publisher["dropped"] + until_then, 800U) << publisher;
  stopped.Continue();
  ASSERT_TRUE(stopped.Reaches({{"last", 1000}})) << publisher << stopped;
  EXPECT_EQ(stopped["disorder"] + stopped["corrupt"], 0U) << stopped;
  EXPECT_TRUE(Await([&] { return stopped["came"] + stopped["lost"] >= 1000; })) << stopped;  // Read before "last".
  EXPECT_EQ(stopped["came"] + stopped["lost"], 1000U) << stopped;
  EXPECT_EQ(stopped["lost"], publisher["dropped"]) << publisher << stopped;
}

TEST(StoppedSubscriber, ReceivesAgainAfterItWasDropped) {
  for (const bool ipc : {true, false}) {
    const ScratchFolder folder;
    const std::string bus = ipc ? folder.Ipc("bus") : TcpEndpoint(FreePort());
    const WorkerProcess publisher({Publishing(bus, kImpatient), "--out=images", "--size=4096"});
    const WorkerProcess other({Subscribing(bus, kImpatient), "--in=images", "--keep-last=1000"});
    for (const std::string queue : {"--keep-last=16", "--keep-all=16"}) {
      const WorkerProcess stopped({Subscribing(bus, kImpatient), "--in=images", queue});
      for (int round = 0; round < 2; ++round) {
        ASSERT_TRUE(stopped.Gains("received", 20)) << queue << publisher << stopped;
        stopped.Stop();
        ASSERT_TRUE(Await([&] { return publisher["subscribers"] == 1; })) << queue << publisher << stopped;
        ASSERT_TRUE(other.Gains("received", 200)) << queue << publisher << other;
        stopped.Continue();
        ASSERT_TRUE(Await([&] { return publisher["subscribers"] == 2; })) << queue << publisher << stopped;
        ASSERT_TRUE(stopped.Gains("received", 100)) << queue << publisher << stopped;
      }
      EXPECT_EQ(stopped["disorder"] + stopped["corrupt"], 0U) << queue << stopped;
    }
    ASSERT_TRUE(Await([&] { return publisher["subscribers"] == 1; }))
        << "killed subscribers must be noticed" << publisher;
    EXPECT_EQ(other["disorder"] + other["corrupt"], 0U) << other;
  }
}

void ExpectThatItIsNamed(const WorkerProcess& publisher, const WorkerProcess& stopped) {
  ASSERT_TRUE(stopped.Reaches({{"received", 50}})) << publisher << stopped;
  stopped.Stop();
  ASSERT_TRUE(Await([&] { return publisher["subscribers"] == 0; })) << publisher;
  ASSERT_TRUE(publisher.Gains("published", 300)) << publisher;
  stopped.Continue();
  ASSERT_TRUE(Await([&] { return stopped["gaps"] > 0; })) << publisher << stopped;
  EXPECT_TRUE(publisher.Says(" has gone without confirming ")) << publisher;
  std::smatch found;
  std::string text;
  const std::regex total("has missed up to ([0-9]+) messages of the lossless channel \"images\", and is back\\.");
  ASSERT_TRUE(Await([&] {
    text = publisher.Text();
    return std::regex_search(text, found, total);
  })) << publisher
      << stopped;
  const std::uint64_t missed = std::stoull(found[1]);
  EXPECT_GE(missed, stopped["gaps"]) << publisher << stopped;
  EXPECT_LE(missed, stopped["gaps"] + 16) << "its queue may have arrived unconfirmed" << publisher << stopped;
  EXPECT_TRUE(Await([&] { return publisher["missed"] == missed; })) << publisher;
  EXPECT_TRUE(stopped.Says(" did not arrive: the connection to their publisher was lost")) << stopped;
}

TEST(StoppedSubscriber, IsNamedWithTheNumberOfLosslessMessagesThatItMissed) {
  const ScratchFolder folder;
  const std::string bus = folder.Ipc("bus");
  const std::string shared = "--config=network: {heartbeat_ms: 100, peer_timeout_ms: 2000}";
  const auto publisher = [](const std::string& config) {
    return WorkerProcess({config, "--out=images", "--await=1", "--size=4096"});
  };
  const auto subscriber = [](const std::string& config) {
    return WorkerProcess({config, "--in=images", "--keep-all=16"});
  };
  const WorkerProcess talker = publisher(Publishing(bus, kImpatient));
  const WorkerProcess stopped = subscriber(Subscribing(bus, kImpatient));
  const OwnDomain domain;
  const WorkerProcess sharing_talker = publisher(shared);
  const WorkerProcess sharing_stopped = subscriber(shared);
  test::AtOnce(
      {[&] { ExpectThatItIsNamed(talker, stopped); }, [&] { ExpectThatItIsNamed(sharing_talker, sharing_stopped); }});
}

TEST(StoppedSubscriber, MissesNothingIfItIsLosslessAndContinuesInTime) {
  const ScratchFolder folder;
  const std::string bus = folder.Ipc("bus");
  const WorkerProcess publisher(
      {Publishing(bus), "--out=images", "--await=1", "--count=1000", "--size=65536", "--period-us=100"});
  const WorkerProcess stopped({Subscribing(bus), "--in=images", "--keep-all=16"});
  ASSERT_TRUE(stopped.Reaches({{"received", 50}})) << publisher << stopped;
  stopped.Stop();
  ASSERT_TRUE(publisher.Reaches({{"waiting", 1}})) << publisher;
  stopped.Continue();
  ExpectAll(stopped, publisher, 1000);
}

// More than the buffers of the connection hold, and less than its credit: ZeroMQ has the rest.
TEST(StoppedSubscriber, IsToldOfAtTheEndOfAPublisherThatCannotSendAll) {
  const auto end = [](std::uint16_t port, bool stops) {
    WorkerProcess publisher({Publishing(TcpEndpoint(port)), "--out=images", "--await=1",
                             "--size=" + std::to_string(2 * kLargeBytes), "--count=40", "--period-us=20000"});
    const WorkerProcess subscriber({Subscribing(TcpEndpoint(port)), "--in=images", "--keep-all=64"});
    ASSERT_TRUE(subscriber.Reaches({{"received", 1}})) << publisher << subscriber;
    if (stops) subscriber.Stop();
    ASSERT_TRUE(publisher.Reaches({{"published", 40}})) << publisher;
    // The rest can be sent before the publisher gives up, also on a busy machine.
    ASSERT_TRUE(stops || subscriber.Reaches({{"received", 36}})) << publisher << subscriber;
    EXPECT_EQ(publisher.Finish(), 0) << publisher;
    if (stops) {
      EXPECT_TRUE(publisher.ComesToSay("messages of lossless channels, such as \"images\", may be lost.")) << publisher;
    } else {
      EXPECT_FALSE(publisher.Says("may be lost")) << publisher;
      EXPECT_TRUE(subscriber.Reaches({{"received", 40}})) << subscriber;
    }
  };
  const std::uint16_t port = FreePort();
  const std::uint16_t other = FreePort();
  test::AtOnce({[&] { end(port, false); }, [&] { end(other, true); }});
}

TEST(LosslessSubscriber, GetsEveryMessageOnceAndInOrderIfItIsSlow) {
  const ScratchFolder folder;
  const std::string bus = folder.Ipc("bus");
  const WorkerProcess slow({Subscribing(bus), "--in=images", "--keep-all=8", "--slow-ms=1"});
  const WorkerProcess publisher({Publishing(bus), "--out=images", "--await=1", "--count=500", "--period-us=0"});
  ASSERT_TRUE(publisher.Reaches({{"published", 500}}, 2 * test::kPatience)) << publisher << slow;
  ExpectAll(slow, publisher, 500);
  EXPECT_EQ(slow["pushed_out"], 0U) << slow;
  EXPECT_GT(publisher["full"], 0U);
  EXPECT_EQ(publisher["dropped"] + publisher["refused"], 0U) << publisher;
}

TEST(LosslessSubscriber, LetsThePublisherContinueAndIsCountedAndNamedIfItIsKilled) {
  const ScratchFolder folder;
  const std::string bus = folder.Ipc("bus");
  for (const bool ipc : {true, false}) {
    std::optional<OwnDomain> domain;
    if (!ipc) domain.emplace();
    const WorkerProcess publisher(
        {ipc ? Publishing(bus, kImpatient) : "--config=", "--out=images", "--await=1", "--size=4096", "--period-us=0"});
    for (std::uint64_t life = 1; life <= (ipc ? 2 : 1); ++life) {
      WorkerProcess slow(
          {ipc ? Subscribing(bus, kImpatient) : "--config=", "--in=images", "--keep-all=8", "--slow-ms=20"});
      ASSERT_TRUE(slow.Reaches({{"received", 10}})) << publisher << slow;
      ASSERT_TRUE(publisher.Reaches({{"waiting", 1}})) << publisher;
      const std::uint64_t missed = publisher["missed"];
      slow.Kill();
      // The publisher waits up to 60 s for room. It can continue earlier only because the dead subscriber was dropped.
      ASSERT_TRUE(publisher.Gains("published", 1000)) << publisher;
      EXPECT_TRUE(Await([&] { return publisher["missed"] > missed && publisher["subscribers"] == 0; })) << publisher;
      if (ipc) {
        EXPECT_LE(publisher["missed"], missed + 8) << "more than its queue holds" << publisher;
      } else {
        EXPECT_TRUE(publisher.ComesToSay("has gone without confirming " + std::to_string(publisher["missed"]) +
                                         " messages of the lossless channel \"images\""))
            << publisher;
      }
    }
    EXPECT_EQ(publisher["refused"], 0U) << publisher;
  }
}

// Processes that are killed at any moment and started again.
class Restart : public testing::TestWithParam<std::string> {
 protected:
  Restart() {
    const bool ipc = GetParam() == "ipc";
    up = ipc ? folder.Ipc("up") : TcpEndpoint(FreePort());
    down = ipc ? folder.Ipc("down") : TcpEndpoint(FreePort());
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

TEST_P(Restart, NewProcessesWorkAtOnceAfterAllWereKilledAndEndInOrder) {
  for (int life = 0; life < 3; ++life) {
    WorkerProcess relay({Both(down, up), "--out=down", "--in=up"});
    const auto publisher = Publisher();
    const auto subscriber = Subscriber(true);
    ASSERT_TRUE(relay.Reaches({{"received", 20}})) << "life " << life << relay << *publisher;
    ASSERT_TRUE(subscriber->Reaches({{"received", 20}})) << "life " << life << relay << *subscriber;
    if (life < 2) continue;
    subscriber->Stop();
    publisher->Stop();
    EXPECT_EQ(relay.Finish(), 0) << "with peers that do not answer" << relay;
    publisher->Continue();
    EXPECT_EQ(publisher->Finish(), 0) << *publisher;
    subscriber->Continue();
    EXPECT_EQ(subscriber->Finish(), 0) << *subscriber;
  }
}

INSTANTIATE_TEST_SUITE_P(Over, Restart, testing::Values("ipc", "tcp"), [](const auto& test) { return test.param; });

}  // namespace
}  // namespace hgros::resilience
