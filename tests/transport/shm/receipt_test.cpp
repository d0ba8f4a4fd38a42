#include "transport/shm/receipt.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "support/await.hpp"
#include "transport/shm/memory/lane_writer.hpp"

namespace hgros::shm {
namespace {

struct Account {
  Account() {
    std::string fault;
    int ends[2];
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
    far_end = Handle(ends[1]);
    slip = Slip::Make(std::make_shared<const Handle>(ends[0]), std::make_shared<const ForkGuard>(), fault);
    writer = LaneWriter::Make(fault);
    EXPECT_TRUE(writer->Open(*slip->handle(), fault)) << fault;
    reader = LaneReader::Open(*writer->handle(), fault);
    slip->SetPublisher(reader->mapping(), PeerBell::Open(*bell.handle(), 0, fault));
  }
  [[nodiscard]] bool Rung() {
    return bell.CollectRings([](std::uint32_t) {});
  }
  SessionBell bell{Patience{}};
  Handle far_end;
  std::shared_ptr<Slip> slip;
  std::unique_ptr<LaneWriter> writer;
  std::unique_ptr<LaneReader> reader;
};

TEST(ShmReceipt, PublisherReadsConsumedMessagesAndBytes) {
  Account account;
  const auto receipt = Receipt::Make(account.slip);
  receipt->SetWindow(4, 1000);
  auto first = receipt->AdmitMessage(100);
  auto second = receipt->AdmitMessage(50);
  EXPECT_EQ(account.writer->ConsumedOf(receipt->cell()).messages, 0u);
  second.reset();
  EXPECT_EQ(account.writer->ConsumedOf(receipt->cell()).messages, 1u);
  EXPECT_EQ(account.writer->ConsumedOf(receipt->cell()).bytes, 50u);
  first.reset();
  EXPECT_EQ(account.writer->ConsumedOf(receipt->cell()).bytes, 150u);
  EXPECT_EQ(account.writer->ConsumedOf(kCells).messages, 0u);
}

TEST(ShmReceipt, RingsAHungryPublisherAfterAQuarterAndWhenNothingIsHeld) {
  Account account;
  const auto receipt = Receipt::Make(account.slip);
  receipt->SetWindow(8, 1 << 20);
  std::vector<std::shared_ptr<const void>> held;
  for (int i = 0; i < 5; ++i) held.push_back(receipt->AdmitMessage(1));
  held.pop_back();
  held.pop_back();
  EXPECT_FALSE(account.Rung());
  account.writer->SetHungry(kForCredit);
  held.pop_back();
  EXPECT_FALSE(account.Rung());
  held.pop_back();
  EXPECT_TRUE(account.Rung());
  held.pop_back();
  EXPECT_TRUE(account.Rung());
}

TEST(ShmReceipt, UsesTheWidestWindowThatWasGranted) {
  Account account;
  const auto receipt = Receipt::Make(account.slip);
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
  Account account;
  std::vector<std::shared_ptr<Receipt>> receipts;
  while (auto receipt = Receipt::Make(account.slip)) receipts.push_back(std::move(receipt));
  EXPECT_EQ(receipts.size(), kCells);
  auto token = receipts.back()->AdmitMessage(7);
  const std::uint32_t cell = receipts.back()->cell();
  receipts.pop_back();
  EXPECT_EQ(Receipt::Make(account.slip), nullptr);  // A message is still held.
  token.reset();
  const auto again = Receipt::Make(account.slip);
  ASSERT_NE(again, nullptr);
  EXPECT_EQ(again->cell(), cell);
  EXPECT_EQ(account.writer->ConsumedOf(cell).messages, 0u);
}

TEST(ShmReceipt, APublisherThatSleepsForCreditIsAlwaysWoken) {
  for (const int threads : {1, 3}) {
    Account account;
    const auto receipt = Receipt::Make(account.slip);
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
        return sent - account.writer->ConsumedOf(receipt->cell()).messages < kWindow;
      };
      for (std::uint64_t sent = 0; sent < kMessages && !stop;) {
        if (!room(sent)) {
          account.writer->SetHungry(kForCredit);
          if (!room(sent)) account.bell.Wait();
          (void)account.Rung();
          account.writer->SetHungry(0);
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
    account.bell.Wake();
  }
}

TEST(ShmReceipt, AForkedChildConsumesNothing) {
  Account account;
  auto receipt = Receipt::Make(account.slip);
  auto token = receipt->AdmitMessage(9);
  const std::uint32_t cell = receipt->cell();
  account.slip->Hold();
  const pid_t child = fork();
  if (child == 0) {
    token.reset();
    account.slip->Return(2);
    receipt.reset();
    account.slip.reset();
    _exit(0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(account.writer->ConsumedOf(cell).messages, 0u);
  std::vector<std::shared_ptr<const void>> ended;
  EXPECT_TRUE(account.writer->Collect(ended));
  char byte = 0;
  EXPECT_LT(recv(account.far_end.fd(), &byte, 1, MSG_DONTWAIT), 0) << "the child ended the socket";
}

}  // namespace
}  // namespace hgros::shm
