// What comes from, and goes to, programs that are not HyperGraph ROS sessions.
#include <gmock/gmock.h>

#include <random>

#include "hgros/codec/packet.hpp"
#include "hgros/control.pb.h"
#include "transport/zmq_places.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::Publication;
using conformance::TextType;
using test::Folder;
using test::Place;
using test::PublishAt;
using test::RawSocket;
using test::SubscribeAt;

std::string Head(const std::string& channel, std::uint64_t sequence = 0, const std::string& type = {}) {
  PacketHead head;
  head.channel = channel;
  head.type_name = type;
  head.encoding = Encoding::kCustom;
  head.id = {sequence == 0 ? std::uint64_t{0} : std::uint64_t{77}, 1, sequence};
  std::string frame;
  EncodeHeadFrame(head, frame);
  return frame;
}

std::uint64_t FaultSum(const Transport& transport) {
  std::uint64_t sum = 0;
  for (const auto count : transport.stats().faults) sum += count;
  return sum;
}

class PlainPublisher : public testing::Test {
 protected:
  PlainPublisher() : pub(ZMQ_XPUB) {
    zmq_bind(pub.get(), folder.Ipc().c_str());
    place = std::make_unique<Place>(SubscribeAt(folder.Ipc()));
    channel = place->transport->Subscribe("scan", TextType(), {}, sink);
    // The control topic comes first, then, as nobody welcomes it, the plain one.
    EXPECT_EQ(pub.Receive().front()[1], '\2');
    EXPECT_EQ(pub.Receive().front(), '\1' + PlainTopic("scan"));
  }
  Folder folder;
  RawSocket pub;
  conformance::Sink sink;
  std::unique_ptr<Place> place;
  std::unique_ptr<InboundChannel> channel;
};

TEST_F(PlainPublisher, IsHeardWithoutAHandshake) {
  pub.Send({PlainTopic("scan"), Head("scan"), "hello"});
  ASSERT_TRUE(Eventually([&] { return sink.count() == 1; }));
  EXPECT_EQ(sink.texts().front(), "hello");
  EXPECT_EQ(channel->publisher_count(), 0u);
}

TEST_F(PlainPublisher, RepeatsOfNumberedMessagesAreDropped) {
  for (int i = 0; i < 3; ++i) pub.Send({PlainTopic("scan"), Head("scan", 5), "once"});
  pub.Send({PlainTopic("scan"), Head("scan", 6), "last"});
  ASSERT_TRUE(Eventually([&] { return sink.count() >= 2; }));
  EXPECT_EQ(sink.texts(), (std::vector<std::string>{"once", "last"}));
}

TEST_F(PlainPublisher, MalformedPacketsAreDroppedAndCountedByKind) {
  std::string wrong_separator = Head("scan");
  wrong_separator[4] = 'x';
  std::string wrong_length = Head("scan");
  wrong_length[0] = '\x7f';
  pub.Send({PlainTopic("scan")});
  pub.Send({PlainTopic("scan"), Head("scan")});
  pub.Send({PlainTopic("scan"), Head("scan"), "data", "more"});
  pub.Send({PlainTopic("scan"), "", "data"});
  pub.Send({PlainTopic("scan"), wrong_separator, "data"});
  pub.Send({PlainTopic("scan"), wrong_length, "data"});
  pub.Send({PlainTopic("scan"), Head("scan_other"), "data"});
  pub.Send({PlainTopic("scan"), Head("scan", 0, "another.Type"), "data"});
  pub.Send({PlainTopic("scan"), Head("scan"), "good"});
  ASSERT_TRUE(Eventually([&] { return sink.count() == 1; }));
  EXPECT_EQ(sink.texts().front(), "good");
  EXPECT_EQ(sink.faults, 8);
  const auto faults = place->transport->stats().faults;
  // One frame, two frames, no head, and a head that says it is longer.
  EXPECT_EQ(faults[static_cast<std::size_t>(PacketFault::kTruncated)], 4u);
  EXPECT_EQ(faults[static_cast<std::size_t>(PacketFault::kSeparator)], 1u);
  EXPECT_EQ(faults[static_cast<std::size_t>(PacketFault::kTopic)], 1u);
  EXPECT_EQ(faults[static_cast<std::size_t>(PacketFault::kType)], 1u);
}

TEST_F(PlainPublisher, RandomFramesDoNoHarm) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    std::vector<std::string> frames{PlainTopic("scan")};
    for (unsigned n = random() % 4; n > 0; --n) {
      std::string frame = random() % 2 == 0 ? Head("scan") : std::string();
      for (unsigned i = random() % 64; i > 0; --i) {
        if (!frame.empty() && random() % 2 == 0) {
          frame[random() % frame.size()] = static_cast<char>(random());
        } else {
          frame.push_back(static_cast<char>(random()));
        }
      }
      frames.push_back(std::move(frame));
    }
    pub.Send(frames);
  }
  pub.Send({PlainTopic("scan"), Head("scan"), "good"});
  EXPECT_TRUE(Eventually([&] {
    const auto texts = sink.texts();
    return !texts.empty() && texts.back() == "good";
  }));
  EXPECT_GT(FaultSum(*place->transport), 0u);
}

TEST(PlainSubscriber, GetsThreeFramesAndCountsAsOne) {
  Folder folder;
  Place place(PublishAt(folder.Ipc()));
  conformance::Source source;
  const auto out = place.transport->Advertise("scan", TextType(), source);
  const auto similar = place.transport->Advertise("scan_filtered", TextType(), source);
  RawSocket first(ZMQ_SUB), second(ZMQ_SUB);
  for (const auto* sub : {&first, &second}) {
    zmq_connect(sub->get(), folder.Ipc().c_str());
    const std::string topic = PlainTopic("scan");
    zmq_setsockopt(sub->get(), ZMQ_SUBSCRIBE, topic.data(), topic.size());
  }
  ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 1; }));
  EXPECT_EQ(similar->subscriber_count(), 0u);
  PacketHead head;
  head.channel = "scan";
  head.type_name = TextType().name;
  head.encoding = Encoding::kCustom;
  head.id = {1, 1, 1};
  std::vector<std::string> frames;
  for (int i = 0; frames.empty() && i < 100; ++i) {  // The second may still be joining: it does not matter here.
    ASSERT_EQ(out->Reserve(), PublishStatus::kOk);
    out->Commit(head, Publication::PayloadOf(std::string(5000, 'x')));
    frames = first.Receive(100);
  }
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0], PlainTopic("scan"));
  PacketHead read;
  EXPECT_EQ(DecodeHeadFrame(AsBytes(frames[1]), read), PacketFault::kNone);
  EXPECT_EQ(read.channel, "scan");
  EXPECT_EQ(frames[2], std::string(5000, 'x'));
}

TEST(PlainSubscriber, ThatDoesNotReadIsBoundedInBytes) {
  Folder folder;
  ZmqOptions options = PublishAt(folder.Ipc());
  options.plain_queue_bytes = 1 << 20;
  Place place(std::move(options));
  conformance::Source source;
  const auto out = place.transport->Advertise("cloud", TextType(), source);
  RawSocket sub(ZMQ_SUB);
  const int few = 1;
  zmq_setsockopt(sub.get(), ZMQ_RCVHWM, &few, sizeof few);
  zmq_connect(sub.get(), folder.Ipc().c_str());
  zmq_setsockopt(sub.get(), ZMQ_SUBSCRIBE, "", 0);
  ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 1; }));
  PacketHead head;
  head.channel = "cloud";
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(out->Reserve(), PublishStatus::kOk);
    out->Commit(head, Publication::PayloadOf(std::string(100'000, 'x')));
  }
  EXPECT_GT(out->stats().dropped, 50u);
}

/// A subscriber that says what it likes.
class LyingSubscriber : public testing::Test {
 protected:
  LyingSubscriber() : place(PublishAt(folder.Ipc())), sub(ZMQ_XSUB) {
    out = place.transport->Advertise("scan", TextType(), source);
    zmq_connect(sub.get(), folder.Ipc().c_str());
    sub.Send({"\1\2" + id.ToString()});
    sub.Send({'\1' + PeerTopic("scan", id)});
    welcome = Next().welcome();
  }
  wire::Control Next() {
    for (;;) {
      const auto frames = sub.Receive();
      wire::Control control;
      if (frames.empty()) return control;
      if (frames.size() == 2 && control.ParseFromString(frames[1]) && !control.has_heartbeat()) return control;
    }
  }
  wire::Control Speak() const {
    wire::Control control;
    control.set_session(id.value);
    return control;
  }
  void Say(const wire::Control& control) { sub.Send({'\2' + control.SerializeAsString()}); }
  void Join(std::uint32_t credit_messages) {
    auto hello = Speak();
    hello.mutable_hello()->mutable_facts()->set_wire_major(1);
    hello.mutable_hello()->set_handshake(welcome.handshake());
    Say(hello);
    auto subscribe = Speak();
    auto& asked = *subscribe.mutable_subscribe();
    asked.mutable_wanted()->set_channel("scan");
    asked.mutable_wanted()->set_type_name(TextType().name);
    asked.mutable_wanted()->set_encoding(static_cast<std::uint32_t>(Encoding::kCustom));
    asked.set_handshake(welcome.handshake());
    asked.set_lossless(true);
    asked.set_credit_messages(credit_messages);
    asked.set_credit_bytes(~std::uint64_t{0});
    Say(subscribe);
    subscribed = Next().subscribed();
  }

  Folder folder;
  Place place;
  RawSocket sub;
  const SessionId id = SessionId::Random();
  conformance::Source source;
  std::unique_ptr<OutboundChannel> out;
  wire::Welcome welcome;
  wire::Subscribed subscribed;
};

TEST_F(LyingSubscriber, IsGrantedNoAbsurdWindow) {
  Join(~0u);
  EXPECT_GT(subscribed.credit_messages(), 0u);
  EXPECT_LE(subscribed.credit_messages(), 1u << 16);
  EXPECT_LT(subscribed.credit_bytes(), std::uint64_t{1} << 40);
}

TEST_F(LyingSubscriber, GetsNoCreditForWhatItWasNotSent) {
  Join(2);
  auto credit = Speak();
  credit.mutable_credit()->set_channel("scan");
  credit.mutable_credit()->set_link(subscribed.link());
  credit.mutable_credit()->set_consumed_messages(1'000'000);
  Say(credit);
  ASSERT_TRUE(Eventually([&] { return FaultSum(*place.transport) > 0; }));
  PacketHead head;
  head.channel = "scan";
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(out->Reserve(), PublishStatus::kOk);
    out->Commit(head, Publication::PayloadOf("x"));
  }
  EXPECT_EQ(out->Reserve(), PublishStatus::kFull);
}

TEST_F(LyingSubscriber, RandomControlMessagesDoNoHarm) {
  Join(4);
  for (unsigned seed = 1; seed <= 500; ++seed) {
    std::mt19937_64 random(seed);
    auto said = Speak();
    if (random() % 4 == 0) said.set_session(random() % 3);
    switch (random() % 6) {
      case 0:
        said.mutable_credit()->set_channel(random() % 2 == 0 ? "scan" : "no");
        said.mutable_credit()->set_link(subscribed.link());
        said.mutable_credit()->set_consumed_messages(random());
        said.mutable_credit()->set_consumed_bytes(random());
        break;
      case 1:
        said.mutable_subscribe()->mutable_wanted()->set_channel(random() % 2 == 0 ? "scan" : std::string(300, 'x'));
        said.mutable_subscribe()->set_handshake(welcome.handshake());
        said.mutable_subscribe()->set_received_messages(random());
        said.mutable_subscribe()->set_link(subscribed.link());
        said.mutable_subscribe()->set_change_only(random() % 2 == 0);
        break;
      case 2: said.mutable_unsubscribe()->set_channel("scan"); break;
      case 3: said.mutable_hello()->set_handshake(random() % 2 == 0 ? welcome.handshake() : random()); break;
      case 4: said.mutable_bye(); break;
      default: said.mutable_withdrawn()->set_channel("scan");
    }
    std::string frame = '\2' + said.SerializeAsString();
    if (random() % 3 == 0) frame[random() % frame.size()] = static_cast<char>(random() | 2);
    if (random() % 10 == 0) frame.resize(random() % frame.size());
    sub.Send({frame});
  }
  Place honest(SubscribeAt(folder.Ipc()));
  conformance::Sink sink;
  const auto in = honest.transport->Subscribe("scan", TextType(), {}, sink);
  PacketHead head;
  head.channel = "scan";
  EXPECT_TRUE(Eventually([&] {
    if (out->Reserve() == PublishStatus::kOk) out->Commit(head, Publication::PayloadOf("x"));
    return sink.count() > 0;
  }));
}

}  // namespace
}  // namespace hgros
