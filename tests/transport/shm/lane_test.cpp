#include <gtest/gtest.h>
#include <sys/socket.h>

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "support/await.hpp"
#include "transport/shm/memory/lane_reader.hpp"
#include "transport/shm/memory/lane_writer.hpp"

namespace hgros::shm {
namespace {

/// Both ends of the way from one session to another.
struct Lane {
  Lane() {
    std::string fault;
    int ends[2];
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
    far_end = Handle(ends[1]);
    slip = Slip::Make(std::make_shared<const Handle>(ends[0]), std::make_shared<const ForkGuard>(), fault);
    writer = LaneWriter::Make(fault);
    EXPECT_TRUE(writer->Open(*slip->handle(), fault)) << fault;
    reader = LaneReader::Open(*writer->handle(), fault);
    slip->SetPublisher(reader->mapping(), PeerBell::Open(*bell.handle(), 5, fault));
  }
  SessionBell bell{Patience{}};  // The publisher's.
  Handle far_end;
  std::shared_ptr<Slip> slip;
  std::unique_ptr<LaneWriter> writer;
  std::unique_ptr<LaneReader> reader;
};

Descriptor Numbered(std::uint64_t number) {
  Descriptor descriptor{};
  descriptor.number = number;
  descriptor.size_bytes = number * 3;
  return descriptor;
}

TEST(ShmLane, AgreesWithAModelForAnyOrderOfReturns) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::minstd_rand random(seed);
    Lane lane;
    std::deque<std::uint64_t> unread;                           // Model of the ring.
    std::vector<std::pair<std::uint32_t, std::uint64_t>> held;  // Slot and number, read and not returned.
    std::vector<std::weak_ptr<const void>> owners{{}};          // By number.
    std::vector<bool> returned{false};
    std::uint64_t written = 0;
    for (int step = 0; step < 20'000; ++step) {
      switch (random() % 4) {
        case 0: {
          ASSERT_EQ(lane.writer->HasSlot(), lane.writer->held() < kSlots);
          if (!lane.writer->HasSlot()) break;
          auto owner = std::make_shared<const std::uint64_t>(++written);
          owners.push_back(owner);
          returned.push_back(false);
          lane.writer->Write(Numbered(written), std::move(owner));
          unread.push_back(written);
          break;
        }
        case 1: {
          Descriptor read;
          const auto answer = lane.reader->Peek(read);
          ASSERT_EQ(answer, unread.empty() ? LaneReader::Read::kNothing : LaneReader::Read::kDescriptor);
          if (unread.empty()) break;
          ASSERT_EQ(read.number, unread.front());
          ASSERT_EQ(read.size_bytes, read.number * 3);
          unread.pop_front();
          lane.reader->Next();
          lane.slip->Hold();
          held.emplace_back(read.slot, read.number);
          break;
        }
        case 2: {
          if (held.empty() || random() % 3 == 0) break;
          std::swap(held[random() % held.size()], held.back());
          lane.slip->Return(held.back().first);
          returned[held.back().second] = true;
          held.pop_back();
          ASSERT_EQ(lane.slip->held(), held.size());
          break;
        }
        default: {
          std::vector<std::shared_ptr<const void>> ended;
          ASSERT_TRUE(lane.writer->Collect(ended));
          ended.clear();
          ASSERT_EQ(lane.writer->held(), unread.size() + held.size());
          for (std::size_t i = 1; i < owners.size(); ++i) ASSERT_EQ(owners[i].expired(), returned[i]) << i;
          if (owners.size() > 3000) step = 20'000;
        }
      }
    }
  }
}

TEST(ShmLane, SlotsReturnedBySeveralThreadsWakeTheWriter) {
  for (const int threads : {1, 2, 4}) {
    Lane lane;
    constexpr std::uint64_t kMessages = 30'000;
    std::mutex mutex;
    std::vector<std::uint32_t> held;
    std::atomic<std::uint64_t> done{0};
    std::atomic<bool> stop{false};
    std::vector<std::jthread> returning;
    for (int i = 0; i < threads; ++i) {
      returning.emplace_back([&, i] {
        std::minstd_rand random(static_cast<unsigned>(i));
        while (!stop) {
          std::uint32_t slot = kSlots;
          {
            const std::scoped_lock lock(mutex);
            if (!held.empty()) {
              std::swap(held[random() % held.size()], held.back());
              slot = held.back();
              held.pop_back();
            }
          }
          if (slot == kSlots) {
            std::this_thread::yield();
          } else {
            lane.slip->Return(slot);
            ++done;
          }
        }
      });
    }
    std::jthread reading([&] {
      for (std::uint64_t next = 1; next <= kMessages && !stop;) {
        Descriptor read;
        if (lane.reader->Peek(read) != LaneReader::Read::kDescriptor) {
          std::this_thread::yield();
          continue;
        }
        ASSERT_EQ(read.number, next++);
        lane.reader->Next();
        lane.slip->Hold();
        const std::scoped_lock lock(mutex);
        held.push_back(read.slot);
      }
    });
    // The writer sleeps when it has no slot. So it stops if one returned slot does not wake it.
    std::atomic<bool> finished{false};
    std::jthread writing([&] {
      std::vector<std::shared_ptr<const void>> ended;
      for (std::uint64_t number = 1; number <= kMessages && !stop;) {
        if (lane.writer->HasSlot()) {
          lane.writer->Write(Numbered(number++), nullptr);
          continue;
        }
        lane.writer->SetHungry(kForSlots);
        ASSERT_TRUE(lane.writer->Collect(ended));
        if (!lane.writer->HasSlot()) {
          lane.bell.Wait();
          (void)lane.bell.CollectRings([](std::uint32_t number_of_peer) { EXPECT_EQ(number_of_peer, 5u); });
        }
        lane.writer->SetHungry(0);
        ASSERT_TRUE(lane.writer->Collect(ended));
      }
      finished = true;
    });
    EXPECT_TRUE(test::Await([&] { return finished && done == kMessages; })) << done;
    stop = true;
    lane.bell.Wake();
  }
}

TEST(ShmLane, RefusesReturnOfASlotThatIsNotHeld) {
  std::vector<std::shared_ptr<const void>> ended;
  {
    Lane lane;
    lane.slip->Return(3);
    EXPECT_FALSE(lane.writer->Collect(ended));
  }
  {
    Lane lane;
    lane.slip->Return(kSlots + 7);
    EXPECT_FALSE(lane.writer->Collect(ended));
  }
  Lane lane;
  for (std::uint32_t i = 0; i < kSlots + 1; ++i) lane.slip->Return(0);
  EXPECT_FALSE(lane.writer->Collect(ended));
  EXPECT_TRUE(ended.empty());
}

TEST(ShmLane, ReportsALieIfALaneHasMoreMessagesThanSlots) {
  std::string fault;
  auto page = MakeSegment("hgros-lane", sizeof(LanePage), Access::kEverybody, Pages::kOnTouch);
  page.mapping->as<LanePage>().magic = kLaneMagic;
  page.mapping->as<LanePage>().version = kLayoutVersion;
  const auto reader = LaneReader::Open(page.handle, fault);
  ASSERT_NE(reader, nullptr) << fault;
  Descriptor read;
  EXPECT_EQ(reader->Peek(read), LaneReader::Read::kNothing);
  page.mapping->as<LanePage>().written = kSlots;
  EXPECT_EQ(reader->Peek(read), LaneReader::Read::kDescriptor);
  page.mapping->as<LanePage>().written = kSlots + 1;
  EXPECT_EQ(reader->Peek(read), LaneReader::Read::kLie);
}

TEST(ShmLane, TheEndOfTheSlipEndsTheSocket) {
  Lane lane;
  char byte = 0;
  EXPECT_LT(recv(lane.far_end.fd(), &byte, 1, MSG_DONTWAIT), 0);
  lane.slip.reset();
  EXPECT_EQ(recv(lane.far_end.fd(), &byte, 1, MSG_DONTWAIT), 0);
}

}  // namespace
}  // namespace hgros::shm
