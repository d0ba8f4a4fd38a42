#include "bridge/joined/transport_move.hpp"

#include <random>

#include "conformance/transport_conformance.hpp"
#include "hgros/clock/time.hpp"
#include "session/domain_fixture.hpp"
#include "session/hand_made_session.hpp"
#include "support/at_once.hpp"
#include "support/seed.hpp"

namespace hgros::test {
namespace {

constexpr TransportIndex kShm = 0;
constexpr TransportIndex kZmq = 1;

InboundMessage Numbered(std::uint64_t sequence) {
  InboundMessage message;
  message.head.id.sequence = sequence;
  return message;
}

// A subscriber: drops repeats, and counts overtaken messages as lost.
struct Subscriber {
  void Take(const std::vector<InboundMessage>& messages) {
    for (const InboundMessage& message : messages) {
      if (message.head.id.sequence <= last) continue;
      lost += message.head.id.sequence - last - 1;
      last = message.head.id.sequence;
    }
  }
  std::uint64_t last = 0;
  std::uint64_t lost = 0;
};

TEST(MoveOfTransport, LosesAndReordersNothingHoweverTheTwoTransportsInterleave) {
  std::minstd_rand random(Seed());
  const auto pick = [&](std::uint64_t from, std::uint64_t to) {
    return std::uniform_int_distribution<std::uint64_t>(from, to)(random);
  };
  for (int round = 0; round < 2000; ++round) {
    const std::uint64_t first = pick(1, 20);  // The first message of the new transport.
    const std::uint64_t last = first + pick(0, 20);
    const std::uint64_t old_ends = pick(first, last);  // The old transport ends some time after the move.
    TransportMove move({.from = kZmq, .to = kShm});
    Subscriber subscriber;
    std::uint64_t next_old = 1, next_new = first;
    while (next_old <= old_ends || next_new <= last) {
      const bool old = next_new > last || (next_old <= old_ends && pick(0, 1) == 0);
      subscriber.Take(old ? move.Arrive(Numbered(next_old++), kZmq) : move.Arrive(Numbered(next_new++), kShm));
    }
    if (!move.done()) subscriber.Take(move.Finish());
    ASSERT_EQ(subscriber.lost, 0U) << first << " " << last << " " << old_ends;
    ASSERT_EQ(subscriber.last, last);
  }
}

TEST(MoveOfTransport, WaitsForTheOldTransportAndThenDropsItsRepeats) {
  TransportMove move({.from = kZmq, .to = kShm});
  EXPECT_EQ(move.Arrive(Numbered(1), kZmq).size(), 1U);
  EXPECT_TRUE(move.Arrive(Numbered(3), kShm).empty()) << "2 is still on its way";
  EXPECT_FALSE(move.done());
  EXPECT_EQ(move.Arrive(Numbered(2), kZmq).size(), 2U);
  EXPECT_TRUE(move.done());
  EXPECT_TRUE(move.Arrive(Numbered(3), kZmq).empty());
  EXPECT_EQ(move.Arrive(Numbered(4), kShm).size(), 1U);
}

TEST(MoveOfTransport, ContinuesWhenTheOldTransportHasEnded) {
  TransportMove move({.from = kZmq, .to = kShm});
  EXPECT_TRUE(move.Arrive(Numbered(3), kShm).empty());
  EXPECT_EQ(move.Finish().size(), 1U);
  EXPECT_EQ(move.Arrive(Numbered(4), kShm).size(), 1U);
}

/// A publisher that opens its shared memory only on request.
class LateTalker final : public HandMadeSession {
 public:
  LateTalker(const std::string& domain, const std::string& endpoint) : HandMadeSession("late") {
    ZmqOptions options;
    options.publish = {{endpoint, std::nullopt}};
    OpenZmq(std::move(options));
    over_zmq_ = zmq_->Advertise("notes", type_, source_);
    Enlist(domain, {ChannelUse{.channel = "notes", .publishes = true}});
  }

  void ShareMemoryWith(SessionId peer) {
    OpenShm(peer);
    over_shm_ = shm_->Advertise("notes", type_, source_);
  }
  void EndShm() {
    over_shm_.reset();
    shm_->Close(0);
  }

  void Say() {
    ASSERT_TRUE(Await([&] { return over_zmq_->Reserve() == PublishStatus::kOk; }));
    ASSERT_TRUE(!over_shm_ || Await([&] { return over_shm_->Reserve() == PublishStatus::kOk; }));
    PacketHead head;
    head.channel = "notes";
    head.type_name = type_.name;
    head.encoding = type_.encoding;
    head.fingerprint = type_.fingerprint;
    head.id = {id().value, 1, ++said_};
    head.publish_time_ns = WallNow().nanoseconds;
    const Payload data = type_.encode(std::make_shared<const Note>(std::to_string(said_)));
    over_zmq_->Commit(head, data);
    if (over_shm_) over_shm_->Commit(head, data);
  }
  [[nodiscard]] std::uint64_t said() const { return said_; }
  [[nodiscard]] std::size_t subscribers() const {
    return over_zmq_->subscriber_count() + (over_shm_ ? over_shm_->subscriber_count() : 0);
  }

 private:
  const TypeInfo& type_ = TypeOf<Note>();
  conformance::Source source_;
  std::uint64_t said_ = 0;
  std::unique_ptr<OutboundChannel> over_zmq_;
  std::unique_ptr<OutboundChannel> over_shm_;
};

/// A session, and a talker that it reaches over ZeroMQ.
struct Moving {
  explicit Moving(const std::string& domain) : talker(domain, bus.Endpoint("late")) {}
  void Begin() {
    ASSERT_TRUE(Await([&] { return talker.subscribers() == 1; })) << "over ZeroMQ, after two seconds";
    for (int i = 0; i < 20; ++i) talker.Say();
    ASSERT_TRUE(Await([&] { return notes.size() == 20; }));
    ASSERT_EQ(UsedTransport(), "ZeroMQ");
  }
  [[nodiscard]] std::string UsedTransport() const {
    const auto peers = listener->Peers();
    return peers.size() == 1 ? peers[0].transport : std::to_string(peers.size()) + " peers";
  }
  // Publishes until the condition holds.
  void SayUntil(const std::function<bool()>& condition) {
    EXPECT_TRUE(Await([&] {
      talker.Say();
      return condition();
    }));
  }
  void ExpectOnly(const std::string& transport) {
    EXPECT_TRUE(Await([&] { return UsedTransport() == transport && talker.subscribers() == 1; })) << transport;
    for (int i = 0; i < 100; ++i) talker.Say();
    EXPECT_TRUE(Await([&] { return notes.size() == talker.said(); })) << notes.size() << " of " << talker.said();
    Linger(std::chrono::milliseconds(100));
    const auto texts = notes.texts();
    ASSERT_EQ(texts.size(), talker.said());
    for (std::size_t i = 0; i < texts.size(); ++i) ASSERT_EQ(texts[i], std::to_string(i + 1));
  }

  const Bus bus;
  Notes notes;
  Robot listener{"network: {subscribers: [" + bus.Subscriber("late") +
                 "], heartbeat_ms: 100, peer_timeout_ms: 2000}\n"};
  Subscription subscription = listener->FromAny<Note>("notes", kSerial, std::ref(notes), {.queue = Queue::KeepAll(64)});
  LateTalker talker;
};

class MovingPeer : public DomainFixture {
 protected:
  MovingPeer() {
    for (auto* const one : {&flowing, &silent, &ending}) {
      Enter("test-" + SessionId::Random().ToString());
      one->emplace(std::getenv("HGROS_DOMAIN"));
    }
  }
  std::optional<Moving> flowing, silent, ending;
};

TEST_F(MovingPeer, LosesNothing) {
  const auto moves_to_late_shared_memory_while_messages_flow_and_returns_when_that_ends = [this] {
    Moving& one = *flowing;
    ASSERT_NO_FATAL_FAILURE(one.Begin());
    one.talker.ShareMemoryWith(one.listener->id());
    one.SayUntil([&] { return one.UsedTransport() == "shared memory"; });
    for (int i = 0; i < 100; ++i) one.talker.Say();  // While ZeroMQ ends.
    one.ExpectOnly("shared memory");
    EXPECT_TRUE(one.listener.Said("through shared memory, and its messages move there."));
    one.talker.EndShm();
    one.ExpectOnly("ZeroMQ");
  };
  const auto moves_to_late_shared_memory_without_messages = [this] {
    Moving& one = *silent;
    ASSERT_NO_FATAL_FAILURE(one.Begin());
    one.talker.ShareMemoryWith(one.listener->id());
    one.ExpectOnly("shared memory");
  };
  const auto loses_no_waiting_message_when_the_old_transport_ends = [this] {
    Moving& one = *ending;
    ASSERT_NO_FATAL_FAILURE(one.Begin());
    one.talker.ShareMemoryWith(one.listener->id());
    one.SayUntil([&] { return one.talker.subscribers() == 2 || one.UsedTransport() == "shared memory"; });
    EXPECT_TRUE(Await([&] { return one.notes.size() == one.talker.said(); }));
    one.listener->RemoveSubscriberEndpoint(one.bus.Endpoint("late"));
    one.ExpectOnly("shared memory");
  };
  AtOnce({moves_to_late_shared_memory_while_messages_flow_and_returns_when_that_ends,
          moves_to_late_shared_memory_without_messages, loses_no_waiting_message_when_the_old_transport_ends});
}

}  // namespace
}  // namespace hgros::test
