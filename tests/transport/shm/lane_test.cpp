// The way of messages from one session to another, and what the subscriber gives back.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <random>

#include "conformance/transport_conformance.hpp"
#include "support/await.hpp"
#include "support/seed.hpp"
#include "transport/shm/memory/lane_reader.hpp"
#include "transport/shm/memory/lane_writer.hpp"
#include "transport/shm/pair_inbox.hpp"
#include "transport/shm/receipt.hpp"

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
  [[nodiscard]] bool Rung() {
    return bell.CollectRings([](std::uint32_t number) { EXPECT_EQ(number, 5u); });
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
  for (int seed = 1; seed <= test::Rounds(2, 5); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::minstd_rand random(static_cast<unsigned>(seed));
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
          (void)lane.Rung();
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

TEST(ShmReceipt, PublisherReadsConsumedMessagesAndBytes) {
  Lane lane;
  const auto receipt = Receipt::Make(lane.slip);
  receipt->SetWindow(4, 1000);
  auto first = receipt->AdmitMessage(100);
  auto second = receipt->AdmitMessage(50);
  EXPECT_EQ(lane.writer->ConsumedOf(receipt->cell()).messages, 0u);
  second.reset();
  EXPECT_EQ(lane.writer->ConsumedOf(receipt->cell()).messages, 1u);
  EXPECT_EQ(lane.writer->ConsumedOf(receipt->cell()).bytes, 50u);
  first.reset();
  EXPECT_EQ(lane.writer->ConsumedOf(receipt->cell()).bytes, 150u);
  EXPECT_EQ(lane.writer->ConsumedOf(kCells).messages, 0u);
}

TEST(ShmReceipt, RingsAHungryPublisherAfterAQuarterAndWhenNothingIsHeld) {
  Lane lane;
  const auto receipt = Receipt::Make(lane.slip);
  receipt->SetWindow(8, 1 << 20);
  std::vector<std::shared_ptr<const void>> held;
  for (int i = 0; i < 5; ++i) held.push_back(receipt->AdmitMessage(1));
  held.pop_back();
  held.pop_back();
  EXPECT_FALSE(lane.Rung());
  lane.writer->SetHungry(kForCredit);
  held.pop_back();
  EXPECT_FALSE(lane.Rung());
  held.pop_back();
  EXPECT_TRUE(lane.Rung());
  held.pop_back();
  EXPECT_TRUE(lane.Rung());
}

TEST(ShmReceipt, UsesTheWidestWindowThatWasGranted) {
  Lane lane;
  const auto receipt = Receipt::Make(lane.slip);
  receipt->SetWindow(3, 1000);
  receipt->SetWindow(1, 1000);
  std::vector<std::shared_ptr<const void>> held;
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(receipt->HasRoom());
    held.push_back(receipt->AdmitMessage(10));
  }
  EXPECT_FALSE(receipt->HasRoom());
  held.pop_back();
  EXPECT_TRUE(receipt->HasRoom());
  held.push_back(receipt->AdmitMessage(5000));  // One message of any size is allowed.
  held.erase(held.begin());
  EXPECT_FALSE(receipt->HasRoom());
}

TEST(ShmReceipt, CellsAreLimitedAndStartAtZeroWhenReused) {
  Lane lane;
  std::vector<std::shared_ptr<Receipt>> receipts;
  while (auto receipt = Receipt::Make(lane.slip)) receipts.push_back(std::move(receipt));
  EXPECT_EQ(receipts.size(), kCells);
  auto token = receipts.back()->AdmitMessage(7);
  const std::uint32_t cell = receipts.back()->cell();
  receipts.pop_back();
  EXPECT_EQ(Receipt::Make(lane.slip), nullptr);  // A message is still held.
  token.reset();
  const auto again = Receipt::Make(lane.slip);
  ASSERT_NE(again, nullptr);
  EXPECT_EQ(again->cell(), cell);
  EXPECT_EQ(lane.writer->ConsumedOf(cell).messages, 0u);
}

TEST(ShmReceipt, APublisherThatSleepsForCreditIsAlwaysWoken) {
  for (const int threads : {1, 3}) {
    Lane lane;
    const auto receipt = Receipt::Make(lane.slip);
    constexpr std::uint64_t kWindow = 10;
    constexpr std::uint64_t kMessages = 20'000;
    receipt->SetWindow(kWindow, 1 << 20);
    std::mutex mutex;
    std::vector<std::shared_ptr<const void>> held;
    std::atomic<bool> stop{false};
    std::atomic<bool> finished{false};
    std::vector<std::jthread> consumers;
    for (int i = 0; i < threads; ++i) {
      consumers.emplace_back([&] {
        while (!stop) {
          std::shared_ptr<const void> token;
          {
            const std::scoped_lock lock(mutex);
            if (!held.empty()) {
              token = std::move(held.back());
              held.pop_back();
            }
          }
          if (!token) std::this_thread::yield();
        }
      });
    }
    std::jthread publisher([&] {
      const auto room = [&](std::uint64_t sent) {
        return sent - lane.writer->ConsumedOf(receipt->cell()).messages < kWindow;
      };
      for (std::uint64_t sent = 0; sent < kMessages && !stop;) {
        if (!room(sent)) {
          lane.writer->SetHungry(kForCredit);
          if (!room(sent)) lane.bell.Wait();
          (void)lane.Rung();
          lane.writer->SetHungry(0);
          continue;
        }
        ++sent;
        auto token = receipt->AdmitMessage(1);
        const std::scoped_lock lock(mutex);
        held.push_back(std::move(token));
      }
      finished = true;
    });
    EXPECT_TRUE(test::Await([&] { return finished.load(); }));
    stop = true;
    lane.bell.Wake();
  }
}

TEST(ShmReceipt, AForkedChildConsumesNothing) {
  Lane lane;
  auto receipt = Receipt::Make(lane.slip);
  auto token = receipt->AdmitMessage(9);
  const std::uint32_t cell = receipt->cell();
  lane.slip->Hold();
  const pid_t child = fork();
  if (child == 0) {
    token.reset();
    lane.slip->Return(2);
    receipt.reset();
    lane.slip.reset();
    _exit(0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(lane.writer->ConsumedOf(cell).messages, 0u);
  std::vector<std::shared_ptr<const void>> ended;
  EXPECT_TRUE(lane.writer->Collect(ended));
  char byte = 0;
  EXPECT_LT(recv(lane.far_end.fd(), &byte, 1, MSG_DONTWAIT), 0) << "the child ended the socket";
}

// The subscriber had no memory for the payload.
TEST(ShmPairInbox, LastMessageEndsItsLinkEvenIfItIsLost) {
  Lane lane;
  PairInbox inbox(lane.slip);
  std::string fault;
  inbox.Open(std::move(lane.reader), PeerBell::Open(*lane.bell.handle(), 0, fault), SessionId{1});
  const Demand demand{.credit_messages = 4, .credit_bytes = 1000};
  conformance::Sink sink;
  const auto link = inbox.AddLink(std::make_shared<InboundCore>("scan", conformance::TextType(), demand, sink));
  inbox.RaiseLimits(*link, demand);
  wire::Granted granted;
  granted.set_credit_messages(4);
  granted.set_credit_bytes(1000);
  ASSERT_TRUE(inbox.Grant(*link, granted, nullptr));
  ASSERT_TRUE(inbox.AddPayload({link->link, 1, {}}));
  EXPECT_FALSE(inbox.EndAfter(link->link, 1));
  Descriptor last{};
  last.link = link->link;
  last.number = 1;
  last.segment = kOnSocket;
  last.size_bytes = 100;
  lane.writer->Write(last, nullptr);
  PairInbox::Arrival arrival;
  EXPECT_EQ(inbox.Next(arrival, 1000), PairInbox::Step::kLost);
  EXPECT_TRUE(arrival.ends);
}

// A gap in the messages of a later connection is explained by the end of the one before, so the end is told first.
TEST(ShmPairInbox, IsReadWhenTheEndOfAnEarlierOneIsTold) {
  Lane lane;
  Lane later_lane;
  const auto earlier = std::make_shared<PairInbox>(lane.slip);
  PairInbox later(later_lane.slip);
  later.ReadAfter(earlier);
  PairInbox::Arrival arrival;
  EXPECT_EQ(later.Next(arrival, 1000), PairInbox::Step::kNotYet);
  EXPECT_TRUE(earlier->MarkAllRead());
  EXPECT_EQ(later.Next(arrival, 1000), PairInbox::Step::kNotYet);
  earlier->MarkEnded();
  EXPECT_EQ(later.Next(arrival, 1000), PairInbox::Step::kNothing);
}

}  // namespace
}  // namespace hgros::shm
