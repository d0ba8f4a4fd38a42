// Networks that are slow, have a delay, stall or break.
#include <gtest/gtest.h>
#include <sys/types.h>
#include <unistd.h>

#include <cstdlib>
#include <optional>

#include "conformance/tcp_forwarder.hpp"
#include "hgros/base/ids.hpp"
#include "resilience/delay_line.hpp"
#include "resilience/places.hpp"
#include "resilience/worker_process.hpp"
#include "support/cable.hpp"

namespace hgros::resilience {
namespace {

using conformance::TcpForwarder;
using test::Await;
using test::Linger;

/// Two network namespaces, named after this process, and the cable between them, at 1 Gbit/s. They are removed at the
/// end. The next test removes those that a killed process has left.
class GigabitCable {
 public:
  GigabitCable() : left("hgrl" + std::to_string(getpid())), right("hgrr" + std::to_string(getpid())) {
    test::RemoveLeftNamespaces();
    const std::string left_end = "vl" + std::to_string(getpid());
    const std::string right_end = "vr" + std::to_string(getpid());
    ready = RunCommand({"ip", "netns", "add", left}) == 0 && RunCommand({"ip", "netns", "add", right}) == 0 &&
            RunCommand({"ip", "link", "add", left_end, "netns", left, "type", "veth", "peer", "name", right_end,
                        "netns", right}) == 0 &&
            Configure(left, left_end, "10.197.0.1/24") && Configure(right, right_end, "10.197.0.2/24");
  }
  GigabitCable(const GigabitCable&) = delete;
  GigabitCable& operator=(const GigabitCable&) = delete;
  ~GigabitCable() {
    (void)RunCommand({"ip", "netns", "del", left});
    (void)RunCommand({"ip", "netns", "del", right});
  }

  const std::string left;
  const std::string right;
  bool ready = false;

 private:
  static bool Configure(const std::string& where, const std::string& device, const std::string& address) {
    return RunCommand({"ip", "-n", where, "addr", "add", address, "dev", device}) == 0 &&
           RunCommand({"ip", "-n", where, "link", "set", device, "up"}) == 0 &&
           RunCommand({"ip", "netns", "exec", where, "tc", "qdisc", "add", "dev", device, "root", "tbf", "rate",
                       "1gbit", "burst", "64kb", "latency", "50ms"}) == 0;
  }
};

TEST(Gigabit, LargeMessagesArriveIntactAtASubscriberThatStartedFirst) {
  if (geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
  const GigabitCable cable;
  if (!cable.ready) GTEST_SKIP() << "no network namespaces with veth and tbf here";
  const WorkerProcess subscriber({Subscribing("tcp://10.197.0.1:5553"), "--in=images", "--keep-all=4"}, cable.right);
  ASSERT_TRUE(subscriber.Reaches({{"ready", 1}})) << subscriber;
  const WorkerProcess publisher(
      {Publishing("tcp://*:5553"), "--out=images", "--await=1", "--count=40", "--size=4194304"}, cable.left);
  ASSERT_TRUE(subscriber.Reaches({{"received", 40}}, 2 * test::kPatience)) << subscriber << publisher;
  EXPECT_EQ(subscriber["first"], 1U);
  EXPECT_EQ(subscriber["last"], 40U);
  EXPECT_EQ(subscriber["gaps"] + subscriber["disorder"] + subscriber["corrupt"] + subscriber["lost"], 0U) << subscriber;
  EXPECT_EQ(publisher["missed"], 0U) << publisher;
}

TEST(Gigabit, SessionsThatFindEachOtherButCannotShareMemoryUseTheNetwork) {
  if (geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
  const GigabitCable cable;
  if (!cable.ready) GTEST_SKIP() << "no network namespaces with veth and tbf here";
  // Both use one folder of locked files, but abstract unix sockets do not cross a network namespace.
  setenv("HGROS_DOMAIN", ("test-" + SessionId::Random().ToString()).c_str(), 1);
  const WorkerProcess subscriber({Subscribing("tcp://10.197.0.1:5553"), "--in=images", "--keep-all=4"}, cable.right);
  ASSERT_TRUE(subscriber.Reaches({{"ready", 1}})) << subscriber;
  const WorkerProcess publisher({Publishing("tcp://*:5553"), "--out=images", "--await=1", "--count=40", "--size=1000"},
                                cable.left);
  setenv("HGROS_DOMAIN", "none", 1);
  ASSERT_TRUE(subscriber.Reaches({{"received", 40}}, 2 * test::kPatience)) << subscriber << publisher;
  EXPECT_EQ(subscriber["gaps"] + subscriber["disorder"] + subscriber["corrupt"] + subscriber["lost"], 0U) << subscriber;
  EXPECT_EQ(subscriber["repeated"], 0U) << subscriber;
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
  DelayLine line(port, std::chrono::milliseconds(50));
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
class BrokenCable : public testing::Test {
 protected:
  void Start(const std::string& queue, const std::string& count, const std::string& more = {}) {
    publisher.emplace(std::vector<std::string>{Publishing(TcpEndpoint(port), more), "--out=images", "--await=1", count,
                                               "--size=20000"});
    subscriber.emplace(std::vector<std::string>{Subscribing(TcpEndpoint(cable.port()), more), "--in=images", queue});
  }
  /// Expects that all `count` messages have come, once and in order.
  void ExpectAll(std::uint64_t count) const {
    ASSERT_TRUE(subscriber->Reaches({{"received", count}})) << *subscriber << *publisher;
    EXPECT_EQ((*subscriber)["first"], 1U);
    EXPECT_EQ((*subscriber)["last"], count);
    EXPECT_EQ((*subscriber)["gaps"] + (*subscriber)["disorder"] + (*subscriber)["corrupt"], 0U) << *subscriber;
    EXPECT_EQ((*publisher)["missed"], 0U) << *publisher;
  }

  const std::uint16_t port = FreePort();
  TcpForwarder cable{port};
  std::optional<WorkerProcess> publisher;
  std::optional<WorkerProcess> subscriber;
};

TEST_F(BrokenCable, LosslessSubscriberMissesNothingAfterAStallOfTwoSeconds) {
  Start("--keep-all=32", "--count=1500", kPatient);
  ASSERT_TRUE(subscriber->Reaches({{"received", 200}})) << *subscriber << *publisher;
  cable.Stall();
  ASSERT_TRUE(publisher->Reaches({{"waiting", 1}})) << *publisher;
  Linger(std::chrono::seconds(2));
  const std::uint64_t before = (*publisher)["published"];
  EXPECT_LT(before, 1500U) << "the publisher must wait";
  cable.Resume();
  ExpectAll(1500);
}

TEST_F(BrokenCable, LosslessSubscriberMissesNothingAfterACutOfOneSecond) {
  Start("--keep-all=32", "--count=1500", kPatient);
  for (const std::uint64_t received : {200U, 700U}) {
    ASSERT_TRUE(subscriber->Reaches({{"received", received}})) << *subscriber << *publisher;
    cable.Cut();
    ASSERT_TRUE(publisher->Reaches({{"waiting", 1}})) << *publisher;
    Linger(std::chrono::seconds(1));
    cable.Resume();
  }
  ExpectAll(1500);
}

TEST_F(BrokenCable, KeepLastSubscriberCountsTheMessagesLostInACut) {
  constexpr std::uint64_t kCount = 7000;  // Enough for a connection that comes back seconds after a cut.
  Start("--keep-last=1000", "--count=" + std::to_string(kCount));
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

TEST_F(BrokenCable, NewMessagesArriveAfterAStallLongerThanThePeerTimeout) {
  for (const std::string queue : {"--keep-last=32", "--keep-all=32"}) {
    Start(queue, "--count=0", kImpatient);
    ASSERT_TRUE(subscriber->Reaches({{"received", 100}})) << *subscriber << *publisher;
    cable.Stall();
    ASSERT_TRUE(Await([&] { return (*publisher)["subscribers"] == 0 && (*subscriber)["publishers"] == 0; }))
        << queue << *subscriber << *publisher;
    cable.Resume();
    ASSERT_TRUE(subscriber->Gains("received", 100)) << queue << *subscriber << *publisher;
    EXPECT_EQ((*subscriber)["disorder"] + (*subscriber)["corrupt"], 0U) << queue << *subscriber;
    subscriber.reset();
    publisher.reset();
  }
}

}  // namespace
}  // namespace hgros::resilience
