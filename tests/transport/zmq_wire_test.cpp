// Messages from and to programs that are not HyperGraph ROS sessions.
#include <random>

#include "hgros/control.pb.h"
#include "hgros/internal/codec/packet.hpp"
#include "support/await.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq/subscribe/publisher_connection.hpp"
#include "transport/zmq_places.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::Publication;
using conformance::Reception;
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
  void Subscribe() {
    pub.Bind(folder.Ipc());
    place.emplace(SubscribeAt(folder.Ipc()));
    in.emplace(*place->transport, "scan", type);
    // The control topic comes first. Without a Welcome, the plain topic follows.
    EXPECT_EQ(pub.Receive().front()[1], '\2');
    EXPECT_EQ(pub.Receive().front(), '\1' + PlainTopic("scan"));
  }
  void Send(const std::string& head, const std::string& data) const { pub.Send({PlainTopic("scan"), head, data}); }

  Folder folder;
  RawSocket pub{ZMQ_XPUB};
  TypeInfo type = TextType();
  std::optional<Place> place;
  std::optional<Reception> in;
};

TEST_F(PlainPublisher, IsReceivedWithoutAHandshake) {
  Subscribe();
  Send(Head("scan"), "hello");
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1; }));
  EXPECT_EQ(in->sink.texts().front(), "hello");
  EXPECT_EQ(in->channel->publisher_count(), 0u);
}

TEST_F(PlainPublisher, RepeatsOfNumberedMessagesAreDropped) {
  Subscribe();
  for (int i = 0; i < 3; ++i) Send(Head("scan", 5), "once");
  Send(Head("scan", 6), "last");
  ASSERT_TRUE(Eventually([&] { return in->sink.count() >= 2; }));
  EXPECT_EQ(in->sink.texts(), (std::vector<std::string>{"once", "last"}));
  EXPECT_EQ(place->transport->stats().repeats, 2u);
}

TEST_F(PlainPublisher, MalformedPacketsAreDroppedAndCountedByKind) {
  Subscribe();
  std::string wrong_separator = Head("scan");
  wrong_separator[4] = 'x';
  std::string wrong_length = Head("scan");
  wrong_length[0] = '\x7f';
  pub.Send({PlainTopic("scan")});
  pub.Send({PlainTopic("scan"), Head("scan")});
  pub.Send({PlainTopic("scan"), Head("scan"), "data", "more"});
  Send("", "data");
  Send(wrong_separator, "data");
  Send(wrong_length, "data");
  Send(Head("scan_other"), "data");
  Send(Head("scan", 0, "another.Type"), "data");
  Send(Head("scan"), "good");
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 1; }));
  EXPECT_EQ(in->sink.texts().front(), "good");
  EXPECT_EQ(in->sink.faults, 8);
  // One frame, two frames, no head, and a head with a length beyond its end.
  EXPECT_EQ(place->Faults(PacketFault::kTruncated), 4u);
  EXPECT_EQ(place->Faults(PacketFault::kSeparator), 1u);
  EXPECT_EQ(place->Faults(PacketFault::kTopic), 1u);
  EXPECT_EQ(place->Faults(PacketFault::kType), 1u);
}

/// A publish endpoint that sends Welcomes in the name of any session.
class ManySessions : public testing::Test {
 protected:
  void Bind() {
    pub = std::make_unique<RawSocket>(ZMQ_XPUB);
    pub->Set(ZMQ_SNDHWM, 0);
    pub->Bind(folder.Ipc());
  }
  /// Waits for a connection; false if none comes.
  [[nodiscard]] bool AwaitConnection() {
    const auto frames = pub->Receive();
    if (frames.empty() || frames.front().empty()) return false;
    topic = frames.front().substr(1);
    return true;
  }
  void Welcome(SessionId session) const {
    auto control = zmq::ControlFrom(session);
    WriteFacts(OwnFacts(session, "many"), *control.mutable_welcome()->mutable_facts());
    control.mutable_welcome()->set_handshake(session.value << 32U);
    pub->Send({topic, control.SerializeAsString()});
  }
  Folder folder;
  std::unique_ptr<RawSocket> pub;
  std::string topic;
  Place place{SubscribeAt(folder.Ipc())};
};

TEST_F(ManySessions, ComeOverOneConnectionOnlySoOften) {
  Bind();
  ASSERT_TRUE(AwaitConnection());
  constexpr std::uint64_t kMany = 1000;
  for (std::uint64_t id = 1; id <= kMany; ++id) Welcome({id});
  ASSERT_TRUE(Eventually([&] { return place.Overruns() > 0 || place.listener.came == kMany; }));
  EXPECT_TRUE(Eventually([&] { return place.listener.gone == zmq::PublisherConnection::kMostSessions; }));
  EXPECT_EQ(place.listener.came, zmq::PublisherConnection::kMostSessions);
  EXPECT_EQ(place.Overruns(), 1U);
  EXPECT_TRUE(Eventually([&] { return place.transport->Peers().empty(); }));
  EXPECT_TRUE(Eventually([&] { return place.TimesSaid("sessions came and went over one connection") == 1; }));
}

TEST_F(ManySessions, DoNotComeOverAConnectionThatHasEnded) {
  Bind();
  ASSERT_TRUE(AwaitConnection());
  Welcome({1});
  ASSERT_TRUE(Eventually([&] { return place.listener.came == 1; }));
  zmq_unbind(pub->get(), folder.Ipc().c_str());  // So that there is no second connection.
  // Still being read when the connection ends.
  constexpr std::uint64_t kMany = 50'000;
  for (std::uint64_t i = 0; i < kMany; ++i) pub->Send({topic, "not a control message"});
  Welcome({1});
  pub->Set(ZMQ_LINGER, 5000);
  pub.reset();
  EXPECT_TRUE(Eventually([&] { return place.listener.gone == 1; }));
  EXPECT_FALSE(test::Await([&] { return place.listener.came > 1; }, std::chrono::seconds(1)));
  EXPECT_TRUE(place.transport->Peers().empty());
}

TEST_F(ManySessions, MayComeOneAfterTheOtherWithConnectionsOfTheirOwn) {
  constexpr int kStarts = zmq::PublisherConnection::kMostSessions + 4;
  for (int i = 1; i <= kStarts; ++i) {
    Bind();
    ASSERT_TRUE(AwaitConnection());
    Welcome({static_cast<std::uint64_t>(i)});
    ASSERT_TRUE(Eventually([&] { return place.listener.came == i; }));
    pub.reset();
    ASSERT_TRUE(Eventually([&] { return place.listener.gone == i; }));
  }
  EXPECT_EQ(place.Overruns(), 0U);
}

TEST(PlainSubscriber, GetsThreeFramesAndCountsAsOne) {
  Folder folder;
  Place place(PublishAt(folder.Ipc()));
  Publication out(*place.transport, "scan");
  const Publication similar(*place.transport, "scan_filtered");
  const RawSocket first(folder.Ipc(), "scan"), second(folder.Ipc(), "scan");
  ASSERT_TRUE(out.Joined());
  EXPECT_EQ(similar.channel->subscriber_count(), 0u);
  std::vector<std::string> frames;
  for (int i = 0; frames.empty() && i < 100; ++i) {  // The second subscriber need not have joined.
    ASSERT_EQ(out.Publish(std::string(5000, 'x')), PublishStatus::kOk);
    frames = first.Receive(100);
  }
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0], PlainTopic("scan"));
  PacketHead read;
  EXPECT_EQ(DecodeHeadFrame(AsBytes(frames[1]), read), PacketFault::kNone);
  EXPECT_EQ(read.channel, "scan");
  EXPECT_EQ(frames[2], std::string(5000, 'x'));
}

TEST(PlainSubscriber, ThatDoesNotReadStarvesNoOthers) {
  constexpr int kMessages = 300;
  Folder folder;
  for (const std::string& endpoint : {folder.Ipc(), std::string("tcp://127.0.0.1:*")}) {
    Place place(PublishAt(endpoint, 4 << 20));
    Publication out(*place.transport, "cloud");
    const RawSocket stuck(place.Bound(), "cloud", 1), reader(place.Bound(), "cloud");
    ASSERT_TRUE(out.Joined());
    int received = 0;
    for (int i = 0; i < kMessages; ++i) {
      (void)out.Publish(std::string(100'000, 'x'));
      received += reader.Receive(20).empty() ? 0 : 1;
    }
    // On a busy machine it is some messages behind.
    while (received <= kMessages / 2 && !reader.Receive(500).empty()) ++received;
    EXPECT_GT(received, kMessages / 2) << endpoint;
    EXPECT_TRUE(place.Said("does not read fast enough")) << endpoint;
    // It learns that, and connects again.
    EXPECT_TRUE(test::Await([&] {
      (void)out.Publish("news");
      const std::vector<std::string> frames = stuck.Receive(20);
      return !frames.empty() && frames.back().find("news") != std::string::npos;
    })) << endpoint;
  }
}

TEST(PlainSubscriber, IsNotCutOffIfItsConnectionIsASessions) {
  Place place(PublishAt(test::kAnyPort, 4 << 20));
  Publication out(*place.transport, "cloud");
  const RawSocket session(place.Bound(), "cloud", 1), reader(place.Bound(), "cloud");
  session.Set(ZMQ_SUBSCRIBE, zmq::ControlTopic(SessionId::Random()));
  ASSERT_FALSE(session.Receive().empty()) << "its Welcome";
  ASSERT_TRUE(out.Joined());
  ASSERT_TRUE(test::Await([&] {
    for (int i = 0; i < 5; ++i) {
      (void)out.Publish(std::string(100'000, 'x'));
      (void)reader.Receive(10);
    }
    return out.channel->stats().dropped >= 100 || place.Said("does not read fast enough");
  })) << "the bytes of all plain subscribers are not used up";
  EXPECT_FALSE(place.Said("does not read fast enough"));
}

TEST(PlainSubscriber, HasALimitOfWaitingBytesIfItDoesNotRead) {
  Folder folder;
  Place place(PublishAt(folder.Ipc(), 1 << 20));
  Publication out(*place.transport, "cloud");
  const RawSocket sub(folder.Ipc(), "cloud", 1);
  ASSERT_TRUE(out.Joined());
  for (int i = 0; i < 200; ++i) ASSERT_EQ(out.Publish(std::string(100'000, 'x')), PublishStatus::kOk);
  EXPECT_GT(out.channel->stats().dropped, 50u);
}

TEST_F(PlainPublisher, MessagesBeyondTheWindowAreDropped) {
  Subscribe();
  in->sink.hold_credit = true;
  in->channel->SetDemand({.queue_depth = 4, .credit_messages = 4});
  for (int i = 1; i <= 10; ++i) Send(Head("scan"), std::to_string(i));
  ASSERT_TRUE(Eventually([&] { return place->Overruns() == 6; }));
  ASSERT_TRUE(Eventually([&] { return in->sink.faults == 6; }));
  EXPECT_EQ(in->sink.texts(), (std::vector<std::string>{"1", "2", "3", "4"}));
  in->sink.Release(1);
  Send(Head("scan"), "11");
  ASSERT_TRUE(Eventually([&] { return in->sink.count() == 5; }));
  EXPECT_EQ(in->sink.texts().back(), "11");
}

TEST_F(PlainPublisher, IsRefusedWithAnotherLayoutEvenIfTheHeadNamesNoType) {
  type.encoding = Encoding::kPlain;
  type.fingerprint = 1;
  Subscribe();
  for (const std::uint64_t fingerprint : {2u, 1u}) {
    PacketHead head;
    head.channel = "scan";
    head.encoding = Encoding::kPlain;
    head.fingerprint = fingerprint;
    std::string frame;
    EncodeHeadFrame(head, frame);
    Send(frame, std::to_string(fingerprint));
  }
  ASSERT_TRUE(Eventually([&] { return in->sink.count() > 0; }));
  EXPECT_EQ(in->sink.texts(), std::vector<std::string>{"1"});
  EXPECT_EQ(place->Faults(PacketFault::kType), 1u);
}

TEST(PlainSubscriber, MayLeaveWithoutEndingTheSubscriptionOfAnother) {
  Folder folder;
  Place place(PublishAt(folder.Ipc()));
  Publication out(*place.transport, "scan");
  const auto hears = [&](const RawSocket& sub) {
    return Eventually([&] {
      (void)out.Publish("x");
      return !sub.Receive(0).empty();
    });
  };
  const RawSocket stays(folder.Ipc(), "scan");
  {
    const RawSocket leaves(folder.Ipc(), "scan");
    ASSERT_TRUE(hears(stays) && hears(leaves));
    leaves.Set(ZMQ_UNSUBSCRIBE, PlainTopic("scan"));
  }
  while (!stays.Receive(100).empty()) {
  }
  EXPECT_TRUE(hears(stays));
  EXPECT_EQ(out.channel->subscriber_count(), 1u);
}

/// Plain filters that are not whole topics, at an ipc or a tcp endpoint.
class InvalidFilter : public testing::TestWithParam<bool> {
 protected:
  InvalidFilter() : publisher(PublishAt(GetParam() ? folder.Ipc() : "tcp://127.0.0.1:*")) {}
  Folder folder;
  Place publisher;
};

TEST_P(InvalidFilter, HoldsNoMessagesOfSessions) {
  Place session(SubscribeAt(publisher.Bound()));
  Publication out(*publisher.transport, "scan");
  const Reception in(*session.transport, "scan", TextType(), {.lossless = true, .credit_messages = 8});
  const RawSocket sub(ZMQ_SUB);
  sub.Set(ZMQ_RCVHWM, 1);
  sub.Set(ZMQ_RCVBUF, 1 << 16);
  sub.Set(ZMQ_SUBSCRIBE, "");
  sub.Connect(publisher.Bound());
  ASSERT_TRUE(Eventually([&] { return out.channel->subscriber_count() == 1 && publisher.Said("a zero byte"); }));
  constexpr std::size_t kCount = 200;
  std::vector<std::weak_ptr<const void>> held;
  for (std::size_t i = 0; i < kCount; ++i) {
    ASSERT_TRUE(Eventually([&] { return out.channel->Reserve() == PublishStatus::kOk; }));
    Payload data = Publication::PayloadOf(std::string(100'000, 'x'));
    held.emplace_back(data.owner);
    out.channel->Commit(out.NextHead(), data);
  }
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == kCount; }));
  EXPECT_TRUE(Eventually([&] { return std::ranges::all_of(held, [](const auto& one) { return one.expired(); }); }))
      << std::ranges::count_if(held, [](const auto& one) { return !one.expired(); }) << " messages wait for a filter";
  EXPECT_EQ(out.channel->subscriber_count(), 1u);
}

TEST_P(InvalidFilter, ClosesTheConnection) {
  const std::string peer = PeerTopic("scan", SessionId::Random());
  for (const std::string& filter : {std::string(), std::string("scan"), peer.substr(0, 5), peer.substr(0, 20),
                                    peer + '\3', std::string("\2"), PlainTopic("scan") + 'x', std::string(300, 'x')}) {
    RawSocket sub(ZMQ_SUB);
    RawSocket monitor(sub, "inproc://monitor", ZMQ_EVENT_DISCONNECTED);
    sub.Set(ZMQ_SUBSCRIBE, filter);
    sub.Connect(publisher.Bound());
    EXPECT_FALSE(monitor.Receive().empty()) << testing::PrintToString(filter);
  }
}

INSTANTIATE_TEST_SUITE_P(PlainSubscriber, InvalidFilter, testing::Bool(),
                         [](const auto& test) { return test.param ? "Ipc" : "Tcp"; });

/// A subscriber that may send any control message.
class LyingSubscriber : public testing::Test {
 protected:
  LyingSubscriber() {
    sub.Connect(folder.Ipc());
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
  std::vector<std::string> NextData() {
    for (;;) {
      auto frames = sub.Receive();
      if (frames.empty() || frames.size() == 3) return frames;
    }
  }
  wire::Control Speak() const { return zmq::ControlFrom(id); }
  void Say(const wire::Control& control) { sub.Send({'\2' + control.SerializeAsString()}); }
  void SayHello() {
    auto hello = Speak();
    hello.mutable_hello()->mutable_facts()->set_wire_major(1);
    hello.mutable_hello()->set_handshake(welcome.handshake());
    Say(hello);
  }
  void Join(std::uint32_t credit_messages) {
    SayHello();
    auto subscribe = Speak();
    auto& asked = *subscribe.mutable_subscribe();
    WriteType("scan", TextType(), *asked.mutable_wanted());
    asked.set_handshake(welcome.handshake());
    asked.set_lossless(true);
    asked.set_credit_messages(credit_messages);
    asked.set_credit_bytes(~std::uint64_t{0});
    Say(subscribe);
    subscribed = Next().subscribed();
  }

  Folder folder;
  Place place{PublishAt(folder.Ipc())};
  Publication out{*place.transport, "scan"};
  RawSocket sub{ZMQ_XSUB};
  const SessionId id = SessionId::Random();
  wire::Welcome welcome;
  wire::Subscribed subscribed;
};

TEST_F(LyingSubscriber, IsGrantedALimitedWindow) {
  Join(~0u);
  EXPECT_GT(subscribed.credit_messages(), 0u);
  EXPECT_LE(subscribed.credit_messages(), 1u << 16);
  EXPECT_EQ(subscribed.credit_bytes(), ZmqOptions().max_credit_bytes);
}

TEST_F(LyingSubscriber, IsDisconnectedAfterATooLongMessage) {
  sub.Send({'\2' + std::string(100'000, 'x')});
  // The connection was closed. ZeroMQ makes another one, which gets a new Welcome.
  EXPECT_NE(Next().welcome().handshake(), 0u);
}

TEST_F(LyingSubscriber, CannotAskForATooLongTypeName) {
  SayHello();
  auto subscribe = Speak();
  subscribe.mutable_subscribe()->mutable_wanted()->set_channel("scan");
  subscribe.mutable_subscribe()->mutable_wanted()->set_type_name(std::string(2000, 'T'));
  subscribe.mutable_subscribe()->set_handshake(welcome.handshake());
  Say(subscribe);
  EXPECT_TRUE(Eventually([&] { return FaultSum(*place.transport) == 1; }));
}

TEST_F(LyingSubscriber, GetsPromisedMessagesEvenIfItNeverReadAboutItsLink) {
  Join(4);
  for (const char* text : {"1", "2"}) ASSERT_EQ(out.Publish(text), PublishStatus::kOk);
  // As after a cut: the same session subscribes again, gets a Welcome, and knows no link.
  const std::uint64_t link = subscribed.link();
  sub.Send({std::string("\0\2", 2) + id.ToString()});
  sub.Send({"\1\2" + id.ToString()});
  welcome = Next().welcome();
  ASSERT_NE(welcome.handshake(), 0u);
  Join(4);
  EXPECT_EQ(subscribed.link(), link);
  EXPECT_EQ(subscribed.next_message(), 1u);
  for (const char* text : {"1", "2"}) {
    const auto frames = NextData();
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[2], text);
  }
  EXPECT_EQ(out.channel->stats().missed, 0u);
}

TEST_F(LyingSubscriber, GetsNoCreditForMessagesThatWereNotSent) {
  Join(2);
  auto credit = Speak();
  credit.mutable_credit()->set_channel("scan");
  credit.mutable_credit()->set_link(subscribed.link());
  credit.mutable_credit()->set_consumed_messages(1'000'000);
  Say(credit);
  ASSERT_TRUE(Eventually([&] { return FaultSum(*place.transport) > 0; }));
  for (int i = 0; i < 2; ++i) ASSERT_EQ(out.Publish("x"), PublishStatus::kOk);
  EXPECT_EQ(out.Publish("x"), PublishStatus::kFull);
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
  const Reception in(*honest.transport, "scan");
  EXPECT_TRUE(Eventually([&] {
    (void)out.Publish("x");
    return in.sink.count() > 0;
  }));
}

/// A publisher that may send any message.
class LyingPublisher : public testing::Test {
 protected:
  LyingPublisher() {
    pub.Bind(folder.Ipc());
    place.emplace(SubscribeAt(folder.Ipc()));
    subscriber = SessionId::FromString(pub.Receive().front().substr(2));
  }
  /// The next wish of the subscriber that answers this Welcome.
  wire::Subscribe NextWish() {
    for (;;) {
      const auto frames = pub.Receive();
      wire::Control control;
      if (frames.empty()) return {};
      if (frames[0][0] != '\2' || !control.ParseFromString(frames[0].substr(1))) continue;
      if (control.has_subscribe() && control.subscribe().handshake() == handshake) return control.subscribe();
    }
  }
  void Say(wire::Control control) {
    control.set_session(id.value);
    pub.Send({'\2' + subscriber.ToString(), control.SerializeAsString()});
  }
  /// Sends Welcome to the subscriber, and opens the link that it asks for. Repeats these bits of its wish right.
  void Join(const TypeInfo& type, std::uint64_t fingerprint, std::uint64_t wish_bits = ~std::uint64_t{0}) {
    wire::Control welcome;
    welcome.mutable_welcome()->mutable_facts()->set_wire_major(1);
    welcome.mutable_welcome()->set_handshake(++handshake);
    Say(welcome);
    const wire::Subscribe asked = NextWish();
    wire::Control subscribed;
    auto& offered = *subscribed.mutable_subscribed()->mutable_offered();
    offered = asked.wanted();
    offered.set_fingerprint(fingerprint);
    if (type.descriptor_set != nullptr) subscribed.mutable_subscribed()->set_descriptor_set(type.descriptor_set());
    subscribed.mutable_subscribed()->set_link(handshake);
    subscribed.mutable_subscribed()->set_wish(asked.wish() ^ ~wish_bits);
    subscribed.mutable_subscribed()->set_credit_messages(~0u);
    subscribed.mutable_subscribed()->set_credit_bytes(~std::uint64_t{0});
    Say(subscribed);
    number = 0;
  }
  void SendData(const PacketHead& head, const std::string& text) {
    std::string topic = PeerTopic("scan", subscriber);
    ++number;
    for (int i = 0; i < 8; ++i) topic += static_cast<char>(number >> (8 * i) & 0xff);
    std::string frame;
    EncodeHeadFrame(head, frame);
    pub.Send({topic, frame, text});
  }

  Folder folder;
  RawSocket pub{ZMQ_XPUB};
  const SessionId id = SessionId::Random();
  SessionId subscriber;
  std::optional<Place> place;
  std::uint64_t handshake = 0;
  std::uint64_t number = 0;
};

PacketHead HeadOf(const TypeInfo& type, const MessageId& id) {
  PacketHead head;
  head.channel = "scan";
  head.type_name = type.name;
  head.encoding = type.encoding;
  head.fingerprint = type.fingerprint;
  head.id = id;
  return head;
}

TEST_F(LyingPublisher, CannotSendMessagesOfAnotherSession) {
  const Reception in(*place->transport, "scan");
  Join(TextType(), 0);
  SendData(HeadOf(TextType(), {id.value + 1, ~std::uint64_t{0}, 1}), "pretender");
  SendData(HeadOf(TextType(), {id.value, 1, 1}), "itself");
  SendData(HeadOf(TextType(), {}), "nobody");
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 2; }));
  EXPECT_EQ(in.sink.texts(), (std::vector<std::string>{"itself", "nobody"}));
  EXPECT_EQ(place->Faults(PacketFault::kHead), 1u);
  EXPECT_EQ(in.sink.faults, 1);
}

// Its answer to an earlier wish may be followed by any number, also of a version without wishes.
TEST_F(LyingPublisher, LosesAMessageOnlyAfterTheAnswerToThisWish) {
  const Reception in(*place->transport, "scan");
  for (const std::uint64_t wish_bits : {std::uint64_t{1}, ~std::uint64_t{0}}) {
    Join(TextType(), 0, wish_bits);
    SendData(HeadOf(TextType(), {}), "first");
    number += 5;
    SendData(HeadOf(TextType(), {}), "of another link");
    number = 1;
    SendData(HeadOf(TextType(), {}), "second");
    const bool lost = wish_bits != 1;
    ASSERT_TRUE(
        Eventually([&] { return lost ? place->Said("so the connection is made again") : in.sink.count() == 2; }));
    EXPECT_EQ(place->Said("so the connection is made again"), lost);
  }
}

TEST_F(LyingPublisher, CannotSendAnotherSchemaThanItNamed) {
  const TypeInfo ours = conformance::ProtobufType("hgros.test.Evolving", {{"int32", 1}});
  TypeInfo theirs = conformance::ProtobufType("hgros.test.Evolving", {{"int32", 1}, {"string", 2}});
  const Reception in(*place->transport, "scan", ours);
  Join(theirs, theirs.fingerprint);
  SendData(HeadOf(theirs, {id.value, 1, 1}), "named");
  SendData(HeadOf(ours, {id.value, 1, 2}), "ours");
  ++theirs.fingerprint;
  SendData(HeadOf(theirs, {id.value, 1, 3}), "another");
  SendData(HeadOf(ours, {id.value, 1, 4}), "last");
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 3; }));
  EXPECT_EQ(in.sink.texts(), (std::vector<std::string>{"named", "ours", "last"}));
  EXPECT_EQ(place->Faults(PacketFault::kType), 1u);
}

TEST_F(LyingPublisher, IsDisconnectedBeyondItsCreditAndMayComeBack) {
  Reception in(*place->transport, "scan", TextType(), {.credit_messages = 4}, conformance::HoldCredit);
  Join(TextType(), 0);
  for (std::uint64_t i = 1; i <= 5; ++i) SendData(HeadOf(TextType(), {id.value, 1, i}), std::to_string(i));
  ASSERT_TRUE(Eventually([&] { return place->Faults(PacketFault::kOverrun) == 1 && place->listener.gone == 1; }));
  EXPECT_EQ(in.sink.count(), 4u);
  EXPECT_EQ(in.channel->publisher_count(), 0u);
  in.sink.Release(4);
  // It connects again, and its control topic comes with the connection.
  ASSERT_TRUE(Eventually([&] {
    const auto frames = pub.Receive(100);
    return !frames.empty() && frames[0] == "\1\2" + subscriber.ToString();
  }));
  Join(TextType(), 0);
  SendData(HeadOf(TextType(), {id.value, 1, 6}), "6");
  EXPECT_TRUE(Eventually([&] { return in.sink.count() == 5; }));
}

TEST_F(LyingPublisher, GetsALimitedTotalWindowForManyLinks) {
  Reception in(*place->transport, "scan", TextType(), {.credit_messages = 4}, conformance::HoldCredit);
  std::uint64_t sequence = 0;
  const auto send_four = [&] {
    Join(TextType(), 0);
    for (int i = 0; i < 4; ++i) SendData(HeadOf(TextType(), {id.value, 1, ++sequence}), "x");
  };
  for (int link = 0; link < 8; ++link) send_four();
  ASSERT_TRUE(Eventually([&] { return in.sink.count() + place->Faults(PacketFault::kOverrun) == 32; }));
  EXPECT_EQ(in.sink.count(), 16u);
  in.sink.Release(16);
  send_four();
  EXPECT_TRUE(Eventually([&] { return in.sink.count() == 20; }));
}

}  // namespace
}  // namespace hgros
