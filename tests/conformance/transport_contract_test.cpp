// The numbered contracts of include/hgros/transport, for every transport. Each test shows one behavior.
#include <algorithm>

#include "conformance/transport_conformance.hpp"
#include "hgros/transport/ends_later.hpp"

namespace hgros::conformance {
namespace {

using Role = Session::Role;

std::vector<std::string> Numbers(int first, int last) {
  std::vector<std::string> texts;
  for (int i = first; i <= last; ++i) texts.push_back(std::to_string(i));
  return texts;
}

constexpr Demand kLossless{.lossless = true, .queue_depth = 16, .credit_messages = 8, .credit_bytes = 1 << 20};
constexpr Demand kOneMessage{.lossless = true, .queue_depth = 16, .credit_messages = 1, .credit_bytes = 1 << 20};
constexpr Demand kRoomy{.lossless = false, .queue_depth = 10000, .credit_messages = 64, .credit_bytes = 64 << 20};

bool Joined(const Publication& publication, std::size_t subscribers = 1) {
  return Eventually([&] { return publication.channel->subscriber_count() == subscribers; });
}

TEST_P(TransportConformance, DeliversInOrder) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "scan", TextType());
  Reception in(b, "scan", TextType(), kLossless);
  ASSERT_TRUE(Joined(out));
  for (int i = 1; i <= 1000; ++i) ASSERT_TRUE(out.PublishSoon(std::to_string(i)));
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1000; }));
  EXPECT_EQ(in.sink.texts(), Numbers(1, 1000));
  EXPECT_TRUE(Eventually([&] { return out.channel->stats().sent == 1000; }));  // Counted after sending.
  EXPECT_FALSE(in.sink.overlapped);
}

TEST_P(TransportConformance, ChannelsWhoseNamesBeginAlikeStayApart) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication scan(a, "scan", TextType()), filtered(a, "scan_filtered", TextType());
  Reception in(b, "scan", TextType());
  ASSERT_TRUE(Joined(scan));
  ASSERT_EQ(filtered.Publish("other"), PublishStatus::kOk);
  ASSERT_EQ(scan.Publish("mine"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return in.sink.count() > 0; }));
  EXPECT_EQ(in.sink.texts(), std::vector<std::string>{"mine"});
  EXPECT_EQ(filtered.channel->subscriber_count(), 0u);
}

TEST_P(TransportConformance, ASubscriberOfAnyTypeGetsMessagesAndTheirSchema) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  const TypeInfo type = ProtobufType("hgros.test.Any", {{"int32", 1}});
  Publication out(a, "scan", type);
  Reception in(b, "scan", AnyType(), kLossless);
  ASSERT_TRUE(Joined(out));
  ASSERT_TRUE(Eventually([&] { return in.sink.offered == 1; }));
  for (int i = 1; i <= 100; ++i) ASSERT_TRUE(out.PublishSoon(std::to_string(i)));
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 100; }));
  EXPECT_EQ(in.sink.texts(), Numbers(1, 100));
  in.channel.reset();
  EXPECT_EQ(*in.sink.offers.at(a.id.value), SchemaOf(type));
  for (const auto& schema : in.sink.schemas) EXPECT_EQ(schema, in.sink.offers.at(a.id.value));
  EXPECT_EQ(a.listener.mismatches + b.listener.mismatches, 0);
}

TEST_P(TransportConformance, ALargePayloadIsKeptUntilSentAndThenReleased) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "cloud", TextType());
  Reception in(b, "cloud", TextType(), kLossless);
  ASSERT_TRUE(Joined(out));
  const std::string text(3 << 20, 'x');
  Payload payload = Publication::PayloadOf(text);
  const std::weak_ptr<const void> owner = payload.owner;
  in.sink.hold_credit = true;
  ASSERT_EQ(out.channel->Reserve(), PublishStatus::kOk);
  out.channel->Commit(out.NextHead(), payload);
  if (world->shows_in_place()) {
    EXPECT_GT(owner.use_count(), 1) << "the bytes were copied";
  }
  payload = {};
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  EXPECT_EQ(in.sink.texts().front(), text);
  in.sink.Release(1);
  EXPECT_TRUE(Eventually([&] { return owner.expired(); }));
}

TEST_P(TransportConformance, ReserveTakesCreditFromAllLosslessSubscribersOrNone) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber), c(*world, Role::kSubscriber);
  Publication out(a, "scan", TextType());
  Demand narrow = kLossless;
  narrow.credit_messages = 2;
  Reception slow(b, "scan", TextType(), narrow), fast(c, "scan", TextType(), kLossless);
  slow.sink.hold_credit = true;
  ASSERT_TRUE(Joined(out, 2));
  ASSERT_EQ(out.Publish("1"), PublishStatus::kOk);
  ASSERT_EQ(out.Publish("2"), PublishStatus::kOk);
  for (int i = 0; i < 50; ++i) ASSERT_EQ(out.Publish("3"), PublishStatus::kFull);
  ASSERT_TRUE(Eventually([&] { return fast.sink.count() == 2 && slow.sink.count() == 2; }));
  slow.sink.Release(1);
  ASSERT_TRUE(Eventually([&] { return out.source.rooms > 0; }));
  ASSERT_EQ(out.Publish("3"), PublishStatus::kOk);
  EXPECT_EQ(out.Publish("4"), PublishStatus::kFull);
  ASSERT_TRUE(Eventually([&] { return fast.sink.count() == 3 && slow.sink.count() == 3; }));
  EXPECT_EQ(fast.sink.texts(), Numbers(1, 3));
  EXPECT_EQ(slow.sink.texts(), Numbers(1, 3));
}

TEST_P(TransportConformance, CancelGivesTheReservationBack) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "scan", TextType());
  Reception in(b, "scan", TextType(), kOneMessage);
  ASSERT_TRUE(Joined(out));
  for (int i = 0; i < 10; ++i) {
    ASSERT_EQ(out.channel->Reserve(), PublishStatus::kOk);
    ASSERT_EQ(out.channel->Reserve(), PublishStatus::kFull);
    out.channel->Cancel();
  }
  EXPECT_EQ(out.Publish("1"), PublishStatus::kOk);
}

TEST_P(TransportConformance, ACancelledReservationIsReportedToARefusedPublisher) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "scan", TextType());
  Reception in(b, "scan", TextType(), kOneMessage);
  ASSERT_TRUE(Joined(out));
  ASSERT_EQ(out.channel->Reserve(), PublishStatus::kOk);
  ASSERT_EQ(out.channel->Reserve(), PublishStatus::kFull);
  EXPECT_EQ(out.source.rooms, 0);
  out.channel->Cancel();
  EXPECT_TRUE(Eventually([&] { return out.source.rooms > 0; }));
}

TEST_P(TransportConformance, AReservationNotNeededByALatchedMessageIsReportedToARefusedPublisher) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "map", TextType());
  const PacketHead head = out.NextHead();
  out.source.Latch({head, Publication::PayloadOf("1")});
  Demand two = kLossless;
  two.credit_messages = 2;
  Reception in(b, "map", TextType(), two, [](Sink& sink) { sink.hold_credit = true; });
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  ASSERT_EQ(out.channel->Reserve(), PublishStatus::kOk);
  ASSERT_EQ(out.channel->Reserve(), PublishStatus::kFull);
  out.channel->Commit(head, Publication::PayloadOf("1"));
  EXPECT_TRUE(Eventually([&] { return out.source.rooms > 0; }));
  EXPECT_EQ(out.Publish("2"), PublishStatus::kOk);
}

TEST_P(TransportConformance, CarriesTheCauseOfEachMessageLatchedOrNot) {
  const std::vector<CauseHead> causes = {{}, {1, 2, 3, -4}, {~0ULL, ~0ULL, ~0U, 1}, {5, 0, 0, 0}};
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "map", TextType());
  PacketHead latched = out.NextHead();
  latched.cause = causes[1];
  out.source.Latch({latched, Publication::PayloadOf("1")});
  Reception in(b, "map", TextType(), kRoomy);
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  for (const CauseHead& cause : causes) {
    ASSERT_EQ(out.channel->Reserve(), PublishStatus::kOk);
    PacketHead head = out.NextHead();
    head.cause = cause;
    out.channel->Commit(head, Publication::PayloadOf("x"));
  }
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1 + causes.size(); }));
  in.channel.reset();
  EXPECT_EQ(in.sink.causes.at(0), causes[1]);
  EXPECT_EQ(std::vector<CauseHead>(in.sink.causes.begin() + 1, in.sink.causes.end()), causes);
}

TEST_P(TransportConformance, OneMessageLargerThanTheWindowIsSent) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "cloud", TextType());
  Demand small = kLossless;
  small.credit_bytes = 100;
  Reception in(b, "cloud", TextType(), small);
  ASSERT_TRUE(Joined(out));
  for (std::size_t i = 1; i <= 3; ++i) {
    ASSERT_TRUE(out.PublishSoon(std::string(100000, 'x')));
    ASSERT_TRUE(Eventually([&] { return in.sink.count() == i; }));
  }
}

TEST_P(TransportConformance, KeepLastDropsAndCountsTheOldest) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "scan", TextType());
  Reception in(b, "scan", TextType(),
               {.lossless = false, .queue_depth = 3, .credit_messages = 1, .credit_bytes = 1 << 20});
  in.sink.hold_credit = true;
  ASSERT_TRUE(Joined(out));
  ASSERT_EQ(out.Publish("1"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1; }));  // From here on its credit is used up.
  for (int i = 2; i <= 10; ++i) ASSERT_EQ(out.Publish(std::to_string(i)), PublishStatus::kOk);
  EXPECT_EQ(out.channel->stats().dropped, 6u);
  EXPECT_GT(out.channel->stats().queued_bytes, 0u);
  for (std::size_t i = 1; i <= 3; ++i) {
    in.sink.Release(1);
    ASSERT_TRUE(Eventually([&] { return in.sink.count() == i + 1; }));
  }
  EXPECT_EQ(in.sink.texts(), (std::vector<std::string>{"1", "8", "9", "10"}));
  EXPECT_TRUE(Eventually([&] { return out.channel->stats().queued_bytes == 0; }));  // Counted after sending.
}

TEST_P(TransportConformance, ASlowPeerDoesNotDelayAnother) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber), c(*world, Role::kSubscriber);
  Publication out(a, "scan", TextType());
  Reception slow(b, "scan", TextType(), {.lossless = false, .queue_depth = 2, .credit_messages = 2});
  Reception fast(c, "scan", TextType(), kRoomy);
  slow.sink.hold_credit = true;
  ASSERT_TRUE(Joined(out, 2));
  for (int i = 1; i <= 500; ++i) ASSERT_EQ(out.Publish(std::to_string(i)), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return fast.sink.count() == 500; }));
  EXPECT_EQ(fast.sink.texts(), Numbers(1, 500));
  EXPECT_LE(slow.sink.count(), 2u);
}

TEST_P(TransportConformance, LatchedMessagesComeOnceAndBeforeLiveOnes) {
  Session a(*world, Role::kPublisher);
  Publication out(a, "map", TextType());
  for (const char* text : {"1", "2", "3"}) out.source.Latch({out.NextHead(), Publication::PayloadOf(text)});
  std::atomic<bool> stop{false};
  std::atomic<int> next{4};
  std::thread live([&] {
    while (!stop) {
      const std::string text = std::to_string(next.load());
      if (out.Publish(text) == PublishStatus::kOk) ++next;
      std::this_thread::yield();
    }
  });
  {
    Session b(*world, Role::kSubscriber);
    Reception in(b, "map", TextType(), kRoomy);
    EXPECT_TRUE(Eventually([&] { return in.sink.count() >= 50; }));
    const auto texts = in.sink.texts();
    for (std::size_t i = 0; i < 3 && i < texts.size(); ++i) EXPECT_EQ(texts[i], std::to_string(i + 1));
    // The first credit covers these. Later, some may be dropped if the receiving threads do not run for a while.
    const std::size_t covered = std::min<std::size_t>(texts.size(), kRoomy.credit_messages);
    for (std::size_t i = 4; i < covered; ++i) EXPECT_EQ(std::stoi(texts[i]), std::stoi(texts[i - 1]) + 1);
    for (std::size_t i = 4; i < texts.size(); ++i) EXPECT_GT(std::stoi(texts[i]), std::stoi(texts[i - 1]));
    if (texts.size() > 3) {
      EXPECT_GE(std::stoi(texts[3]), 4);
    }
  }
  stop = true;
  live.join();
}

TEST_P(TransportConformance, LatchedMessagesDoNotDependOnTheQueueDepth) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "map", TextType());
  for (int i = 1; i <= 20; ++i) {
    out.source.Latch({out.NextHead(), Publication::PayloadOf(std::to_string(i))});
  }
  Reception in(b, "map", TextType(), {.lossless = false, .queue_depth = 1, .credit_messages = 2});
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 20; }));
  EXPECT_EQ(in.sink.texts(), Numbers(1, 20));
}

TEST_P(TransportConformance, ALiveMessageThatIsAlsoLatchedComesOnce) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "map", TextType());
  const PacketHead head = out.NextHead();
  out.source.Latch({head, Publication::PayloadOf("1")});
  Reception in(b, "map", TextType(), kRoomy);
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  ASSERT_EQ(out.channel->Reserve(), PublishStatus::kOk);
  out.channel->Commit(head, Publication::PayloadOf("1"));
  ASSERT_EQ(out.Publish("2"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return in.sink.count() >= 2; }));
  EXPECT_EQ(in.sink.texts(), Numbers(1, 2));
}

TEST_P(TransportConformance, SubscribingBeforeThePublisherExistsWorks) {
  Session b(*world, Role::kSubscriber);
  Reception in(b, "scan", TextType());
  Session a(*world, Role::kPublisher);
  Publication out(a, "scan", TextType());
  ASSERT_TRUE(Joined(out));
  ASSERT_EQ(out.Publish("1"), PublishStatus::kOk);
  EXPECT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
}

TEST_P(TransportConformance, AChannelMayBeWithdrawnAndOfferedAgain) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Reception in(b, "scan", TextType());
  for (std::size_t round = 1; round <= 5; ++round) {
    Publication out(a, "scan", TextType());
    ASSERT_TRUE(Joined(out));
    ASSERT_TRUE(Eventually([&] { return in.channel->publisher_count() == 1 && in.sink.publishers == 1; }));
    ASSERT_EQ(out.Publish("x"), PublishStatus::kOk);
    ASSERT_TRUE(Eventually([&] { return in.sink.count() == round; }));
    out.channel.reset();
    ASSERT_TRUE(Eventually([&] { return in.channel->publisher_count() == 0 && in.sink.publishers == 0; }));
  }
}

TEST_P(TransportConformance, ASubscriptionMayEndAndComeBack) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "scan", TextType());
  for (int round = 0; round < 5; ++round) {
    Reception in(b, "scan", TextType());
    ASSERT_TRUE(Joined(out));
    ASSERT_TRUE(Eventually([&] { return out.source.subscribers == 1; }));
    ASSERT_EQ(out.Publish("x"), PublishStatus::kOk);
    ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
    in.channel.reset();
    ASSERT_TRUE(Joined(out, 0));
  }
}

TEST_P(TransportConformance, BothSidesReportAnotherTypeOnce) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "scan", TextType());
  TypeInfo other = TextType();
  other.name = "hgros.test.Other";
  Reception in(b, "scan", other);
  ASSERT_TRUE(Eventually([&] { return a.listener.mismatches == 1 && b.listener.mismatches == 1; }));
  EXPECT_EQ(out.channel->subscriber_count(), 0u);
  EXPECT_EQ(in.channel->publisher_count(), 0u);
}

TEST_P(TransportConformance, PlainStructsOfAnotherLayoutAreRefused) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  TypeInfo mine = TextType();
  mine.encoding = Encoding::kPlain;
  mine.fingerprint = 1;
  TypeInfo theirs = mine;
  theirs.fingerprint = 2;
  Publication out(a, "scan", mine);
  Reception in(b, "scan", theirs);
  ASSERT_TRUE(Eventually([&] { return a.listener.mismatches == 1 && b.listener.mismatches == 1; }));
}

TEST_P(TransportConformance, ASchemaOfMoreThanAMegabyteIsRefusedInTheLog) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  TypeInfo type = ProtobufType("hgros.test.Large", {{"int32", 1}});
  type.descriptor_set = [] { return std::string((1 << 20) + 1, 'x'); };
  Publication out(a, "scan", type);
  Reception in(b, "scan", AnyType());
  ASSERT_TRUE(Eventually([&] { return in.sink.offered == 1; }));
  EXPECT_TRUE(b.Said("Channel scan: " + a.id.ToString()));
  EXPECT_TRUE(
      b.Said(" describes hgros.test.Large with 1048577 bytes. A description of more than 1048576 bytes is refused."));
  in.channel.reset();
  EXPECT_EQ(in.sink.offers.at(a.id.value)->type_name, "hgros.test.Large");
  EXPECT_EQ(in.sink.offers.at(a.id.value)->descriptor_set, "");
}

TEST_P(TransportConformance, ACompatibleSchemaIsAccepted) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  const TypeInfo old_type = ProtobufType("hgros.test.Evolving", {{"int32", 1}});
  const TypeInfo new_type = ProtobufType("hgros.test.Evolving", {{"int32", 1}, {"string", 2}});
  Publication out(a, "scan", new_type);
  Reception in(b, "scan", old_type);
  ASSERT_TRUE(Joined(out));
  ASSERT_TRUE(Eventually([&] { return in.channel->publisher_count() == 1; }));
  ASSERT_EQ(out.Publish("1"), PublishStatus::kOk);
  EXPECT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  EXPECT_EQ(a.listener.mismatches + b.listener.mismatches, 0);
}

TEST_P(TransportConformance, BothSidesReportAnIncompatibleSchema) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  const TypeInfo numbers = ProtobufType("hgros.test.Evolving", {{"int32", 1}});
  const TypeInfo strings = ProtobufType("hgros.test.Evolving", {{"string", 1}});
  Publication out(a, "scan", numbers);
  Reception in(b, "scan", strings);
  ASSERT_TRUE(Eventually([&] { return a.listener.mismatches == 1 && b.listener.mismatches == 1; }));
  ASSERT_TRUE(Joined(out, 0));
  ASSERT_EQ(out.Publish("1"), PublishStatus::kOk);
  EXPECT_EQ(in.sink.count(), 0u);
}

TEST_P(TransportConformance, ListenersHearWhenPeersComeAndGo) {
  Session a(*world, Role::kPublisher);
  {
    Session b(*world, Role::kSubscriber);
    ASSERT_TRUE(Eventually([&] { return a.listener.came == 1 && b.listener.came == 1; }));
    ASSERT_EQ(a.transport->Peers().size(), 1u);
    EXPECT_EQ(a.transport->Peers()[0].id, b.id);
    EXPECT_EQ(b.transport->Peers()[0].id, a.id);
  }
  ASSERT_TRUE(Eventually([&] { return a.listener.gone == 1; }));
  EXPECT_TRUE(a.transport->Peers().empty());
}

TEST_P(TransportConformance, DemandMayChangeWhileMessagesFlow) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "scan", TextType());
  Reception in(b, "scan", TextType(), kRoomy);
  ASSERT_TRUE(Joined(out));
  ASSERT_EQ(out.Publish("1"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  in.sink.hold_credit = true;
  Demand two = kLossless;
  two.credit_messages = 2;
  in.channel->SetDemand(two);
  int accepted = 1;
  ASSERT_TRUE(Eventually([&] {
    if (out.Publish(std::to_string(accepted + 1)) == PublishStatus::kFull) return true;
    ++accepted;
    return false;
  }));
  // A message that was reserved before the change and committed after it waits for the narrower window.
  ASSERT_TRUE(Eventually([&] {
    in.sink.Release(static_cast<std::size_t>(accepted));
    return in.sink.count() == static_cast<std::size_t>(accepted);
  }));
  EXPECT_EQ(in.sink.texts(), Numbers(1, accepted));
}

TEST_P(TransportConformance, MessagesAreDestroyedOutsideTheTransportsLocks) {
  for (const bool lossless : {false, true}) {
    Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
    Publication out(a, "scan", TextType());
    Demand demand = kLossless;
    demand.lossless = lossless;
    demand.queue_depth = 1;
    demand.credit_messages = 3;
    Reception in(b, "scan", TextType(), demand, [](Sink& sink) { sink.hold_credit = true; });
    ASSERT_TRUE(Joined(out));
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
          (void)a.transport->Advertise("other" + std::to_string(turn), TextType(), source);
          ++wired;
        });
      }
      EXPECT_TRUE(Eventually([&] { return wired >= turn; }));
      ++returned;
    };
    // Large messages are sent without a copy, and are destroyed when the transport no longer uses them.
    for (int i = 0; i < 3; ++i) {
      const std::shared_ptr<const std::string> text(new std::string(10'000, 'x'), end);
      if (out.channel->Reserve() == PublishStatus::kOk) out.channel->Commit(out.NextHead(), {AsBytes(*text), text});
    }
    ASSERT_TRUE(Eventually([&] { return in.sink.count() == 3; }));
    for (int i = 0; i < 3 && !lossless; ++i) {
      const std::shared_ptr<const std::string> text(new std::string(10'000, 'x'), end);
      ASSERT_EQ(out.channel->Reserve(), PublishStatus::kOk);
      out.channel->Commit(out.NextHead(), {AsBytes(*text), text});
    }
    if (lossless) {
      in.sink.Release(1);
      ASSERT_TRUE(Eventually([&] { return ended >= 1; }));
    }
    b.transport->Close(0);
    EXPECT_TRUE(Eventually([&] { return returned == (lossless ? 3 : 6); }));
    for (auto& thread : threads) thread.join();
  }
}

TEST_P(TransportConformance, MessagesAreDestroyedAfterThePublisherReleasesItsLock) {
  Session a(*world, Role::kPublisher), b(*world, Role::kSubscriber);
  Publication out(a, "scan", TextType());
  const Demand demand{.queue_depth = 1, .credit_messages = 1};
  Reception in(b, "scan", TextType(), demand, [](Sink& sink) { sink.hold_credit = true; });
  ASSERT_TRUE(Joined(out));
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
    ASSERT_EQ(out.channel->Reserve(), PublishStatus::kOk);
    out.channel->Commit(out.NextHead(), payload);
    locked = false;
  }
  ASSERT_TRUE(Eventually([&] { return in.sink.count() > 0; }));
  EXPECT_GT(ended, 0);
  EXPECT_EQ(under_the_lock, 0);
  b.transport->Close(0);
  EXPECT_TRUE(Eventually([&] { return ended == kMessages; }));
}

}  // namespace
}  // namespace hgros::conformance
