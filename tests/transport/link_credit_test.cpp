#include "transport/zmq/subscribe/link_credit.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <thread>
#include <vector>

namespace hgros::zmq {
namespace {

bool Woken(Waker& waker) {
  pollfd fd{waker.fd(), POLLIN, 0};
  const bool woken = poll(&fd, 1, 0) == 1;
  waker.Clear();
  return woken;
}

TEST(LinkCredit, WakesWhenAQuarterOfTheWindowWasConsumed) {
  auto waker = std::make_shared<Waker>();
  auto credit = std::make_shared<LinkCredit>(16, 1 << 20, waker);
  std::vector<std::shared_ptr<const void>> tokens;
  for (int i = 0; i < 8; ++i) tokens.push_back(credit->AdmitMessage(1));
  for (int i = 0; i < 3; ++i) tokens.pop_back();
  EXPECT_FALSE(Woken(*waker));
  tokens.pop_back();
  EXPECT_TRUE(Woken(*waker));
  EXPECT_TRUE(credit->AnswerWake());
  LinkCredit::Totals totals;
  ASSERT_TRUE(credit->CollectNews(totals));
  EXPECT_EQ(totals.messages, 4u);
  EXPECT_EQ(totals.bytes, 4u);
  EXPECT_FALSE(credit->CollectNews(totals));
}

TEST(LinkCredit, WakesForTheFirstMessageWhenThePublisherHasUsedUpItsCredit) {
  auto waker = std::make_shared<Waker>();
  auto credit = std::make_shared<LinkCredit>(16, 1 << 20, waker);
  std::vector<std::shared_ptr<const void>> tokens;
  for (int i = 0; i < 16; ++i) tokens.push_back(credit->AdmitMessage(1));
  tokens.pop_back();
  EXPECT_TRUE(Woken(*waker));
}

TEST(LinkCredit, CountsBytesLikeMessages) {
  auto waker = std::make_shared<Waker>();
  auto credit = std::make_shared<LinkCredit>(1000, 100, waker);
  auto token = credit->AdmitMessage(30);
  token.reset();
  EXPECT_TRUE(Woken(*waker));
}

TEST(LinkCredit, ShrunkWindowStillAdmitsMessagesUpToTheWidestWindow) {
  auto credit = std::make_shared<LinkCredit>(4, 1 << 20, std::make_shared<Waker>());
  credit->SetWindow(2, 1 << 20);
  std::vector<std::shared_ptr<const void>> tokens;
  for (int i = 0; i < 2; ++i) tokens.push_back(credit->AdmitMessage(1));
  EXPECT_FALSE(credit->HasRoomNow());
  EXPECT_TRUE(credit->HasRoom());
  for (int i = 0; i < 2; ++i) tokens.push_back(credit->AdmitMessage(1));
  EXPECT_FALSE(credit->HasRoom());
  tokens.clear();
  EXPECT_TRUE(credit->HasRoomNow());
}

TEST(LinkCredit, ASkippedMessageIsConsumedAtOnce) {
  auto credit = std::make_shared<LinkCredit>(16, 1 << 20, std::make_shared<Waker>());
  credit->SkipMessage(7);
  EXPECT_EQ(credit->received(), 1u);
  EXPECT_EQ(credit->in_flight().messages, 0u);
  LinkCredit::Totals totals;
  ASSERT_TRUE(credit->CollectNews(totals));
  EXPECT_EQ(totals.bytes, 7u);
}

TEST(LinkCredit, TokensMayOutliveTheLinkAndEndOnAnyThread) {
  auto waker = std::make_shared<Waker>();
  auto credit = std::make_shared<LinkCredit>(64, 1 << 20, waker);
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
