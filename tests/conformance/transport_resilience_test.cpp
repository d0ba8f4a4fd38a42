// The contracts of include/hgros/transport about deaths, cuts, threads and destruction, for every transport.
#include <set>

#include "conformance/transport_conformance.hpp"
#include "support/await.hpp"
#include "support/seed.hpp"

namespace hgros::conformance::transport_resilience_test {
namespace {

TEST_P(TransportConformance, APublisherMayRestartAgainAndAgain) {
  b.emplace(*world, Role::kSubscriber);
  in.emplace(*b, "scan");
  const auto lives = static_cast<std::size_t>(test::Rounds(3, 5));
  for (std::size_t life = 1; life <= lives; ++life) {
    a.emplace(*world, Role::kPublisher);
    out.emplace(*a, "scan");
    ASSERT_TRUE(out->Joined()) << "life " << life;
    ASSERT_EQ(out->Publish(std::to_string(life)), PublishStatus::kOk);
    ASSERT_TRUE(Eventually([&] { return in->sink.count() == life; })) << "life " << life;
    out.reset();
    a.reset();
  }
}

TEST_P(TransportConformance, ASubscriberMayRestartWithTheSameSessionId) {
  a.emplace(*world, Role::kPublisher);
  out.emplace(*a, "scan");
  const SessionId id = SessionId::Random();
  for (int life = 1; life <= test::Rounds(3, 5); ++life) {
    b.emplace(*world, Role::kSubscriber, id);
    in.emplace(*b, "scan", TextType(), kLossless);
    ASSERT_TRUE(out->Joined()) << "life " << life;
    ASSERT_TRUE(Eventually([&] { return in->channel->publisher_count() == 1; }));
    ASSERT_TRUE(out->PublishSoon(std::to_string(life)));
    ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1; })) << "life " << life;
    in.reset();
    b.reset();
    ASSERT_TRUE(out->Joined(0)) << "life " << life;
  }
}

TEST_P(TransportConformance, ALosslessSubscriberThatLeavesGivesItsCreditBack) {
  ASSERT_TRUE(Join(kLossless, HoldCredit));
  for (int i = 0; i < 8; ++i) ASSERT_EQ(out->Publish("x"), PublishStatus::kOk);
  ASSERT_EQ(out->Publish("x"), PublishStatus::kFull);
  b->transport->Close(0);
  ASSERT_TRUE(Eventually([&] { return out->source.rooms > 0; }));
  EXPECT_EQ(out->Publish("y"), PublishStatus::kOk);
  EXPECT_EQ(out->channel->stats().missed, 8u);
}

TEST_P(TransportConformance, ALosslessSubscriberThatFallsSilentGivesItsCreditBack) {
  if (world->cable() == nullptr) GTEST_SKIP() << "this transport cannot be cut";
  ASSERT_TRUE(Join());
  world->cable()->Stall();
  for (int i = 0; i < 8; ++i) ASSERT_EQ(out->Publish("x"), PublishStatus::kOk);
  ASSERT_EQ(out->Publish("x"), PublishStatus::kFull);
  ASSERT_TRUE(Eventually([&] { return out->source.rooms > 0 && out->channel->subscriber_count() == 0; }));
  EXPECT_EQ(out->channel->stats().missed, 8u);
  EXPECT_EQ(out->Publish("y"), PublishStatus::kOk);
  world->cable()->Resume();
  EXPECT_TRUE(out->Joined());
}

TEST_P(TransportConformance, ALosslessSubscriberGetsMessagesOfACutExactlyOnce) {
  if (world->cable() == nullptr) GTEST_SKIP() << "this transport cannot be cut";
  ASSERT_TRUE(Join());
  std::vector<std::string> sent;
  std::atomic<bool> stop{false};
  std::thread publishing([&] {
    while (!stop) {
      const std::string text = std::to_string(sent.size());
      if (out->Publish(text) == PublishStatus::kOk) sent.push_back(text);
      std::this_thread::yield();
    }
  });
  for (int cut = 0; cut < test::Rounds(2, 8); ++cut) {
    const std::size_t before = in->sink.count();
    EXPECT_TRUE(Eventually([&] { return in->sink.count() > before + 50; })) << "cut " << cut;
    if (cut % 2 == 0) {
      world->cable()->Cut();
    } else {
      world->cable()->Stall();
      test::Linger(std::chrono::milliseconds(5));  // Some cuts happen in the middle of a message.
      world->cable()->Cut();
    }
    world->cable()->Resume();
  }
  const std::size_t before = in->sink.count();
  EXPECT_TRUE(Eventually([&] { return in->sink.count() > before + 50; }));
  stop = true;
  publishing.join();
  EXPECT_TRUE(Eventually([&] { return in->sink.count() == sent.size(); }));
  EXPECT_EQ(in->sink.texts(), sent);
  EXPECT_EQ(out->channel->stats().missed, 0u);
}

TEST_P(TransportConformance, AKeepLastSubscriberComesBackAfterACutWithoutRepeats) {
  if (world->cable() == nullptr) GTEST_SKIP() << "this transport cannot be cut";
  ASSERT_TRUE(Join(kRoomy));
  for (int cut = 0; cut < test::Rounds(2, 4); ++cut) {
    world->cable()->Cut();
    for (int i = 0; i < 10; ++i) ASSERT_EQ(out->Publish("x"), PublishStatus::kOk);
    world->cable()->Resume();
    const std::size_t before = in->sink.count();
    ASSERT_TRUE(Eventually([&] { return out->Publish("x") == PublishStatus::kOk && in->sink.count() > before; }));
  }
  b->transport->Close(0);
  const std::set<MessageId> unique(in->sink.ids.begin(), in->sink.ids.end());
  EXPECT_EQ(unique.size(), in->sink.ids.size());
}

TEST_P(TransportConformance, ConcurrentPublishersKeepEachThreadsOrder) {
  ASSERT_TRUE(Join());
  constexpr std::size_t kThreads = 4;
  const auto each = static_cast<std::size_t>(test::Rounds(100, 300));
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = 0; i < each; ++i) EXPECT_TRUE(out->PublishSoon(std::to_string(t) + " " + std::to_string(i)));
    });
  }
  for (auto& thread : threads) thread.join();
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == kThreads * each; }));
  std::array<int, kThreads> next{};
  for (const auto& text : in->sink.texts()) {
    const auto t = static_cast<std::size_t>(text[0] - '0');
    EXPECT_EQ(std::stoi(text.substr(2)), next[t]++);
  }
}

TEST_P(TransportConformance, SeveralChannelsAlternateWithoutPause) {
  Meet();
  constexpr int kChannels = 8;
  const auto each = static_cast<std::size_t>(test::Rounds(100, 300));
  std::deque<Publication> all_out;
  std::deque<Reception> all_in;
  for (int c = 0; c < kChannels; ++c) {
    all_out.emplace_back(*a, "channel" + std::to_string(c));
    all_in.emplace_back(*b, "channel" + std::to_string(c), TextType(), kLossless);
    all_in.back().sink.answer = c % 2 == 0 ? Accepted::kRunApart : Accepted::kRunHere;
  }
  for (const auto& publication : all_out) ASSERT_TRUE(publication.Joined());
  for (std::size_t i = 0; i < each; ++i) {
    for (auto& publication : all_out) ASSERT_TRUE(publication.PublishSoon(std::to_string(i)));
  }
  for (const auto& reception : all_in) {
    ASSERT_TRUE(
        Eventually([&] { return reception.sink.count() == each && reception.sink.runs == static_cast<int>(each); }));
    EXPECT_FALSE(reception.sink.overlapped);
    for (std::size_t i = 0; i < each; ++i) EXPECT_EQ(reception.sink.texts()[i], std::to_string(i));
  }
}

TEST_P(TransportConformance, ALongRunOfOneChannelDoesNotBlockAnother) {
  Meet();
  Publication long_out(*a, "long"), short_out(*a, "short");
  std::atomic<bool> go_on{false};
  Reception long_in(*b, "long", TextType(), {}, [&](Sink& sink) {
    sink.answer = Accepted::kRunApart;
    sink.on_run = [&] { EXPECT_TRUE(Eventually([&] { return go_on.load(); })); };
  });
  Reception short_in(*b, "short", TextType(), kLossless, [](Sink& sink) { sink.answer = Accepted::kRunApart; });
  ASSERT_TRUE(long_out.Joined() && short_out.Joined());
  for (int i = 0; i < 10; ++i) ASSERT_EQ(long_out.Publish("x"), PublishStatus::kOk);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(short_out.PublishSoon("y"));
  EXPECT_TRUE(Eventually([&] { return short_in.sink.runs == 100; }));
  EXPECT_EQ(long_in.sink.runs, 0);
  go_on = true;
  EXPECT_TRUE(Eventually([&] { return long_in.sink.runs == 10; }));
}

TEST_P(TransportConformance, ASubscriptionMayEndWithinItsOwnRun) {
  for (const auto answer : {Accepted::kRunApart, Accepted::kRunHere}) {
    Offer();
    std::atomic<bool> ended{false}, ready{false};
    in.emplace(*b, "scan", TextType(), Demand{}, [&](Sink& sink) {
      sink.answer = answer;
      sink.on_run = [&] {
        EXPECT_TRUE(Eventually([&] { return ready.load(); }));
        in->channel.reset();
        ended = true;
      };
    });
    ready = true;
    ASSERT_TRUE(out->Joined());
    ASSERT_EQ(out->Publish("x"), PublishStatus::kOk);
    ASSERT_TRUE(Eventually([&] { return ended.load(); }));
    ASSERT_TRUE(out->Joined(0));
    EXPECT_EQ(in->sink.count(), 1u);
    b->transport->Close(0);  // Run() ends before the sink is destroyed.
  }
}

TEST_P(TransportConformance, EndingASubscriptionWaitsForItsRun) {
  std::atomic<bool> started{false}, finished{false};
  ASSERT_TRUE(Join({}, [&](Sink& sink) {
    sink.answer = Accepted::kRunApart;
    sink.on_run = [&] {
      started = true;
      test::Linger(std::chrono::milliseconds(50));
      finished = true;
    };
  }));
  ASSERT_EQ(out->Publish("x"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return started.load(); }));
  in->channel.reset();
  EXPECT_TRUE(finished);
}

TEST_P(TransportConformance, ASubscriptionMayEndForItsPublisherBeforeItsRunDoes) {
  std::atomic<bool> started{false}, go_on{false};
  ASSERT_TRUE(Join(kLossless, [&](Sink& sink) {
    sink.hold_credit = true;
    sink.answer = Accepted::kRunApart;
    sink.on_run = [&] {
      started = true;
      EXPECT_TRUE(Eventually([&] { return go_on.load(); }));
    };
  }));
  for (int i = 0; i < 8; ++i) ASSERT_EQ(out->Publish("x"), PublishStatus::kOk);
  ASSERT_EQ(out->Publish("x"), PublishStatus::kFull);
  ASSERT_TRUE(Eventually([&] { return started.load(); }));
  EXPECT_TRUE(in->channel->busy());
  in->channel->End();
  EXPECT_TRUE(out->PublishSoon("y"));
  go_on = true;
  in->channel.reset();
}

TEST_P(TransportConformance, EverythingMayBeDestroyedUnderLoad) {
  for (int round = 0; round < test::Rounds(2, 5); ++round) {
    ASSERT_TRUE(Join(kRoomy, [](Sink& sink) { sink.answer = Accepted::kRunApart; }));
    std::atomic<bool> stop{false};
    std::vector<std::thread> threads;
    for (int t = 0; t < 2; ++t) {
      threads.emplace_back([&] {
        while (!stop) {
          // A closed transport refuses.
          if (out->Publish(std::string(5000, 'x')) == PublishStatus::kClosed) std::this_thread::yield();
        }
      });
    }
    EXPECT_TRUE(Eventually([&] { return in->sink.count() > 100; }));
    if (round % 2 == 0) {
      in->channel.reset();
      b->transport.reset();
      a->transport.reset();
    } else {
      a->transport.reset();
      b->transport.reset();
      in->channel.reset();
    }
    stop = true;
    for (auto& thread : threads) thread.join();
  }
}

TEST_P(TransportConformance, AClosedTransportHasSentCommittedMessagesAndRefusesNewOnes) {
  ASSERT_TRUE(Join(kRoomy));
  for (int i = 0; i < 100; ++i) ASSERT_EQ(out->Publish("x"), PublishStatus::kOk);
  a->transport->Close(5000);
  EXPECT_EQ(out->Publish("y"), PublishStatus::kClosed);
  EXPECT_TRUE(Eventually([&] { return in->sink.count() == 100; })) << "what was committed was not sent";
  a->transport->Close(0);
}

}  // namespace
}  // namespace hgros::conformance::transport_resilience_test
