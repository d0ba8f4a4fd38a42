#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>

#include "hgros/base/error.hpp"
#include "support/await.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq_places.hpp"
#include "transport/zmq_spoiler.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::TextType;
using test::Folder;
using test::Place;
using test::Spoiler;

struct Keys {
  CurveKeyPair server = GenerateCurveKeyPair();
  CurveKeyPair client = GenerateCurveKeyPair();
  CurveKeyPair stranger = GenerateCurveKeyPair();

  [[nodiscard]] ZmqOptions Server() const {
    ZmqOptions options = test::PublishAt("tcp://127.0.0.1:*");
    options.security = ZmqSecurity{server, {client.public_key}};
    return options;
  }
  [[nodiscard]] ZmqOptions Client(const CurveKeyPair& own, const CurveKeyPair& expected, const Place& at) const {
    ZmqOptions options;
    options.subscribe = {{at.transport->BoundEndpoints().front(), std::nullopt, expected.public_key}};
    options.security = ZmqSecurity{own, {}};
    return options;
  }
};

TEST(ZmqCurve, PublicKeyBelongsToTheSecretKey) {
  const Keys keys;
  EXPECT_EQ(PublicCurveKeyOf(keys.server.secret_key), keys.server.public_key);
  EXPECT_THROW((void)PublicCurveKeyOf("short"), Error);
}

TEST(ZmqCurve, PublicKeysHaveNoVariableOfARobotFile) {
  for (int i = 0; i < 2000; ++i) {  // One in 185 would.
    ASSERT_EQ(GenerateCurveKeyPair().public_key.find("${"), std::string::npos);
  }
}

TEST(ZmqCurve, SessionsWithTheRightKeysExchangeMessages) {
  const Keys keys;
  Place server(keys.Server());
  Place client(keys.Client(keys.client, keys.server, server));
  conformance::Source source;
  conformance::Sink sink;
  const auto out = server.transport->Advertise("scan", TextType(), source);
  const auto in = client.transport->Subscribe("scan", TextType(), {}, sink);
  ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 1; }));
  PacketHead head;
  head.channel = "scan";
  head.encoding = Encoding::kCustom;
  ASSERT_EQ(out->Reserve(), PublishStatus::kOk);
  out->Commit(head, conformance::Publication::PayloadOf(std::string(100'000, 'x')));
  EXPECT_TRUE(Eventually([&] { return sink.count() == 1; }));
  EXPECT_EQ(server.transport->refused_handshakes(), 0u);
}

TEST(ZmqCurve, RefusesAndCountsAStrangersKey) {
  const Keys keys;
  Place server(keys.Server());
  Place stranger(keys.Client(keys.stranger, keys.server, server));
  EXPECT_TRUE(Eventually([&] { return server.transport->refused_handshakes() > 0; }));
  EXPECT_EQ(server.listener.came, 0);
  EXPECT_EQ(stranger.listener.came, 0);
  EXPECT_TRUE(Eventually([&] { return stranger.Said("`allowed_clients`"); }));
}

TEST(ZmqCurve, RefusesClientsWithoutKeysOrWithAnotherServersKey) {
  const Keys keys;
  Place server(keys.Server());
  Place keyless(test::SubscribeAt(server.transport->BoundEndpoints().front()));
  Place mistaken(keys.Client(keys.client, keys.stranger, server));
  Place right(keys.Client(keys.client, keys.server, server));
  EXPECT_TRUE(Eventually([&] { return right.listener.came == 1; }));
  EXPECT_TRUE(Eventually([&] { return server.listener.came == 1; }));
  EXPECT_EQ(server.transport->Peers().size(), 1u);
  EXPECT_EQ(keyless.listener.came + mistaken.listener.came, 0);
  const std::string endpoint = server.transport->BoundEndpoints().front();
  EXPECT_TRUE(Eventually(
      [&] { return mistaken.Said("No connection to " + endpoint) && mistaken.Said("`network.security.servers`"); }));
  EXPECT_TRUE(Eventually([&] { return keyless.Said("asks for keys"); }));
  EXPECT_TRUE(Eventually([&] { return server.Said("127.0.0.1 cannot connect to " + endpoint + ": it has no keys"); }));
  EXPECT_TRUE(Eventually([&] { return server.Said("it has a wrong public key for this session"); }));
  EXPECT_GE(server.transport->refused_handshakes(), 2u);
  EXPECT_FALSE(right.Said("key"));
}

TEST(ZmqCurve, LogsThatAPublisherDoesNotEncrypt) {
  const Keys keys;
  Place open(test::PublishAt("tcp://127.0.0.1:*"));
  Place client(keys.Client(keys.client, keys.server, open));
  EXPECT_TRUE(Eventually([&] { return client.Said("does not encrypt"); }));
  EXPECT_EQ(client.listener.came, 0);
}

/// A program with allowed keys that is not a session.
class Impostor {
 public:
  Impostor(int type, const CurveKeyPair& own) : socket(type) {
    Set(ZMQ_CURVE_PUBLICKEY, own.public_key);
    Set(ZMQ_CURVE_SECRETKEY, own.secret_key);
  }
  void Connect(const std::string& endpoint, const CurveKeyPair& server) const {
    Set(ZMQ_CURVE_SERVERKEY, server.public_key);
    zmq_connect(socket.get(), endpoint.c_str());
  }
  void Set(int option, const std::string& value) const {
    ASSERT_EQ(zmq_setsockopt(socket.get(), option, value.data(), value.size()), 0);
  }
  void Say(const wire::Control& control) const { socket.Send({zmq::UpstreamFrame(control)}); }

  test::RawSocket socket;
};

std::uint64_t Refusals(const Place& place) {
  return place.transport->stats().faults[static_cast<std::size_t>(PacketFault::kHead)];
}

class ZmqCurveIdentity : public testing::Test {
 protected:
  ZmqCurveIdentity() : server(BothAllowed()), client(keys.Client(keys.client, keys.server, server)) {
    out = server.transport->Advertise("scan", TextType(), source);
    in = client.transport->Subscribe("scan", TextType(), {.lossless = true, .queue_depth = 8}, sink);
    EXPECT_TRUE(Eventually([&] {
      return out->subscriber_count() == 1 && client.listener.came == 1 && server.transport->Peers().size() == 1;
    }));
    victim = server.transport->Peers().at(0).id;
  }
  [[nodiscard]] ZmqOptions BothAllowed() const {
    ZmqOptions options = keys.Server();
    options.security->allowed_clients.push_back(keys.stranger.public_key);
    return options;
  }
  void Publish(const std::string& text) {
    PacketHead head;
    head.channel = "scan";
    head.encoding = Encoding::kCustom;
    ASSERT_EQ(out->Reserve(), PublishStatus::kOk);
    out->Commit(head, conformance::Publication::PayloadOf(text));
  }

  const Keys keys;
  conformance::Source source;
  conformance::Sink sink;
  Place server;
  Place client;
  std::unique_ptr<OutboundChannel> out;
  std::unique_ptr<InboundChannel> in;
  SessionId victim;
};

TEST_F(ZmqCurveIdentity, AClientCannotSpeakInTheNameOfAnotherSession) {
  const Impostor impostor(ZMQ_XSUB, keys.stranger);
  impostor.Connect(server.transport->BoundEndpoints().front(), keys.server);
  auto goodbye = zmq::ControlFrom(victim);
  goodbye.mutable_bye();
  auto unsubscribe = zmq::ControlFrom(victim);
  unsubscribe.mutable_unsubscribe()->set_channel("scan");
  impostor.Say(goodbye);
  impostor.Say(unsubscribe);
  EXPECT_TRUE(Eventually([&] { return Refusals(server) == 2; }));
  EXPECT_TRUE(server.Said("in the name of session " + victim.ToString()));
  EXPECT_EQ(server.listener.gone, 0);
  Publish("still here");
  EXPECT_TRUE(Eventually([&] { return sink.count() == 1; }));
  EXPECT_EQ(out->subscriber_count(), 1u);
}

// It may see what is sent until its filter was read, see docs/decisions/0008-filters-are-whole-topics.md.
TEST_F(ZmqCurveIdentity, AClientThatSubscribesToWhatIsForAnotherSessionIsClosed) {
  for (const std::string& topic : {zmq::ControlTopic(victim), PeerTopic("scan", victim)}) {
    const std::uint64_t before = Refusals(server);
    const Impostor impostor(ZMQ_XSUB, keys.stranger);
    const test::RawSocket monitor(impostor.socket, "inproc://monitor", ZMQ_EVENT_DISCONNECTED);
    impostor.Connect(server.transport->BoundEndpoints().front(), keys.server);
    impostor.socket.Send({'\1' + topic});
    EXPECT_TRUE(Eventually([&] { return Refusals(server) > before; }));
    EXPECT_FALSE(monitor.Receive().empty()) << "its connection is closed";
  }
  Publish("to one");
  EXPECT_TRUE(Eventually([&] { return sink.count() == 1; }));
  EXPECT_EQ(server.listener.gone + client.listener.gone, 0);
}

TEST_F(ZmqCurveIdentity, APublisherCannotAnswerInTheNameOfAnotherSession) {
  const Folder folder;
  Impostor impostor(ZMQ_XPUB, keys.stranger);
  const int on = 1;
  zmq_setsockopt(impostor.socket.get(), ZMQ_CURVE_SERVER, &on, sizeof on);
  ASSERT_EQ(zmq_bind(impostor.socket.get(), folder.Ipc().c_str()), 0);
  client.transport->AddSubscribeEndpoint({folder.Ipc(), std::nullopt, keys.stranger.public_key});
  const std::string topic = impostor.socket.Receive().front().substr(1);
  auto welcome = zmq::ControlFrom(client.transport->Peers().at(0).id);
  welcome.mutable_welcome()->mutable_facts()->set_wire_major(1);
  welcome.mutable_welcome()->set_handshake(1);
  impostor.socket.Send({topic, welcome.SerializeAsString()});
  EXPECT_TRUE(Eventually([&] { return Refusals(client) == 1; }));
  EXPECT_TRUE(impostor.socket.Receive(200).empty()) << "it gets no Hello";
  Publish("from the right one");
  EXPECT_TRUE(Eventually([&] { return sink.count() == 1; }));
  EXPECT_EQ(client.listener.came, 1);
}

TEST_F(ZmqCurveIdentity, ASessionMayComeAgainWithItsKey) {
  client.transport->RemoveSubscribeEndpoint(server.transport->BoundEndpoints().front());
  EXPECT_TRUE(Eventually([&] { return out->subscriber_count() == 0; }));
  client.transport->AddSubscribeEndpoint(
      {server.transport->BoundEndpoints().front(), std::nullopt, keys.server.public_key});
  EXPECT_TRUE(Eventually([&] { return out->subscriber_count() == 1; }));
  EXPECT_EQ(Refusals(server), 0u);
}

TEST(ZmqCurve, RefusesAnInvalidKey) {
  ZmqOptions options = test::PublishAt("tcp://127.0.0.1:*");
  options.security = ZmqSecurity{{"short", "short"}, {}};
  EXPECT_THROW(Place place(std::move(options)), Error);
}

std::size_t OpenFiles() {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}));
}

// ZeroMQ may take them for connections that are full, and keep them for ever.
TEST(ZmqCurve, ConnectionsOverWhichWrongBytesComeEnd) {
  const Keys keys;
  Place server(keys.Server());
  const std::string endpoint = server.transport->BoundEndpoints().front();
  const std::size_t before = OpenFiles();
  for (int i = 0; i < 10; ++i) {
    const std::string channel = "scan" + std::to_string(i);
    conformance::Source source;
    const auto out = server.transport->Advertise(channel, TextType(), source);
    Spoiler spoiler(endpoint);
    const test::RawSocket subscriber(ZMQ_SUB);
    zmq_setsockopt(subscriber.get(), ZMQ_CURVE_SERVERKEY, keys.server.public_key.c_str(), 41);
    zmq_setsockopt(subscriber.get(), ZMQ_CURVE_PUBLICKEY, keys.client.public_key.c_str(), 41);
    zmq_setsockopt(subscriber.get(), ZMQ_CURVE_SECRETKEY, keys.client.secret_key.c_str(), 41);
    zmq_setsockopt(subscriber.get(), ZMQ_SUBSCRIBE, channel.c_str(), channel.size() + 1);
    zmq_connect(subscriber.get(), spoiler.endpoint().c_str());
    ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 1; }));
    spoiler.Spoil();
    zmq_setsockopt(subscriber.get(), ZMQ_SUBSCRIBE, "other", sizeof "other");
    ASSERT_TRUE(Eventually([&] { return spoiler.done(); }));
  }
  EXPECT_TRUE(test::Await([&] { return OpenFiles() <= before; })) << OpenFiles() << " instead of " << before;
  Place client(keys.Client(keys.client, keys.server, server));
  conformance::Source source;
  conformance::Sink sink;
  const auto out = server.transport->Advertise("scan", TextType(), source);
  const auto in = client.transport->Subscribe("scan", TextType(), {}, sink);
  EXPECT_TRUE(Eventually([&] { return out->subscriber_count() == 1; }));
}

// ZeroMQ, here or there, reads no more of that connection, and does not end it.
TEST(ZmqCurve, SubscribersComeBackAfterWrongBytes) {
  for (const auto side : {Spoiler::Side::kClient, Spoiler::Side::kServer}) {
    const Keys keys;
    Place server(keys.Server());
    const std::string endpoint = server.transport->BoundEndpoints().front();
    conformance::Source source;
    const auto out = server.transport->Advertise("scan", TextType(), source);
    Spoiler spoiler(endpoint, side, Spoiler::Then::kGoesOn);
    ZmqOptions options = keys.Client(keys.client, keys.server, server);
    options.subscribe.front().endpoint = spoiler.endpoint();
    Place client(std::move(options));
    conformance::Sink sink;
    const auto in = client.transport->Subscribe("scan", TextType(), {}, sink);
    ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 1; }));
    spoiler.Spoil();
    PacketHead head;
    head.channel = "scan";
    head.encoding = Encoding::kCustom;
    std::size_t before = 0;
    EXPECT_TRUE(test::Await([&] {
      if (spoiler.spoils() || spoiler.connections() < 2) before = sink.count();
      if (out->Reserve() == PublishStatus::kOk) out->Commit(head, conformance::Publication::PayloadOf("again"));
      return sink.count() > before;
    })) << static_cast<int>(side);
  }
}

}  // namespace
}  // namespace hgros
