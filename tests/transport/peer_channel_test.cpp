#include "transport/peer_channel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <random>

namespace hgros::zmq {
namespace {

constexpr std::uint64_t kMaxCreditBytes = 256 << 20;

Demand Granted(const Demand& asked) { return PeerChannel::Granted(asked, kMaxCreditBytes); }

PeerChannel::Dropped nowhere;

PendingMessage Make(std::uint64_t sequence, std::uint64_t bytes = 10) { return {nullptr, {1, 1, sequence}, bytes}; }

TEST(PeerChannel, HoldsUpAPublisherIfItConfirmsNothingForLong) {
  using std::chrono::seconds;
  const std::chrono::steady_clock::time_point start{};
  PeerChannel channel(Granted({.lossless = true, .credit_messages = 2}));
  channel.Begin({});
  EXPECT_FALSE(channel.HoldsUp(true, start));
  EXPECT_FALSE(channel.HoldsUp(true, start + seconds(20))) << "it has room";
  channel.Push(Make(1));
  channel.Push(Make(2));
  while (channel.Pop()) {
  }
  EXPECT_FALSE(channel.HoldsUp(true, start + seconds(21)));
  EXPECT_FALSE(channel.HoldsUp(true, start + seconds(30)));
  ASSERT_TRUE(channel.Confirm(1, 10, nowhere));
  channel.Push(Make(3));
  ASSERT_TRUE(channel.Pop());
  EXPECT_FALSE(channel.HoldsUp(true, start + seconds(31))) << "it is slow, but takes messages";
  EXPECT_FALSE(channel.HoldsUp(true, start + seconds(40)));
  EXPECT_TRUE(channel.HoldsUp(true, start + seconds(41)));
  EXPECT_FALSE(channel.HoldsUp(true, start + seconds(60))) << "once";
  EXPECT_FALSE(channel.HoldsUp(false, start + seconds(61))) << "nobody waits";
  EXPECT_FALSE(channel.HoldsUp(true, start + seconds(62)));
  EXPECT_TRUE(channel.HoldsUp(true, start + seconds(72))) << "again";
}

std::vector<std::uint64_t> Drained(PeerChannel& channel) {
  std::vector<std::uint64_t> order;
  while (const auto message = channel.Pop()) order.push_back(message->id.sequence);
  return order;
}

TEST(PeerChannel, SendsLatchedMessagesFirstAndLosesOrRepeatsNoWaitingOnes) {
  PeerChannel channel(Granted({}));
  channel.Push(Make(3));
  channel.Push(Make(4));
  channel.Begin({Make(2), Make(3)});
  EXPECT_FALSE(channel.Push(Make(2))) << "it was latched before it was committed";
  channel.Push(Make(5));
  EXPECT_EQ(Drained(channel), (std::vector<std::uint64_t>{2, 3, 4, 5}));
  EXPECT_EQ(channel.waiting_bytes(), 0u);
}

TEST(PeerChannel, IgnoresImpossibleCounts) {
  PeerChannel channel(Granted({.lossless = true}));
  channel.Begin({});
  channel.Push(Make(1));
  ASSERT_TRUE(channel.Pop());
  EXPECT_FALSE(channel.Confirm(2, 10, nowhere));
  EXPECT_FALSE(channel.Confirm(1, 11, nowhere));
  EXPECT_TRUE(channel.Confirm(1, 10, nowhere));
  EXPECT_TRUE(channel.Confirm(0, 0, nowhere));
  EXPECT_FALSE(channel.Resume(0, 0));
  EXPECT_FALSE(channel.Resume(2, 10));
  EXPECT_TRUE(channel.Resume(1, 10));
}

TEST(PeerChannel, LimitsExcessiveDemands) {
  const Demand granted =
      Granted({.lossless = false, .queue_depth = ~0u, .credit_messages = ~0u, .credit_bytes = ~std::uint64_t{0}});
  EXPECT_LT(granted.queue_depth, 1u << 24);
  EXPECT_LT(granted.credit_messages, 1u << 24);
  EXPECT_EQ(granted.credit_bytes, kMaxCreditBytes);
  const Demand least = Granted({.lossless = true, .queue_depth = 0, .credit_messages = 0, .credit_bytes = 0});
  EXPECT_EQ(least.credit_messages, 1u);
}

TEST(PeerChannel, DropsTheOldestBeyondThePeersBytesButKeepsOne) {
  PeerChannel channel(Granted({.queue_depth = 100, .credit_messages = 1}));
  channel.Begin({});
  for (std::uint64_t i = 1; i <= 5; ++i) channel.Push(Make(i, 100));
  ASSERT_TRUE(channel.Pop());
  EXPECT_EQ(channel.Trim(250, nowhere), 2u);
  EXPECT_EQ(channel.waiting_bytes(), 200u);
  EXPECT_EQ(channel.Trim(0, nowhere), 1u);
  ASSERT_TRUE(channel.Confirm(1, 100, nowhere));
  EXPECT_EQ(channel.Pop()->id.sequence, 5u);
}

TEST(PeerChannel, WindowIncludesMessagesSentBeforeTheLinkBecameLossless) {
  PeerChannel channel(Granted({.credit_messages = 2}));
  channel.Begin({});
  channel.Push(Make(1));
  channel.Push(Make(2));
  EXPECT_EQ(Drained(channel).size(), 2u);
  EXPECT_EQ(channel.SetDemand(Granted({.lossless = true, .credit_messages = 3}), nowhere), 0u);
  channel.Push(Make(3));
  channel.Push(Make(4));
  EXPECT_EQ(Drained(channel), std::vector<std::uint64_t>{3});
  ASSERT_TRUE(channel.Confirm(1, 10, nowhere));
  EXPECT_EQ(Drained(channel), std::vector<std::uint64_t>{4});
  EXPECT_EQ(channel.Resume(1, 10), 1u) << "a message that was sent as keep-last is lost";
  EXPECT_EQ(Drained(channel), (std::vector<std::uint64_t>{3, 4}));
}

TEST(PeerChannel, SendsAndDropsNothingBeforeItHasBegun) {
  PeerChannel channel(Granted({.queue_depth = 1}));
  for (std::uint64_t i = 1; i <= 3; ++i) {
    channel.Push(Make(i));
    EXPECT_EQ(channel.Trim(~std::uint64_t{0}, nowhere), 0u);
    EXPECT_FALSE(channel.Pop());
  }
  channel.Begin({});
  EXPECT_EQ(Drained(channel), (std::vector<std::uint64_t>{1, 2, 3}));
}

/// A naive model of PeerChannel: it keeps everything that was sent and received.
struct Model {
  Demand demand;
  std::deque<std::uint64_t> ring;
  std::vector<std::uint64_t> sent;      // Sequences by link number - 1.
  std::vector<std::uint64_t> received;  // The messages that the peer has, in order.
  std::size_t consumed = 0;
  std::size_t confirmed = 0;
};

class PeerChannelModel : public testing::TestWithParam<bool> {};

TEST_P(PeerChannelModel, BehavesLikeTheNaiveModel) {
  const bool lossless = GetParam();
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const auto below = [&](unsigned n) { return static_cast<unsigned>(random() % n); };
    Model model;
    model.demand = Granted(
        {.lossless = lossless, .queue_depth = 1 + below(5), .credit_messages = 1 + below(6), .credit_bytes = 10000});
    PeerChannel channel(model.demand);
    channel.Begin({});
    std::vector<std::uint64_t> wire;  // Sequences in flight; their link numbers begin at model.received.size() + 1.
    std::vector<std::uint64_t> all;
    std::uint64_t sequence = 0;
    for (int step = 0; step < 500; ++step) {
      switch (below(5)) {
        case 0:
        case 1: {
          if (lossless) {
            const bool room = model.sent.size() - model.confirmed + model.ring.size() < model.demand.credit_messages;
            ASSERT_EQ(channel.HasRoom(), room);
            if (!room) break;
            channel.Reserve();
          }
          channel.Push(Make(++sequence));
          all.push_back(sequence);
          model.ring.push_back(sequence);
          break;
        }
        case 2:  // Some messages in flight arrive and are consumed.
          for (unsigned n = below(4); n > 0 && !wire.empty(); --n) {
            model.received.push_back(wire.front());
            wire.erase(wire.begin());
          }
          model.consumed += below(static_cast<unsigned>(model.received.size() - model.consumed) + 1);
          break;
        case 3:
          model.confirmed = model.consumed;
          ASSERT_TRUE(channel.Confirm(model.consumed, 10 * model.consumed, nowhere));
          break;
        default: {  // A cut: messages in flight are lost.
          if (below(4) != 0) break;
          channel.Pause();
          ASSERT_FALSE(channel.Pop());
          const auto lost = channel.Resume(model.received.size(), 10 * model.received.size());
          ASSERT_TRUE(lost);
          ASSERT_EQ(*lost, lossless ? 0 : wire.size());
          if (lossless) model.ring.insert(model.ring.begin(), wire.begin(), wire.end());
          wire.clear();
          model.sent.resize(model.received.size());
          break;
        }
      }
      while (const auto message = channel.Pop()) {
        ASSERT_FALSE(model.ring.empty());
        ASSERT_EQ(message->id.sequence, model.ring.front());
        ASSERT_LT(model.sent.size() - model.confirmed, model.demand.credit_messages);
        model.sent.push_back(model.ring.front());
        model.ring.pop_front();
        wire.push_back(message->id.sequence);
        ASSERT_EQ(channel.sent(), model.sent.size());
      }
      ASSERT_TRUE(model.ring.empty() || model.sent.size() - model.confirmed >= model.demand.credit_messages);
      std::size_t dropped = 0;
      while (!lossless && model.ring.size() > model.demand.queue_depth) {
        model.ring.pop_front();
        ++dropped;
      }
      ASSERT_EQ(channel.Trim(~std::uint64_t{0}, nowhere), dropped);
      ASSERT_EQ(channel.waiting(), model.ring.size());
      ASSERT_EQ(channel.waiting_bytes(), 10 * model.ring.size());
    }
    ASSERT_TRUE(std::ranges::is_sorted(model.received));
    if (lossless) {
      ASSERT_TRUE(std::equal(model.received.begin(), model.received.end(), all.begin()));
      ASSERT_EQ(channel.unfinished(), all.size() - model.confirmed);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Both, PeerChannelModel, testing::Bool(),
                         [](const auto& test) { return test.param ? "Lossless" : "KeepLast"; });

}  // namespace
}  // namespace hgros::zmq
