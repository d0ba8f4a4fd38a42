// Networks that are slow, have a delay, stall or break.
#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>
#include <string>
#include <vector>

#include "conformance/tcp_forwarder.hpp"
#include "resilience/places.hpp"
#include "resilience/worker_process.hpp"
#include "support/at_once.hpp"
#include "support/cable.hpp"

namespace hgros::resilience {
namespace {

using conformance::TcpForwarder;
using test::Await;
using test::Linger;

/// A cable that is up, with at most 1 Gbit/s.
class Gigabit : public testing::Test {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
    const auto limit = [](const std::string& host, const std::string& device) {
      return test::Ip("netns exec " + host + " tc qdisc add dev " + device +
                      " root tbf rate 1gbit burst 64kb latency 50ms");
    };
    if (!cable.ready || !cable.Set("up") || !limit(cable.left, cable.left_interface) ||
        !limit(cable.right, cable.right_interface)) {
      GTEST_SKIP() << "no network namespaces with veth and tbf here";
    }
  }
  /// From the left to the right.
  void ExpectThat20ArriveIntact(const std::string& size) {
    subscriber.emplace(std::vector<std::string>{Subscribing("tcp://10.198.0.1:5553"), "--in=images", "--keep-all=4"},
                       cable.right);
    ASSERT_TRUE(subscriber->Reaches({{"ready", 1}})) << *subscriber;
    publisher.emplace(
        std::vector<std::string>{Publishing("tcp://*:5553"), "--out=images", "--await=1", "--count=20", size},
        cable.left);
    ExpectAll(*subscriber, *publisher, 20);
    EXPECT_EQ((*subscriber)["lost"] + (*subscriber)["repeated"], 0U) << *subscriber;
  }

  const test::Cable cable;
  std::optional<WorkerProcess> subscriber;
  std::optional<WorkerProcess> publisher;
};

TEST_F(Gigabit, LargeMessagesArriveIntactAtASubscriberThatStartedFirst) { ExpectThat20ArriveIntact("--size=4194304"); }

TEST_F(Gigabit, SessionsThatFindEachOtherButCannotShareMemoryUseTheNetwork) {
  // Both use one folder of locked files, but abstract unix sockets do not cross a network namespace.
  const OwnDomain domain;
  ExpectThat20ArriveIntact("--size=1000");
}

// The kernel would wait longer and longer for an answer: here from the 7th to the 15th second.
TEST(SilentCable, IsUsedSoonAfterItIsBack) {
  if (geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
  const test::Cable cable;
  if (!cable.ready || !cable.Set("up")) GTEST_SKIP() << "no network namespaces with veth here";
  const auto answers = [&](const char* how) {
    return test::Ip("-n " + cable.right + " route " + how + " blackhole 10.198.0.1/32");
  };
  // Since Linux 6.5 the first attempts follow each other sooner.
  (void)test::Ip("netns exec " + cable.left + " sh -c 'echo 0 >/proc/sys/net/ipv4/tcp_syn_linear_timeouts'");
  const WorkerProcess publisher({Publishing("tcp://*:5553"), "--out=images", "--size=1000"}, cable.right);
  ASSERT_TRUE(answers("add"));
  const WorkerProcess subscriber({Subscribing("tcp://10.198.0.2:5553"), "--in=images", "--keep-all=4"}, cable.left);
  ASSERT_TRUE(subscriber.Reaches({{"ready", 1}})) << subscriber;
  Linger(std::chrono::milliseconds(8500));
  EXPECT_EQ(subscriber["received"], 0U);
  ASSERT_TRUE(answers("del"));
  EXPECT_TRUE(subscriber.Reaches({{"received", 1}}, std::chrono::seconds(5))) << subscriber;
}

TEST(LongCable, DelaysMessagesByItsLengthAndLosesNone) {
  const std::uint16_t port = FreePort();
  TcpForwarder line(port, std::chrono::milliseconds(50));
  const WorkerProcess publisher(
      {Publishing(TcpEndpoint(port)), "--out=images", "--await=1", "--count=500", "--size=20000"});
  const WorkerProcess subscriber({Subscribing(TcpEndpoint(line.port())), "--in=images", "--keep-all=64"});
  ASSERT_TRUE(subscriber.Reaches({{"received", 500}})) << subscriber << publisher;
  EXPECT_EQ(subscriber["gaps"] + subscriber["disorder"] + subscriber["corrupt"], 0U) << subscriber;
  EXPECT_GE(subscriber["delay_ns"], 50'000'000U) << subscriber;
}

/// A busy machine may prolong an outage of seconds by some more. It still ends before a lossless peer is dropped.
constexpr const char* kPatient = ", peer_timeout_ms: 20000";

/// A publisher and a subscriber with a cable between them.
struct BrokenCable {
  void Start(const std::string& queue, const std::string& count, const std::string& more = {},
             const std::string& period = "--period-us=1000") {
    publisher.emplace(std::vector<std::string>{Publishing(TcpEndpoint(port), more), "--out=images", "--await=1", count,
                                               "--size=20000", period});
    subscriber.emplace(std::vector<std::string>{Subscribing(TcpEndpoint(cable.port()), more), "--in=images", queue});
  }
  void LosslessSubscriberMissesNothingAfterAStallOfTwoSecondsAndCutsOfOne() {
    Start("--keep-all=32", "--count=2000", kPatient);
    for (const std::uint64_t received : {200U, 700U, 1200U}) {
      ASSERT_TRUE(subscriber->Reaches({{"received", received}})) << *subscriber << *publisher;
      const bool stall = received == 200;
      if (stall) {
        cable.Stall();
      } else {
        cable.Cut();
      }
      ASSERT_TRUE(publisher->Reaches({{"waiting", 1}})) << *publisher;
      Linger(std::chrono::seconds(stall ? 2 : 1));
      EXPECT_LT((*publisher)["published"], 2000U) << "the publisher must wait";
      cable.Resume();
    }
    ExpectAll(*subscriber, *publisher, 2000);
  }
  void KeepLastSubscriberCountsTheMessagesLostInACut() {
    constexpr std::uint64_t kCount = 3500;  // Enough for a connection that comes back seconds after a cut.
    Start("--keep-last=500", "--count=" + std::to_string(kCount), {}, "--period-us=2000");
    for (const std::uint64_t received : {200U, 700U}) {
      ASSERT_TRUE(subscriber->Reaches({{"received", received}})) << *subscriber << *publisher;
      cable.Cut();
      Linger(std::chrono::seconds(1));
      cable.Resume();
      ASSERT_TRUE(subscriber->Gains("received", 100)) << *subscriber << *publisher;
    }
    ASSERT_TRUE(subscriber->Reaches({{"last", kCount}})) << *subscriber << *publisher;
    EXPECT_TRUE(publisher->Reaches({{"published", kCount}})) << *publisher;
    EXPECT_GT((*subscriber)["gaps"], 0U) << "two seconds were lost";
    EXPECT_EQ((*subscriber)["disorder"] + (*subscriber)["corrupt"], 0U) << *subscriber;
    EXPECT_TRUE(Await([&] { return (*subscriber)["came"] + (*subscriber)["lost"] >= kCount; }))  // Read before "last".
        << *subscriber;
    EXPECT_EQ((*subscriber)["came"] + (*subscriber)["lost"], kCount) << *subscriber << *publisher;
  }
  void NewMessagesArriveAfterAStallLongerThanThePeerTimeout(const std::string& queue) {
    Start(queue, "--count=0", kImpatient);
    ASSERT_TRUE(subscriber->Reaches({{"received", 100}})) << *subscriber << *publisher;
    cable.Stall();
    ASSERT_TRUE(Await([&] { return (*publisher)["subscribers"] == 0 && (*subscriber)["publishers"] == 0; }))
        << queue << *subscriber << *publisher;
    cable.Resume();
    ASSERT_TRUE(subscriber->Gains("received", 100)) << queue << *subscriber << *publisher;
    EXPECT_EQ((*subscriber)["disorder"] + (*subscriber)["corrupt"], 0U) << queue << *subscriber;
    publisher.reset();
  }

  const std::uint16_t port = FreePort();
  TcpForwarder cable{port};
  std::optional<WorkerProcess> publisher;
  std::optional<WorkerProcess> subscriber;
};

TEST(BrokenCable, LosesNothingThatItNeedNotLose) {
  BrokenCable one, two, three, four;
  test::AtOnce({[&] { one.LosslessSubscriberMissesNothingAfterAStallOfTwoSecondsAndCutsOfOne(); },
                [&] { two.KeepLastSubscriberCountsTheMessagesLostInACut(); },
                [&] { three.NewMessagesArriveAfterAStallLongerThanThePeerTimeout("--keep-last=32"); },
                [&] { four.NewMessagesArriveAfterAStallLongerThanThePeerTimeout("--keep-all=32"); }});
}

}  // namespace
}  // namespace hgros::resilience
