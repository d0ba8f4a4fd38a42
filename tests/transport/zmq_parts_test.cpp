// Parts of the ZeroMQ transport that need no sockets.
#include <gtest/gtest.h>

#include <set>

#include "conformance/transport_conformance.hpp"
#include "transport/zmq/arrival_wait.hpp"
#include "transport/zmq/clock_question.hpp"
#include "transport/zmq/session_keys.hpp"
#include "transport/zmq/session_proof.hpp"
#include "transport/zmq/shared_state.hpp"

namespace hgros::zmq {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

TEST(ArrivalWait, EndsAtTheFirstLookIfNothingIsArriving) {
  ArrivalWait wait;
  int looks = 0;
  wait.Await(hours(1), hours(1), [&] {
    ++looks;
    return Arriving{};
  });
  EXPECT_EQ(looks, 1);
}

TEST(ArrivalWait, EndsWhenEverythingHasArrived) {
  ArrivalWait wait;
  std::atomic<bool> looked{false};
  std::atomic<bool> arrived{false};
  const std::jthread reads([&] {
    looked.wait(false);
    arrived = true;
    wait.NoteRound();
  });
  wait.Await(hours(1), hours(1), [&] {
    const Arriving arriving{.any = !arrived, .progress = 1};
    looked = true;
    looked.notify_all();
    return arriving;
  });
  EXPECT_TRUE(arrived);
}

TEST(ArrivalWait, GivesUpWithoutProgress) {
  ArrivalWait wait;
  const auto began = Clock::now();
  wait.Await(milliseconds(30), hours(1), [] { return Arriving{.any = true, .progress = 1}; });
  EXPECT_GE(Clock::now() - began, milliseconds(30));
}

TEST(ArrivalWait, ContinuesWithProgressForALimitedTime) {
  ArrivalWait wait;
  const auto began = Clock::now();
  std::uint64_t progress = 0;
  // On a busy machine a look may come late, but each finds progress.
  wait.Await(milliseconds(50), milliseconds(200), [&] { return Arriving{.any = true, .progress = ++progress}; });
  EXPECT_GE(Clock::now() - began, milliseconds(200));
}

TEST(ZmqClockQuestion, IsAnsweredAtOnceWithFourTimes) {
  ClockQuestion question;
  wire::Heartbeat asking;
  question.Ask(asking, Time{1000});
  const auto answer = AnswerTo(asking, Time{70});
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->asked_ns(), 0) << "an answer must not ask";
  const auto exchange = question.Read(*answer, Time{1030});
  ASSERT_TRUE(exchange);
  EXPECT_EQ(exchange->asked, Time{1000});
  EXPECT_EQ(exchange->received, Time{70});
  EXPECT_EQ(exchange->answered, Time{70});
  EXPECT_EQ(exchange->got, Time{1030});
}

TEST(ZmqClockQuestion, TakesTheAnswerToItsLatestQuestionOnce) {
  ClockQuestion question;
  wire::Heartbeat first;
  wire::Heartbeat second;
  question.Ask(first, Time{1000});
  const auto late = AnswerTo(first, Time{70});
  question.Ask(second, Time{2000});
  const auto answer = AnswerTo(second, Time{80});
  ASSERT_TRUE(late && answer);
  EXPECT_FALSE(question.Read(*late, Time{2010}));
  EXPECT_TRUE(question.Read(*answer, Time{2020}));
  EXPECT_FALSE(question.Read(*answer, Time{2030}));
}

TEST(ZmqClockQuestion, IgnoresHeartbeatsWithoutClockFields) {
  ClockQuestion question;
  EXPECT_FALSE(AnswerTo({}, Time{70}));
  EXPECT_FALSE(question.Read({}, Time{1}));
}

TEST(ZmqSessionKeys, ASessionBelongsToItsFirstKey) {
  conformance::Listener listener;
  const PeerRegistry peers(listener);
  SessionKeys keys(peers, {1}, "own");
  EXPECT_TRUE(keys.Claim({1}, "own"));
  EXPECT_FALSE(keys.Claim({1}, "other"));
  EXPECT_TRUE(keys.Claim({2}, "first"));
  EXPECT_FALSE(keys.Claim({2}, "second"));
  EXPECT_FALSE(keys.Claim({2}, ""));
  EXPECT_TRUE(keys.Claim({2}, "first"));
  EXPECT_TRUE(keys.Claim({3}, "first")) << "sessions may share a key";
}

TEST(ZmqSessionKeys, ManyInventedSessionsDoNotFreeAConnectedOne) {
  conformance::Listener listener;
  PeerRegistry peers(listener);
  SessionKeys keys(peers, {1}, "own");
  PeerInfo connected;
  connected.id = {2};
  peers.Came(connected);
  EXPECT_TRUE(keys.Claim(connected.id, "first"));
  for (std::uint64_t id = 10; id < 30'000; ++id) EXPECT_TRUE(keys.Claim({id}, "inventor"));
  EXPECT_FALSE(keys.Claim(connected.id, "inventor"));
  EXPECT_FALSE(keys.Claim({1}, "inventor"));
  EXPECT_TRUE(keys.Claim({10}, "another")) << "it was forgotten";
}

// vectors_sip64 of the reference implementation: key 00 01 ... 0f, input 00 01 ... 07.
TEST(ZmqSessionProof, IsSipHashOfThePublishersId) {
  EXPECT_EQ(SessionProof({0x0706050403020100, 0x0f0e0d0c0b0a0908}, SessionId{0x0706050403020100}), 0x93f5f5799a932462U);
}

TEST(ZmqSessionProof, StaysTheSameHoweverManyPublishersThereAre) {
  conformance::Listener listener;
  conformance::KeptLog kept;
  const SharedState shared({}, listener, kept.log);
  const std::uint64_t first = shared.ProofFor(SessionId{1});
  std::set<std::uint64_t> all{first};
  for (std::uint64_t id = 2; id <= 10'000; ++id) all.insert(shared.ProofFor(SessionId{id}));
  EXPECT_EQ(shared.ProofFor(SessionId{1}), first);
  EXPECT_EQ(all.size(), 10'000U) << "each has its own";
  const SharedState other({}, listener, kept.log);
  EXPECT_NE(other.ProofFor(SessionId{1}), first);
}

}  // namespace
}  // namespace hgros::zmq
