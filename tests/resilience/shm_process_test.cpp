// Processes that share memory and are killed, stopped and forked while they do.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <list>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <thread>

#include "conformance/transport_conformance.hpp"
#include "resilience/shm_numbers.hpp"
#include "resilience/small_group.hpp"
#include "resilience/worker_process.hpp"
#include "support/await.hpp"
#include "support/seed.hpp"

namespace hgros::resilience {
namespace {

using conformance::OpenFiles;
using test::Await;

std::uint64_t Setting(const char* name, std::uint64_t otherwise) {
  const char* value = std::getenv(name);
  return value == nullptr ? otherwise : std::stoull(value);
}

/// Number of mapped pages that belong to pairs, our own and those of peers.
std::size_t PairMappings() {
  std::ifstream maps("/proc/self/maps");
  std::size_t count = 0;
  for (std::string line; std::getline(maps, line);) {
    count += line.find("memfd:hgros-") != std::string::npos && line.find("hgros-bell") == std::string::npos &&
                     line.find("rw-s") == std::string::npos
                 ? 1
                 : 0;
    count += line.find("hgros-lane") != std::string::npos || line.find("hgros-slip") != std::string::npos ? 1 : 0;
  }
  return count;
}

/// Files in /dev/shm. Other tests may run at the same time, but none of them leaves files either.
std::set<std::string> SharedFiles() {
  std::set<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev/shm", error)) names.insert(entry.path());
  return names;
}

/// A session that publishes "down" and subscribes to "up", without loss, while workers come and go.
class ShmProcesses : public testing::Test {
 protected:
  ShmProcesses() {
    ShmOptions options = NumberOptions("hub");
    options.place = place;
    hub = MakeShmTransport(options, listener, log);
    down.emplace(*hub, "down");
    inbound = hub->Subscribe("up", NumberType(), {.lossless = true}, up);
    (void)down->channel().stats();
    open_files = OpenFiles();
    publishing = std::jthread([this](const std::stop_token& stop) {
      while (down->PublishNext(stop)) {
      }
    });
  }
  /// Expects that all workers have gone and that nothing of them is left.
  void ExpectNothingLeft() {
    EXPECT_TRUE(Await([&] { return hub->Peers().empty() && down->channel().subscriber_count() == 0; }));
    EXPECT_TRUE(Await([&] { return up.publishers == 0; }));
    publishing = {};
    inbound.reset();
    up.LetGo();
    EXPECT_TRUE(Await([&] { return hub->usage().blocks_in_use == 0; })) << hub->usage().blocks_in_use;
    // A segment without used blocks keeps its file descriptor, for the next message.
    EXPECT_TRUE(Await([&] { return OpenFiles() == open_files + hub->usage().segments; }))
        << OpenFiles() << " instead of " << open_files << " and " << hub->usage().segments;
    EXPECT_TRUE(Await([&] { return PairMappings() == 0; })) << PairMappings();
    EXPECT_LE(hub->usage().segment_bytes, NumberOptions("").limit_bytes);
    EXPECT_TRUE(Await([&] { return std::ranges::includes(shared_files, SharedFiles()); }));
  }

  const std::string place = "hgros-test-" + SessionId::Random().ToString();
  QuietListener listener;
  Log log{[](LogLevel, std::string_view) {}};
  NumberSink up;
  std::unique_ptr<ShmTransport> hub;
  std::optional<NumberStream> down;
  std::unique_ptr<InboundChannel> inbound;
  const std::set<std::string> shared_files = SharedFiles();
  std::size_t open_files = 0;
  std::jthread publishing;
};

TEST_F(ShmProcesses, KilledProcessesTakeNothingFromOthers) {
  const std::uint64_t rounds = Setting("HGROS_SHM_KILLS", 100);
  std::minstd_rand random(test::Seed());
  {
    WorkerProcess survivor({place, "work"});
    ASSERT_TRUE(survivor.Reaches({{"received", 100}, {"published", 100}})) << survivor;
    std::list<WorkerProcess> victims;
    for (std::uint64_t round = 0; round < rounds; ++round) {
      const std::uint64_t before = up.received;
      while (victims.size() < 2) victims.emplace_back(std::vector<std::string>{place, "work"});
      if (random() % 4 != 0) {
        ASSERT_TRUE(victims.back().Reaches({{"received", 10}, {"published", 10}})) << victims.back();
      }
      test::Linger(std::chrono::microseconds(random() % 20'000));
      victims.pop_front();  // Kills it.
      ASSERT_TRUE(Await([&] { return up.received > before; }));
      ASSERT_TRUE(survivor.Gains("received", 10)) << survivor;
      ASSERT_EQ(survivor["faults"], 0u) << survivor;
      ASSERT_EQ(up.faults, 0u);
    }
    victims.clear();
    ASSERT_TRUE(survivor.Gains("received", 100)) << survivor;
    ASSERT_TRUE(survivor.Gains("published", 100)) << survivor;
    EXPECT_EQ(survivor["faults"], 0u) << survivor;
  }
  EXPECT_EQ(up.faults, 0u);
  ExpectNothingLeft();
}

TEST_F(ShmProcesses, AStoppedProcessDoesNotStopOthersAndComesBack) {
  {
    WorkerProcess survivor({place, "work"});
    WorkerProcess stopped({place, "work"});
    ASSERT_TRUE(survivor.Reaches({{"received", 100}})) << survivor;
    ASSERT_TRUE(stopped.Reaches({{"received", 100}})) << stopped;
    for (int round = 0; round < test::Rounds(1, 2); ++round) {
      const int gone = listener.gone;
      stopped.Stop();
      ASSERT_TRUE(survivor.Gains("published", 100)) << survivor;
      ASSERT_TRUE(Await([&] { return listener.gone > gone; })) << "a process has stopped and no peer has noticed it";
      ASSERT_TRUE(survivor.Gains("received", 1000)) << survivor;
      // It held messages all the time, and still holds them when it connects again.
      stopped.Continue();
      ASSERT_TRUE(stopped.Gains("received", 1000)) << stopped;
    }
    EXPECT_EQ(survivor["faults"], 0u) << survivor;
  }
  ExpectNothingLeft();
}

TEST_F(ShmProcesses, AForkedChildThatOutlivesItsParentBlocksNobody) {
  pid_t child = 0;
  {
    WorkerProcess parent({place, "fork"});
    ASSERT_TRUE(parent.Reaches({{"child", 1}})) << parent;
    ASSERT_TRUE(parent.Gains("received", 1000)) << parent;
    ASSERT_TRUE(parent.Gains("published", 100)) << parent;
    EXPECT_EQ(parent["faults"], 0u) << parent;
    EXPECT_EQ(listener.gone, 0);
    child = static_cast<pid_t>(parent["child"]);
    parent.Kill();
    EXPECT_EQ(kill(child, 0), 0);
    ExpectNothingLeft();
    kill(child, SIGKILL);
  }
}

TEST_F(ShmProcesses, AProcessThatEndsInOrderLeavesNothingAndCausesNoFaults) {
  {
    WorkerProcess worker({place, "work"});
    ASSERT_TRUE(worker.Reaches({{"received", 100}, {"published", 100}})) << worker;
    EXPECT_EQ(worker.Finish(), 0) << worker;
  }
  EXPECT_EQ(up.faults, 0u);
  ExpectNothingLeft();
}

TEST_F(ShmProcesses, ManySmallMessagesNeedNoMoreMemoryThanFew) {
  const std::uint64_t messages = Setting("HGROS_SHM_SOAK", 1'000'000);
  publishing = {};
  down.reset();
  inbound.reset();
  QuietListener other_listener;
  ShmOptions options = NumberOptions("listener");
  options.peers = {place};
  NumberSink sink;
  {
    const auto other = MakeShmTransport(options, other_listener, log);
    const auto received = other->Subscribe("down", NumberType(), {.lossless = true}, sink);
    NumberStream stream(*hub, "down", 200);
    const auto resident = [] {
      std::ifstream file("/proc/self/statm");
      std::size_t pages = 0;
      file >> pages >> pages;
      return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    };
    const auto publish = [&](std::uint64_t until) {
      while (stream.published < until) ASSERT_TRUE(stream.PublishNext({}));
      ASSERT_TRUE(Await([&] { return sink.received == until; })) << sink.received;
    };
    publish(messages / 10);
    [[maybe_unused]] const std::size_t before = resident();
    const auto segments = hub->usage().segments;
    const std::size_t files = OpenFiles();
    publish(messages);
#if !defined(__SANITIZE_ADDRESS__)  // AddressSanitizer keeps freed memory for a while.
    EXPECT_LT(resident(), before + (4 << 20));
#endif
    EXPECT_EQ(hub->usage().segments, segments);
    EXPECT_EQ(OpenFiles(), files);
    EXPECT_EQ(sink.faults, 0u);
  }
}

// A publisher in a memory control group that is too small for its shared memory.
constexpr std::uint64_t kGroupBytes = 48u << 20;
constexpr auto kSameLineAgainAfter = std::chrono::seconds(10);  // The same as in Log::WriteLimited.

TEST(ShmMemoryGroupProcess, AFullGroupKillsNoProcessAndMessagesGoOverTheSocket) {
  const SmallGroup group(kGroupBytes);
  if (!group.why_not.empty()) GTEST_SKIP() << group.why_not;
  QuietListener listener;
  Log log{[](LogLevel, std::string_view) {}};
  ShmOptions options = NumberOptions("hub");
  options.place = "hgros-test-" + SessionId::Random().ToString();
  const auto hub = MakeShmTransport(options, listener, log);
  NumberStream down(*hub, "down", 100);
  NumberSink hoard(std::numeric_limits<std::size_t>::max());
  // Not lossless: otherwise the publisher would keep unconfirmed messages, including those that went over the socket.
  const auto up =
      hub->Subscribe("up", NumberType(), {.credit_messages = 512, .credit_bytes = std::uint64_t{1} << 30}, hoard);
  WorkerProcess worker({options.place, group.folder});
  // All messages together need more memory than the group may have.
  constexpr std::uint64_t kMessages = 2 * kGroupBytes / 500'000;
  std::uint64_t published = 0;
  const auto publish = [&](std::uint64_t until) {
    while (published < until) {
      ASSERT_TRUE(down.PublishNext({}));
      ++published;
      ASSERT_TRUE(Await([&] { return hoard.received == published; })) << published << worker;
      ASSERT_TRUE(worker.alive()) << worker;
    }
    ASSERT_TRUE(worker.Reaches({{"published", until}})) << worker;
  };
  const auto begin = std::chrono::steady_clock::now();
  publish(kMessages);
  // On a busy machine this may take longer than the time for which the log suppresses the same line.
  const auto lines = 1 + static_cast<std::uint64_t>((std::chrono::steady_clock::now() - begin) / kSameLineAgainAfter);
  EXPECT_GT(worker["apart"], kMessages / 4) << worker;
  EXPECT_LT(worker["apart"], kMessages) << worker;
  EXPECT_GE(worker["warnings"], 1u) << worker;
  EXPECT_LE(worker["warnings"], lines) << "logged once, not for each message" << worker;
  // Released blocks are used again from the second message on: the publisher notices them with the first one.
  hoard.LetGo();
  publish(kMessages + 1);
  const std::uint64_t apart = worker["apart"];
  publish(kMessages + 11);
  EXPECT_EQ(worker["apart"], apart) << worker;
  EXPECT_EQ(worker.Finish(), 0) << worker;
}

}  // namespace
}  // namespace hgros::resilience
