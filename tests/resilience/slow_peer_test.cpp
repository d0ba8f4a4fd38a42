// Subscribers that are stopped, slow or killed while a publisher is at work.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <regex>
#include <sstream>
#include <string>

#include "hgros/base/ids.hpp"
#include "resilience/places.hpp"
#include "resilience/worker_process.hpp"

namespace hgros::resilience {
namespace {

using test::Await;

constexpr std::size_t kLargeBytes = 256 * 1024;

TEST(StoppedSubscriber, DelaysNoOthersAndUsesLimitedMemoryOfThePublisher) {
  const ScratchFolder folder;
  const std::string bus = folder.Endpoint("bus");
  // Longer than this may take on a busy machine. Otherwise the stopped subscriber is dropped meanwhile.
  const std::string patient = ", peer_timeout_ms: 120000";
  const WorkerProcess publisher({Publishing(bus, ", peer_queue_bytes: 4MiB" + patient), "--out=images", "--await=2",
                                 "--size=" + std::to_string(kLargeBytes), "--count=2000", "--period-us=2000"});
  const WorkerProcess other({Subscribing(bus, patient), "--in=images", "--keep-all=16"});
  const WorkerProcess stopped({Subscribing(bus, patient), "--in=images", "--keep-last=1000"});
  ASSERT_TRUE(stopped.Reaches({{"received", 50}})) << publisher << stopped;
  stopped.Stop();
  const std::size_t before = publisher.resident_bytes();
  std::size_t most = before;
  // 500 MB are published in this time.
  ASSERT_TRUE(Await(
      [&] {
        most = std::max(most, publisher.resident_bytes());
        return publisher["published"] == 2000;
      },
      3 * test::kPatience))
      << publisher << other;
  ASSERT_TRUE(other.Reaches({{"received", 2000}})) << publisher << other;
  EXPECT_EQ(other["gaps"] + other["disorder"] + other["corrupt"], 0U) << other;
  // The messages in the ring, those in the socket (limited by credit), and some room for the allocator.
  EXPECT_LE(most, before + (4 << 20) + 64 * kLargeBytes + (24 << 20)) << before << " before" << publisher;
  EXPECT_LE(publisher["queued_bytes"], (4U << 20) + kLargeBytes);
  EXPECT_GT(publisher["dropped"], 1000U) << publisher;
  stopped.Continue();
  ASSERT_TRUE(stopped.Reaches({{"last", 2000}})) << publisher << stopped;
  EXPECT_EQ(stopped["disorder"] + stopped["corrupt"], 0U) << stopped;
  EXPECT_TRUE(Await([&] { return stopped["came"] + stopped["lost"] >= 2000; })) << stopped;  // Read before "last".
  EXPECT_EQ(stopped["came"] + stopped["lost"], 2000U) << stopped;
  EXPECT_EQ(stopped["lost"], publisher["dropped"]) << publisher << stopped;
}

TEST(StoppedSubscriber, ReceivesAgainAfterItWasDropped) {
  for (const bool ipc : {true, false}) {
    const ScratchFolder folder;
    const std::string bus = ipc ? folder.Endpoint("bus") : TcpEndpoint(FreePort());
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

TEST(StoppedSubscriber, IsNamedWithTheNumberOfLosslessMessagesThatItMissed) {
  const ScratchFolder folder;
  for (const bool ipc : {true, false}) {
    setenv("HGROS_DOMAIN", ipc ? "none" : ("test-" + SessionId::Random().ToString()).c_str(), 1);
    const std::string bus = folder.Endpoint("bus");
    const std::string shared = "--config=network: {heartbeat_ms: 100, peer_timeout_ms: 2000}";
    const WorkerProcess publisher(
        {ipc ? Publishing(bus, kImpatient) : shared, "--out=images", "--await=1", "--size=4096"});
    const WorkerProcess stopped({ipc ? Subscribing(bus, kImpatient) : shared, "--in=images", "--keep-all=16"});
    ASSERT_TRUE(stopped.Reaches({{"received", 50}})) << publisher << stopped;
    stopped.Stop();
    ASSERT_TRUE(Await([&] { return publisher["subscribers"] == 0; })) << publisher;
    ASSERT_TRUE(publisher.Gains("published", 300)) << publisher;
    stopped.Continue();
    ASSERT_TRUE(Await([&] { return stopped["gaps"] > 0; })) << publisher << stopped;
    const auto log = [&] {
      std::ostringstream all;
      all << publisher;
      return all.str();
    };
    EXPECT_NE(log().find(" has gone without confirming "), std::string::npos) << publisher;
    std::smatch found;
    std::string text;
    const std::regex total("has missed up to ([0-9]+) messages of the lossless channel \"images\", and is back\\.");
    ASSERT_TRUE(Await([&] {
      text = log();
      return std::regex_search(text, found, total);
    })) << publisher
        << stopped;
    const std::uint64_t missed = std::stoull(found[1]);
    EXPECT_GE(missed, stopped["gaps"]) << publisher << stopped;
    EXPECT_LE(missed, stopped["gaps"] + 16) << "its queue may have arrived unconfirmed" << publisher << stopped;
    EXPECT_TRUE(Await([&] { return publisher["missed"] == missed; })) << publisher;
    std::ostringstream said;
    said << stopped;
    EXPECT_NE(said.str().find(" did not arrive: the connection to their publisher was lost"), std::string::npos)
        << stopped;
  }
  setenv("HGROS_DOMAIN", "none", 1);
}

TEST(StoppedSubscriber, MissesNothingIfItIsLosslessAndContinuesInTime) {
  const ScratchFolder folder;
  const std::string bus = folder.Endpoint("bus");
  const WorkerProcess publisher(
      {Publishing(bus), "--out=images", "--await=1", "--count=1000", "--size=65536", "--period-us=100"});
  const WorkerProcess stopped({Subscribing(bus), "--in=images", "--keep-all=16"});
  ASSERT_TRUE(stopped.Reaches({{"received", 50}})) << publisher << stopped;
  stopped.Stop();
  ASSERT_TRUE(publisher.Reaches({{"waiting", 1}})) << publisher;
  stopped.Continue();
  ASSERT_TRUE(stopped.Reaches({{"received", 1000}})) << publisher << stopped;
  EXPECT_EQ(stopped["first"], 1U);
  EXPECT_EQ(stopped["last"], 1000U);
  EXPECT_EQ(stopped["gaps"] + stopped["disorder"] + stopped["corrupt"], 0U) << stopped;
  EXPECT_EQ(publisher["missed"], 0U);
}

// More than the buffers of the connection hold, and less than its credit: ZeroMQ has the rest.
TEST(StoppedSubscriber, IsToldOfAtTheEndOfAPublisherThatCannotSendAll) {
  for (const bool stops : {false, true}) {
    const std::uint16_t port = FreePort();
    WorkerProcess publisher({Publishing(TcpEndpoint(port)), "--out=images", "--await=1",
                             "--size=" + std::to_string(2 * kLargeBytes), "--count=40", "--period-us=20000"});
    const WorkerProcess subscriber({Subscribing(TcpEndpoint(port)), "--in=images", "--keep-all=64"});
    ASSERT_TRUE(subscriber.Reaches({{"received", 1}})) << publisher << subscriber;
    if (stops) subscriber.Stop();
    ASSERT_TRUE(publisher.Reaches({{"published", 40}})) << publisher;
    // The rest can be sent before the publisher gives up, also on a busy machine.
    ASSERT_TRUE(stops || subscriber.Reaches({{"received", 36}})) << publisher << subscriber;
    EXPECT_EQ(publisher.Finish(), 0) << publisher;
    std::ostringstream out;
    EXPECT_TRUE(Await([&] {
      out.str({});
      out << publisher;
      return !stops ||
             out.str().find("messages of lossless channels, such as \"images\", may be lost.") != std::string::npos;
    })) << publisher;
    EXPECT_EQ(out.str().find("may be lost") != std::string::npos, stops) << publisher;
    if (!stops) {
      EXPECT_TRUE(subscriber.Reaches({{"received", 40}})) << subscriber;
    }
  }
}

TEST(LosslessSubscriber, GetsEveryMessageOnceAndInOrderIfItIsSlow) {
  const ScratchFolder folder;
  const std::string bus = folder.Endpoint("bus");
  const WorkerProcess slow({Subscribing(bus), "--in=images", "--keep-all=8", "--slow-ms=1"});
  const WorkerProcess publisher({Publishing(bus), "--out=images", "--await=1", "--count=1500", "--period-us=0"});
  ASSERT_TRUE(publisher.Reaches({{"published", 1500}}, 2 * test::kPatience)) << publisher << slow;
  ASSERT_TRUE(slow.Reaches({{"received", 1500}})) << publisher << slow;
  EXPECT_EQ(slow["first"], 1U);
  EXPECT_EQ(slow["last"], 1500U);
  EXPECT_EQ(slow["gaps"] + slow["disorder"] + slow["corrupt"] + slow["pushed_out"], 0U) << slow;
  EXPECT_GT(publisher["full"], 0U);
  EXPECT_EQ(publisher["missed"] + publisher["dropped"] + publisher["refused"], 0U) << publisher;
}

TEST(LosslessSubscriber, LetsThePublisherContinueAndIsCountedIfItIsKilled) {
  const ScratchFolder folder;
  const std::string bus = folder.Endpoint("bus");
  const WorkerProcess publisher(
      {Publishing(bus, kImpatient), "--out=images", "--await=1", "--size=4096", "--period-us=0"});
  for (std::uint64_t life = 1; life <= 3; ++life) {
    WorkerProcess slow({Subscribing(bus, kImpatient), "--in=images", "--keep-all=8", "--slow-ms=20"});
    ASSERT_TRUE(slow.Reaches({{"received", 10}})) << publisher << slow;
    ASSERT_TRUE(publisher.Reaches({{"waiting", 1}})) << publisher;
    const std::uint64_t missed = publisher["missed"];
    slow.Kill();
    // The publisher waits up to 60 s for room. It can continue earlier only because the dead subscriber was dropped.
    ASSERT_TRUE(publisher.Gains("published", 1000)) << publisher;
    EXPECT_TRUE(Await([&] { return publisher["missed"] > missed && publisher["subscribers"] == 0; })) << publisher;
    EXPECT_LE(publisher["missed"], missed + 8) << "more than its queue holds" << publisher;
  }
  EXPECT_EQ(publisher["refused"], 0U) << publisher;
}

TEST(LosslessSubscriber, IsNamedWithTheMessagesThatItMissesIfItIsKilledOnTheSameHost) {
  setenv("HGROS_DOMAIN", ("test-" + SessionId::Random().ToString()).c_str(), 1);
  const WorkerProcess publisher({"--config=", "--out=images", "--await=1", "--size=4096", "--period-us=0"});
  WorkerProcess slow({"--config=", "--in=images", "--keep-all=8", "--slow-ms=20"});
  ASSERT_TRUE(slow.Reaches({{"received", 10}})) << publisher << slow;
  ASSERT_TRUE(publisher.Reaches({{"waiting", 1}})) << publisher;
  slow.Kill();
  const std::regex line("has gone without confirming ([0-9]+) messages of the lossless channel \"images\"");
  std::smatch found;
  std::string text;
  ASSERT_TRUE(Await([&] {
    std::ostringstream all;
    all << publisher;
    text = all.str();
    return publisher["missed"] > 0 && std::regex_search(text, found, line);
  })) << publisher;
  EXPECT_EQ(std::stoull(found[1]), publisher["missed"]) << publisher;
  setenv("HGROS_DOMAIN", "none", 1);
}

}  // namespace
}  // namespace hgros::resilience
