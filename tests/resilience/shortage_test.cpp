// Processes that run out of memory, or that others would make run out of descriptors.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "resilience/places.hpp"
#include "resilience/small_group.hpp"
#include "resilience/worker_process.hpp"

namespace hgros::resilience {
namespace {

constexpr std::size_t kImageBytes = 24 << 20;
constexpr const char* kSpare = "--spare-mb=38";  // One such message, but not two.

std::vector<std::string> Talker(const std::string& config, const std::string& more) {
  return {config, "--out=images", "--await=1", "--size=" + std::to_string(kImageBytes), "--period-us=20000", kSpare,
          more};
}

TEST(PublisherWithoutMemory, GetsAStatusAndLives) {
  const ScratchFolder folder;
  const std::string bus = folder.Ipc("bus");
  WorkerProcess publisher(Talker(Publishing(bus), "--bulk=0"));
  const WorkerProcess subscriber({Subscribing(bus), "--in=images", "--keep-all=4"});
  EXPECT_TRUE(publisher.Reaches({{"no_memory", 3}})) << publisher;
  EXPECT_GE(publisher["refused"], 3U) << publisher;
  EXPECT_EQ(publisher.Finish(), 0) << publisher;
}

TEST(PublisherWithoutMemory, SendsBulkOverTheSocketWithoutACopy) {
  const OwnDomain domain;
  WorkerProcess publisher(Talker("--config=", "--bulk=1"));
  const WorkerProcess subscriber({"--config=", "--in=images", "--keep-all=4"});
  EXPECT_TRUE(subscriber.Reaches({{"received", 3}})) << publisher << subscriber;
  EXPECT_EQ(subscriber["gaps"] + subscriber["corrupt"], 0U) << subscriber;
  EXPECT_EQ(publisher["refused"], 0U) << publisher;
  EXPECT_EQ(publisher.Finish(), 0) << publisher;
}

// The kernel would kill a process of the group.
TEST(PublisherWithoutMemory, KeepsWhatReceiversOfItsControlGroupCopyFree) {
  const SmallGroup group(std::uint64_t{200} << 20);
  if (!group.why_not.empty()) GTEST_SKIP() << group.why_not;
  const OwnDomain domain;
  const std::string inside = "--group=" + group.folder;
  for (const bool bulk : {false, true}) {
    const auto talker = [&](int mb) -> std::vector<std::string> {
      return {"--config=",
              inside,
              "--out=images",
              "--await=1",
              "--size=" + std::to_string(mb << 20),
              "--period-us=20000",
              bulk ? "--bulk=1" : "--bulk=0"};
    };
    WorkerProcess publisher(talker(90));
    WorkerProcess subscriber({"--config=", inside, "--in=images", "--keep-all=4"});
    EXPECT_TRUE(publisher.Reaches({{"no_memory", 10}})) << publisher << subscriber;
    EXPECT_EQ(publisher.Finish(), 0) << publisher;
    EXPECT_EQ(subscriber.Finish(), 0) << subscriber;
    WorkerProcess fitting(talker(10));
    WorkerProcess receiver({"--config=", inside, "--in=images", "--keep-all=4"});
    EXPECT_TRUE(receiver.Reaches({{"received", 10}})) << fitting << receiver;
    EXPECT_EQ(fitting["no_memory"] + receiver["gaps"] + receiver["corrupt"], 0U) << fitting << receiver;
    EXPECT_EQ(fitting.Finish(), 0) << fitting;
    EXPECT_EQ(receiver.Finish(), 0) << receiver;
  }
}

TEST(SilentConnections, AreFewAndEndSoon) {
  const std::uint16_t port = FreePort();
  const WorkerProcess publisher({Publishing(TcpEndpoint(port)), "--out=images", "--size=64"});
  ASSERT_TRUE(publisher.Reaches({{"published", 10}})) << publisher;
  const std::size_t before = publisher.open_files();
  std::vector<int> silent;
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < 1100; ++i) {
    silent.push_back(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const sockaddr_in address = LoopbackAddress(port);
    (void)connect(silent.back(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
  }
  const WorkerProcess subscriber({Subscribing(TcpEndpoint(port)), "--in=images"});
  ASSERT_TRUE(subscriber.Reaches({{"received", 100}})) << publisher << subscriber;
  EXPECT_TRUE(test::Await([&] { return publisher.open_files() < before + 80; })) << publisher.open_files();
  constexpr auto kSoon = std::chrono::seconds(25);  // ZeroMQ's own limit is 30 s.
  EXPECT_TRUE(test::Await([&] { return publisher.open_files() <= before + 5; },
                          began + kSoon - std::chrono::steady_clock::now()))
      << publisher.open_files();
  EXPECT_TRUE(publisher.alive());
  for (const int one : silent) close(one);
}

}  // namespace
}  // namespace hgros::resilience
