#include "transport/zmq/subscribe/link_credit.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <thread>
#include <vector>

namespace hgros::zmq {
namespace {

struct Link {
  Link(std::uint64_t messages, std::uint64_t bytes)
      : credit(std::make_shared<LinkCredit>(messages, bytes, "scan", due)) {}

  // Whether the thread that sends credit was woken since the last call.
  bool Woken() {
    pollfd fd{waker->fd(), POLLIN, 0};
    const bool woken = poll(&fd, 1, 0) == 1;
    waker->Clear();
    return woken;
  }

  void Admit(int messages) {
    for (int i = 0; i < messages; ++i) tokens.push_back(credit->AdmitMessage(1));
  }

  std::vector<std::shared_ptr<const void>> tokens;
  std::shared_ptr<Waker> waker = std::make_shared<Waker>();
  std::shared_ptr<DueCredits> due = std::make_shared<DueCredits>(waker);
  std::shared_ptr<LinkCredit> credit;
};

TEST(LinkCredit, WakesWhenAQuarterOfTheWindowWasConsumed) {
  Link link(16, 1 << 20);
  const auto& credit = link.credit;
  link.Admit(8);
  link.tokens.resize(5);
  EXPECT_FALSE(link.Woken());
  link.tokens.pop_back();
  EXPECT_TRUE(link.Woken());
  EXPECT_EQ(link.due->Take(), credit);
  credit->OnTaken();
  LinkCredit::Totals totals;
  ASSERT_TRUE(credit->CollectNews(totals));
  EXPECT_EQ(totals.messages, 4u);
  EXPECT_EQ(totals.bytes, 4u);
  EXPECT_FALSE(credit->CollectNews(totals));
}

TEST(LinkCredit, CountsWithoutAListOfDueCredits) {
  const auto credit = std::make_shared<LinkCredit>(1, 1, "scan", nullptr);
  (void)credit->AdmitMessage(1);
  credit->OnReceived();
  EXPECT_TRUE(credit->HasRoomNow());
}

TEST(LinkCredit, WakesForTheFirstMessageWhenThePublisherHasUsedUpItsCredit) {
  Link link(16, 1 << 20);
  link.Admit(16);
  link.tokens.pop_back();
  EXPECT_TRUE(link.Woken());
}

TEST(LinkCredit, IsDueWithoutAWakeUpWhenTheLastCreditIsUsedUp) {
  Link link(16, 1 << 20);
  link.Admit(15);
  link.tokens.pop_back();
  EXPECT_TRUE(link.due->empty());
  link.Admit(1);
  link.credit->OnReceived();
  EXPECT_FALSE(link.Woken());
  EXPECT_EQ(link.due->Take(), link.credit);
}

TEST(LinkCredit, IsListedOnceUntilItIsTaken) {
  Link link(4, 1 << 20);
  for (int i = 0; i < 3; ++i) link.credit->SkipMessage(1);
  EXPECT_EQ(link.due->Take(), link.credit);
  EXPECT_EQ(link.due->Take(), nullptr);
  EXPECT_TRUE(link.due->empty());
  link.credit->OnTaken();
  link.credit->SkipMessage(1);
  EXPECT_EQ(link.due->Take(), link.credit);
}

TEST(LinkCredit, IsNotTakenAfterItsEnd) {
  Link link(1, 1 << 20);
  link.credit->SkipMessage(1);
  EXPECT_FALSE(link.due->empty());
  link.credit.reset();
  EXPECT_EQ(link.due->Take(), nullptr);
  EXPECT_TRUE(link.due->empty());
}

TEST(LinkCredit, CountsBytesLikeMessages) {
  Link link(1000, 100);
  (void)link.credit->AdmitMessage(30);  // Consumed at once.
  EXPECT_TRUE(link.Woken());
}

TEST(LinkCredit, ShrunkWindowStillAdmitsMessagesUpToTheWidestWindow) {
  Link link(4, 1 << 20);
  const auto& credit = link.credit;
  credit->SetWindow(2, 1 << 20);
  link.Admit(2);
  EXPECT_FALSE(credit->HasRoomNow());
  EXPECT_TRUE(credit->HasRoom());
  link.Admit(2);
  EXPECT_FALSE(credit->HasRoom());
  link.tokens.clear();
  EXPECT_TRUE(credit->HasRoomNow());
}

TEST(LinkCredit, ASkippedMessageIsConsumedAtOnce) {
  Link link(16, 1 << 20);
  const auto& credit = link.credit;
  credit->SkipMessage(7);
  EXPECT_EQ(credit->received(), 1u);
  EXPECT_EQ(credit->in_flight().messages, 0u);
  LinkCredit::Totals totals;
  ASSERT_TRUE(credit->CollectNews(totals));
  EXPECT_EQ(totals.bytes, 7u);
}

TEST(LinkCredit, TokensMayOutliveTheLinkAndEndOnAnyThread) {
  Link link(64, 1 << 20);
  const auto& credit = link.credit;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    std::vector<std::shared_ptr<const void>> tokens;
    for (int i = 0; i < 100; ++i) tokens.push_back(credit->AdmitMessage(2));
    threads.emplace_back([held = std::move(tokens)]() mutable { held.clear(); });
  }
  LinkCredit* seen = credit.get();
  for (auto& thread : threads) thread.join();
  LinkCredit::Totals totals;
  ASSERT_TRUE(seen->CollectNews(totals));
  EXPECT_EQ(totals.messages, 400u);
  EXPECT_EQ(totals.bytes, 800u);
}

}  // namespace
}  // namespace hgros::zmq
