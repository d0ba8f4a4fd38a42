// The numbered contracts of include/hgros/transport, for every transport. Each test shows one behavior.
#include <algorithm>

#include "conformance/transport_conformance.hpp"
#include "hgros/transport/ends_later.hpp"

namespace hgros::conformance {
namespace {

std::vector<std::string> Numbers(int first, int last) {
  std::vector<std::string> texts;
  for (int i = first; i <= last; ++i) texts.push_back(std::to_string(i));
  return texts;
}

constexpr Demand kOneMessage{.lossless = true, .queue_depth = 16, .credit_messages = 1, .credit_bytes = 1 << 20};
constexpr Demand kTwoMessages{.lossless = true, .queue_depth = 16, .credit_messages = 2, .credit_bytes = 1 << 20};

TEST_P(TransportConformance, DeliversInOrder) {
  ASSERT_TRUE(Join());
  for (int i = 1; i <= 1000; ++i) ASSERT_TRUE(out->PublishSoon(std::to_string(i)));
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1000; }));
  EXPECT_EQ(in->sink.texts(), Numbers(1, 1000));
  EXPECT_TRUE(Eventually([&] { return out->channel->stats().sent == 1000; }));  // Counted after sending.
  EXPECT_FALSE(in->sink.overlapped);
}

TEST_P(TransportConformance, ChannelsWhoseNamesBeginAlikeStayApart) {
  Offer();
  Publication filtered(*a, "scan_filtered");
  Ask(TextType());
  ASSERT_TRUE(out->Joined());
  ASSERT_EQ(filtered.Publish("other"), PublishStatus::kOk);
  ASSERT_EQ(out->Publish("mine"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return in->sink.count() > 0; }));
  EXPECT_EQ(in->sink.texts(), std::vector<std::string>{"mine"});
  EXPECT_EQ(filtered.channel->subscriber_count(), 0u);
}

TEST_P(TransportConformance, ASubscriberOfAnyTypeGetsMessagesAndTheirSchema) {
  const TypeInfo type = ProtobufType("hgros.test.Any", {{"int32", 1}});
  Offer(type);
  Ask(AnyType(), kLossless);
  ASSERT_TRUE(out->Joined());
  ASSERT_TRUE(Eventually([&] { return in->sink.offered == 1; }));
  for (int i = 1; i <= 100; ++i) ASSERT_TRUE(out->PublishSoon(std::to_string(i)));
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 100; }));
  EXPECT_EQ(in->sink.texts(), Numbers(1, 100));
  in->channel.reset();
  EXPECT_EQ(*in->sink.offers.at(a->id.value), SchemaOf(type));
  for (const auto& schema : in->sink.schemas) EXPECT_EQ(schema, in->sink.offers.at(a->id.value));
  EXPECT_EQ(a->listener.mismatches + b->listener.mismatches, 0);
}

TEST_P(TransportConformance, ALargePayloadIsKeptUntilSentAndThenReleased) {
  ASSERT_TRUE(Join());
  const std::string text(3 << 20, 'x');
  Payload payload = Publication::PayloadOf(text);
  const std::weak_ptr<const void> owner = payload.owner;
  in->sink.hold_credit = true;
  ASSERT_EQ(out->channel->Reserve(), PublishStatus::kOk);
  out->channel->Commit(out->NextHead(), payload);
  if (world->shows_in_place()) {
    EXPECT_GT(owner.use_count(), 1) << "the bytes were copied";
  }
  payload = {};
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1; }));
  EXPECT_EQ(in->sink.texts().front(), text);
  in->sink.Release(1);
  EXPECT_TRUE(Eventually([&] { return owner.expired(); }));
}

TEST_P(TransportConformance, ReserveTakesCreditFromAllLosslessSubscribersOrNone) {
  Offer();
  Session c(*world, Role::kSubscriber);
  Reception slow(*b, "scan", TextType(), kTwoMessages), fast(c, "scan", TextType(), kLossless);
  slow.sink.hold_credit = true;
  ASSERT_TRUE(out->Joined(2));
  ASSERT_EQ(out->Publish("1"), PublishStatus::kOk);
  ASSERT_EQ(out->Publish("2"), PublishStatus::kOk);
  for (int i = 0; i < 50; ++i) ASSERT_EQ(out->Publish("3"), PublishStatus::kFull);
  ASSERT_TRUE(Eventually([&] { return fast.sink.count() == 2 && slow.sink.count() == 2; }));
  slow.sink.Release(1);
  ASSERT_TRUE(Eventually([&] { return out->source.rooms > 0; }));
  ASSERT_EQ(out->Publish("3"), PublishStatus::kOk);
  EXPECT_EQ(out->Publish("4"), PublishStatus::kFull);
  ASSERT_TRUE(Eventually([&] { return fast.sink.count() == 3 && slow.sink.count() == 3; }));
  EXPECT_EQ(fast.sink.texts(), Numbers(1, 3));
  EXPECT_EQ(slow.sink.texts(), Numbers(1, 3));
}

TEST_P(TransportConformance, CancelGivesTheReservationBackAndReportsItToARefusedPublisher) {
  ASSERT_TRUE(Join(kOneMessage));
  for (int i = 0; i < 10; ++i) {
    ASSERT_EQ(out->channel->Reserve(), PublishStatus::kOk);
    ASSERT_EQ(out->channel->Reserve(), PublishStatus::kFull);
    ASSERT_TRUE(i > 0 || out->source.rooms == 0);
    out->channel->Cancel();
    ASSERT_TRUE(Eventually([&] { return out->source.rooms > 0; }));
  }
  EXPECT_EQ(out->Publish("1"), PublishStatus::kOk);
}

TEST_P(TransportConformance, AReservationNotNeededByALatchedMessageIsReportedToARefusedPublisher) {
  Offer();
  const PacketHead head = out->NextHead();
  out->source.Latch({head, Publication::PayloadOf("1")});
  in.emplace(*b, "scan", TextType(), kTwoMessages, HoldCredit);
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1; }));
  ASSERT_EQ(out->channel->Reserve(), PublishStatus::kOk);
  ASSERT_EQ(out->channel->Reserve(), PublishStatus::kFull);
  out->channel->Commit(head, Publication::PayloadOf("1"));
  EXPECT_TRUE(Eventually([&] { return out->source.rooms > 0; }));
  EXPECT_EQ(out->Publish("2"), PublishStatus::kOk);
}

TEST_P(TransportConformance, CarriesTheCauseOfEachMessageLatchedOrNot) {
  const std::vector<CauseHead> causes = {{}, {1, 2, 3, -4}, {~0ULL, ~0ULL, ~0U, 1}, {5, 0, 0, 0}};
  Offer();
  PacketHead latched = out->NextHead();
  latched.cause = causes[1];
  out->source.Latch({latched, Publication::PayloadOf("1")});
  in.emplace(*b, "scan", TextType(), kRoomy);
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1; }));
  for (const CauseHead& cause : causes) {
    ASSERT_EQ(out->channel->Reserve(), PublishStatus::kOk);
    PacketHead head = out->NextHead();
    head.cause = cause;
    out->channel->Commit(head, Publication::PayloadOf("x"));
  }
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1 + causes.size(); }));
  in->channel.reset();
  EXPECT_EQ(in->sink.causes.at(0), causes[1]);
  EXPECT_EQ(std::vector<CauseHead>(in->sink.causes.begin() + 1, in->sink.causes.end()), causes);
}

TEST_P(TransportConformance, OneMessageLargerThanTheWindowIsSent) {
  Demand small = kLossless;
  small.credit_bytes = 100;
  ASSERT_TRUE(Join(small));
  for (std::size_t i = 1; i <= 3; ++i) {
    ASSERT_TRUE(out->PublishSoon(std::string(100000, 'x')));
    ASSERT_TRUE(Eventually([&] { return in->sink.count() == i; }));
  }
}

TEST_P(TransportConformance, KeepLastDropsAndCountsTheOldest) {
  ASSERT_TRUE(Join({.queue_depth = 3, .credit_messages = 1, .credit_bytes = 1 << 20}, HoldCredit));
  ASSERT_EQ(out->Publish("1"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1; }));  // From here on its credit is used up.
  for (int i = 2; i <= 10; ++i) ASSERT_EQ(out->Publish(std::to_string(i)), PublishStatus::kOk);
  EXPECT_EQ(out->channel->stats().dropped, 6u);
  EXPECT_GT(out->channel->stats().queued_bytes, 0u);
  for (std::size_t i = 1; i <= 3; ++i) {
    in->sink.Release(1);
    ASSERT_TRUE(Eventually([&] { return in->sink.count() == i + 1; }));
  }
  EXPECT_EQ(in->sink.texts(), (std::vector<std::string>{"1", "8", "9", "10"}));
  EXPECT_TRUE(Eventually([&] { return out->channel->stats().queued_bytes == 0; }));  // Counted after sending.
}

TEST_P(TransportConformance, ASlowPeerDoesNotDelayAnother) {
  Offer();
  Session c(*world, Role::kSubscriber);
  Reception slow(*b, "scan", TextType(), {.queue_depth = 2, .credit_messages = 2}, HoldCredit);
  Reception fast(c, "scan", TextType(), kRoomy);
  ASSERT_TRUE(out->Joined(2));
  for (int i = 1; i <= 500; ++i) ASSERT_EQ(out->Publish(std::to_string(i)), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return fast.sink.count() == 500; }));
  EXPECT_EQ(fast.sink.texts(), Numbers(1, 500));
  EXPECT_LE(slow.sink.count(), 2u);
}

TEST_P(TransportConformance, LatchedMessagesComeOnceAndBeforeLiveOnes) {
  a.emplace(*world, Role::kPublisher);
  out.emplace(*a, "scan");
  for (const char* text : {"1", "2", "3"}) out->source.Latch({out->NextHead(), Publication::PayloadOf(text)});
  std::atomic<bool> stop{false};
  std::atomic<int> next{4};
  std::thread live([&] {
    while (!stop) {
      const std::string text = std::to_string(next.load());
      if (out->Publish(text) == PublishStatus::kOk) ++next;
      std::this_thread::yield();
    }
  });
  b.emplace(*world, Role::kSubscriber);
  in.emplace(*b, "scan", TextType(), kRoomy);
  EXPECT_TRUE(Eventually([&] { return in->sink.count() >= 50; }));
  const auto texts = in->sink.texts();
  for (std::size_t i = 0; i < 3 && i < texts.size(); ++i) EXPECT_EQ(texts[i], std::to_string(i + 1));
  // The first credit covers these. Later, some may be dropped if the receiving threads do not run for a while.
  const std::size_t covered = std::min<std::size_t>(texts.size(), kRoomy.credit_messages);
  for (std::size_t i = 4; i < covered; ++i) EXPECT_EQ(std::stoi(texts[i]), std::stoi(texts[i - 1]) + 1);
  for (std::size_t i = 4; i < texts.size(); ++i) EXPECT_GT(std::stoi(texts[i]), std::stoi(texts[i - 1]));
  if (texts.size() > 3) {
    EXPECT_GE(std::stoi(texts[3]), 4);
  }
  in.reset();
  b.reset();
  stop = true;
  live.join();
}

TEST_P(TransportConformance, LatchedMessagesDoNotDependOnTheQueueDepth) {
  Offer();
  for (const auto& text : Numbers(1, 20)) out->source.Latch({out->NextHead(), Publication::PayloadOf(text)});
  in.emplace(*b, "scan", TextType(), Demand{.queue_depth = 1, .credit_messages = 2});
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 20; }));
  EXPECT_EQ(in->sink.texts(), Numbers(1, 20));
}

TEST_P(TransportConformance, ALiveMessageThatIsAlsoLatchedComesOnce) {
  Offer();
  const PacketHead head = out->NextHead();
  out->source.Latch({head, Publication::PayloadOf("1")});
  in.emplace(*b, "scan", TextType(), kRoomy);
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1; }));
  ASSERT_EQ(out->channel->Reserve(), PublishStatus::kOk);
  out->channel->Commit(head, Publication::PayloadOf("1"));
  ASSERT_EQ(out->Publish("2"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return in->sink.count() >= 2; }));
  EXPECT_EQ(in->sink.texts(), Numbers(1, 2));
}

TEST_P(TransportConformance, AChannelMayBeWithdrawnAndOfferedAgain) {
  Meet();
  in.emplace(*b, "scan");
  for (std::size_t round = 1; round <= 5; ++round) {
    out.emplace(*a, "scan");
    ASSERT_TRUE(out->Joined());
    ASSERT_TRUE(Eventually([&] { return in->channel->publisher_count() == 1 && in->sink.publishers == 1; }));
    ASSERT_EQ(out->Publish("x"), PublishStatus::kOk);
    ASSERT_TRUE(Eventually([&] { return in->sink.count() == round; }));
    out->channel.reset();
    ASSERT_TRUE(Eventually([&] { return in->channel->publisher_count() == 0 && in->sink.publishers == 0; }));
  }
}

TEST_P(TransportConformance, ASubscriptionMayEndAndComeBack) {
  Offer();
  for (int round = 0; round < 5; ++round) {
    in.emplace(*b, "scan");
    ASSERT_TRUE(out->Joined());
    ASSERT_TRUE(Eventually([&] { return out->source.subscribers == 1; }));
    ASSERT_EQ(out->Publish("x"), PublishStatus::kOk);
    ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1; }));
    in->channel.reset();
    ASSERT_TRUE(out->Joined(0));
  }
}

TEST_P(TransportConformance, BothSidesReportAnotherTypeOnce) {
  Offer();
  TypeInfo other = TextType();
  other.name = "hgros.test.Other";
  Ask(other);
  ASSERT_TRUE(Eventually([&] { return a->listener.mismatches == 1 && b->listener.mismatches == 1; }));
  EXPECT_EQ(out->channel->subscriber_count(), 0u);
  EXPECT_EQ(in->channel->publisher_count(), 0u);
}

TEST_P(TransportConformance, PlainStructsOfAnotherLayoutAreRefused) {
  TypeInfo mine = TextType();
  mine.encoding = Encoding::kPlain;
  mine.fingerprint = 1;
  TypeInfo theirs = mine;
  theirs.fingerprint = 2;
  Offer(mine);
  Ask(theirs);
  ASSERT_TRUE(Eventually([&] { return a->listener.mismatches == 1 && b->listener.mismatches == 1; }));
}

TEST_P(TransportConformance, ASchemaOfMoreThanAMegabyteIsRefusedInTheLog) {
  TypeInfo type = ProtobufType("hgros.test.Large", {{"int32", 1}});
  type.descriptor_set = [] { return std::string((1 << 20) + 1, 'x'); };
  Offer(type);
  Ask(AnyType());
  ASSERT_TRUE(Eventually([&] { return in->sink.offered == 1; }));
  EXPECT_TRUE(b->Said("Channel scan: "));
  EXPECT_TRUE(
      b->Said(" describes hgros.test.Large with 1048577 bytes. A description of more than 1048576 bytes is refused."));
  in->channel.reset();
  EXPECT_EQ(in->sink.offers.at(a->id.value)->type_name, "hgros.test.Large");
  EXPECT_EQ(in->sink.offers.at(a->id.value)->descriptor_set, "");
}

TEST_P(TransportConformance, ACompatibleSchemaIsAccepted) {
  const TypeInfo old_type = ProtobufType("hgros.test.Evolving", {{"int32", 1}});
  const TypeInfo new_type = ProtobufType("hgros.test.Evolving", {{"int32", 1}, {"string", 2}});
  Offer(new_type);
  Ask(old_type);
  ASSERT_TRUE(out->Joined());
  ASSERT_TRUE(Eventually([&] { return in->channel->publisher_count() == 1; }));
  ASSERT_EQ(out->Publish("1"), PublishStatus::kOk);
  EXPECT_TRUE(Eventually([&] { return in->sink.count() == 1; }));
  EXPECT_EQ(a->listener.mismatches + b->listener.mismatches, 0);
}

TEST_P(TransportConformance, BothSidesReportAnIncompatibleSchema) {
  const TypeInfo numbers = ProtobufType("hgros.test.Evolving", {{"int32", 1}});
  const TypeInfo strings = ProtobufType("hgros.test.Evolving", {{"string", 1}});
  Offer(numbers);
  Ask(strings);
  ASSERT_TRUE(Eventually([&] { return a->listener.mismatches == 1 && b->listener.mismatches == 1; }));
  ASSERT_TRUE(out->Joined(0));
  ASSERT_EQ(out->Publish("1"), PublishStatus::kOk);
  EXPECT_EQ(in->sink.count(), 0u);
}

TEST_P(TransportConformance, ListenersHearWhenPeersComeAndGo) {
  Meet();
  ASSERT_TRUE(Eventually([&] { return a->listener.came == 1 && b->listener.came == 1; }));
  ASSERT_EQ(a->transport->Peers().size(), 1u);
  EXPECT_EQ(a->transport->Peers()[0].id, b->id);
  EXPECT_EQ(b->transport->Peers()[0].id, a->id);
  b.reset();
  ASSERT_TRUE(Eventually([&] { return a->listener.gone == 1; }));
  EXPECT_TRUE(a->transport->Peers().empty());
}

TEST_P(TransportConformance, DemandMayChangeWhileMessagesFlow) {
  ASSERT_TRUE(Join(kRoomy));
  ASSERT_EQ(out->Publish("1"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1; }));
  in->sink.hold_credit = true;
  in->channel->SetDemand(kTwoMessages);
  int accepted = 1;
  ASSERT_TRUE(Eventually([&] {
    if (out->Publish(std::to_string(accepted + 1)) == PublishStatus::kFull) return true;
    ++accepted;
    return false;
  }));
  // A message that was reserved before the change and committed after it waits for the narrower window.
  ASSERT_TRUE(Eventually([&] {
    in->sink.Release(static_cast<std::size_t>(accepted));
    return in->sink.count() == static_cast<std::size_t>(accepted);
  }));
  EXPECT_EQ(in->sink.texts(), Numbers(1, accepted));
}

TEST_P(TransportConformance, MessagesAreDestroyedOutsideTheTransportsLocks) {
  for (const bool lossless : {false, true}) {
    const Demand demand{.lossless = lossless, .queue_depth = 1, .credit_messages = 3, .credit_bytes = 1 << 20};
    ASSERT_TRUE(Join(demand, HoldCredit));
    // A message's deleter waits for another thread that advertises. That thread cannot proceed while the deleter's
    // thread holds a lock of the transport.
    std::atomic<int> ended{0};
    std::atomic<int> wired{0};
    std::atomic<int> returned{0};
    std::mutex mutex;
    std::vector<std::thread> threads;
    const auto end = [&](const std::string* text) {
      delete text;
      const int turn = ++ended;
      {
        const std::scoped_lock lock(mutex);
        threads.emplace_back([&, turn] {
          Source source;
          (void)a->transport->Advertise("other" + std::to_string(turn), TextType(), source);
          ++wired;
        });
      }
      EXPECT_TRUE(Eventually([&] { return wired >= turn; }));
      ++returned;
    };
    // Large messages are sent without a copy, and are destroyed when the transport no longer uses them.
    const auto publish_three = [&] {
      for (int i = 0; i < 3; ++i) {
        const std::shared_ptr<const std::string> text(new std::string(10'000, 'x'), end);
        ASSERT_EQ(out->channel->Reserve(), PublishStatus::kOk);
        out->channel->Commit(out->NextHead(), {AsBytes(*text), text});
      }
    };
    publish_three();
    ASSERT_TRUE(Eventually([&] { return in->sink.count() == 3; }));
    if (!lossless) publish_three();
    if (lossless) {
      in->sink.Release(1);
      ASSERT_TRUE(Eventually([&] { return ended >= 1; }));
    }
    b->transport->Close(0);
    EXPECT_TRUE(Eventually([&] { return returned == (lossless ? 3 : 6); }));
    for (auto& thread : threads) thread.join();
  }
}

TEST_P(TransportConformance, MessagesAreDestroyedAfterThePublisherReleasesItsLock) {
  ASSERT_TRUE(Join({.queue_depth = 1, .credit_messages = 1}, HoldCredit));
  static thread_local bool locked;
  std::atomic<int> ended{0};
  std::atomic<int> under_the_lock{0};
  const auto end = [&](const std::string* text) {
    delete text;
    ++ended;
    if (locked) ++under_the_lock;
  };
  constexpr int kMessages = 10;
  for (int i = 0; i < kMessages; ++i) {
    Payload payload;
    {
      const std::shared_ptr<const std::string> text(new std::string(10'000, 'x'), end);
      payload = {AsBytes(*text), text};
    }
    const EndsLater behind_the_lock;
    locked = true;  // It stands for a lock that is held until the end of the round.
    ASSERT_EQ(out->channel->Reserve(), PublishStatus::kOk);
    out->channel->Commit(out->NextHead(), payload);
    locked = false;
  }
  ASSERT_TRUE(Eventually([&] { return in->sink.count() > 0; }));
  EXPECT_GT(ended, 0);
  EXPECT_EQ(under_the_lock, 0);
  b->transport->Close(0);
  EXPECT_TRUE(Eventually([&] { return ended == kMessages; }));
}

}  // namespace
}  // namespace hgros::conformance
