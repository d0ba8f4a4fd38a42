#include <gtest/gtest.h>

#include "hgros/base/error.hpp"
#include "support/await.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq_places.hpp"
#include "transport/zmq_spoiler.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::OpenFiles;
using conformance::Publication;
using conformance::Reception;
using conformance::TextType;
using test::Folder;
using test::Place;
using test::Spoiler;

struct Keys {
  CurveKeyPair server = GenerateCurveKeyPair();
  CurveKeyPair client = GenerateCurveKeyPair();
  CurveKeyPair stranger = GenerateCurveKeyPair();

  [[nodiscard]] ZmqOptions Server(const std::string& endpoint = test::kAnyPort) const {
    ZmqOptions options = test::PublishAt(endpoint);
    options.security = ZmqSecurity{server, {client.public_key}};
    return options;
  }
  [[nodiscard]] ZmqOptions Client(const CurveKeyPair& own, const CurveKeyPair& expected, const Place& at) const {
    ZmqOptions options;
    options.subscribe = {{at.Bound(), std::nullopt, expected.public_key}};
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
  Publication out(*server.transport, "scan");
  const Reception in(*client.transport, "scan");
  ASSERT_TRUE(out.Joined());
  ASSERT_EQ(out.Publish(std::string(100'000, 'x')), PublishStatus::kOk);
  EXPECT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  EXPECT_EQ(server.transport->refused_handshakes(), 0u);
}

TEST(ZmqCurve, ProtectsAnIp6AddressToo) {
  if (!test::HasIp6()) GTEST_SKIP() << "no IPv6 here";
  const Keys keys;
  Place server(keys.Server("tcp://[::1]:*"));
  const Place client(keys.Client(keys.client, keys.server, server));
  const Place stranger(keys.Client(keys.stranger, keys.server, server));
  EXPECT_TRUE(Eventually([&] { return client.listener.came == 1 && server.transport->refused_handshakes() > 0; }));
  EXPECT_EQ(stranger.listener.came, 0);
}

TEST(ZmqCurve, RefusesAndCountsStrangersAndClientsWithoutKeysOrWithAnotherServersKey) {
  const Keys keys;
  Place server(keys.Server());
  Place stranger(keys.Client(keys.stranger, keys.server, server));
  EXPECT_TRUE(Eventually([&] { return server.transport->refused_handshakes() > 0; }));
  Place keyless(test::SubscribeAt(server.Bound()));
  Place mistaken(keys.Client(keys.client, keys.stranger, server));
  Place right(keys.Client(keys.client, keys.server, server));
  EXPECT_TRUE(Eventually([&] { return right.listener.came == 1; }));
  EXPECT_TRUE(Eventually([&] { return server.listener.came == 1; }));
  EXPECT_EQ(server.transport->Peers().size(), 1u);
  EXPECT_EQ(stranger.listener.came + keyless.listener.came + mistaken.listener.came, 0);
  EXPECT_TRUE(Eventually([&] { return stranger.Said("`allowed_clients`"); }));
  const std::string endpoint = server.Bound();
  EXPECT_TRUE(Eventually(
      [&] { return mistaken.Said("No connection to " + endpoint) && mistaken.Said("`network.security.servers`"); }));
  EXPECT_TRUE(Eventually([&] { return keyless.Said("asks for keys"); }));
  EXPECT_TRUE(Eventually([&] { return server.Said("127.0.0.1 cannot connect to " + endpoint + ": it has no keys"); }));
  EXPECT_TRUE(Eventually([&] { return server.Said("it has a wrong public key for this session"); }));
  EXPECT_GE(server.transport->refused_handshakes(), 3u);
  EXPECT_FALSE(right.Said("key"));
}

TEST(ZmqCurve, LogsThatAPublisherDoesNotEncrypt) {
  const Keys keys;
  Place open(test::PublishAt());
  Place client(keys.Client(keys.client, keys.server, open));
  EXPECT_TRUE(Eventually([&] { return client.Said("does not encrypt"); }));
  EXPECT_EQ(client.listener.came, 0);
}

/// A program with allowed keys that is not a session.
class Impostor : public test::RawSocket {
 public:
  Impostor(int type, const CurveKeyPair& own) : RawSocket(type) {
    Set(ZMQ_CURVE_PUBLICKEY, own.public_key);
    Set(ZMQ_CURVE_SECRETKEY, own.secret_key);
  }
  Impostor(int type, const CurveKeyPair& own, const CurveKeyPair& server) : Impostor(type, own) {
    Set(ZMQ_CURVE_SERVERKEY, server.public_key);
  }
  void Say(const wire::Control& control) const { Send({zmq::UpstreamFrame(control)}); }
};

std::uint64_t Refusals(const Place& place) { return place.Faults(PacketFault::kHead); }

class ZmqCurveIdentity : public testing::Test {
 protected:
  ZmqCurveIdentity() {
    EXPECT_TRUE(Eventually([&] {
      return out.channel->subscriber_count() == 1 && client.listener.came == 1 && server.transport->Peers().size() == 1;
    }));
    victim = server.transport->Peers().at(0).id;
  }
  [[nodiscard]] ZmqOptions BothAllowed() const {
    ZmqOptions options = keys.Server();
    options.security->allowed_clients.push_back(keys.stranger.public_key);
    return options;
  }

  const Keys keys;
  Place server{BothAllowed()};
  Place client{keys.Client(keys.client, keys.server, server)};
  Publication out{*server.transport, "scan"};
  Reception in{*client.transport, "scan", TextType(), {.lossless = true, .queue_depth = 8}};
  SessionId victim;
};

TEST_F(ZmqCurveIdentity, AClientCannotSpeakInTheNameOfAnotherSession) {
  const Impostor impostor(ZMQ_XSUB, keys.stranger, keys.server);
  impostor.Connect(server.Bound());
  auto goodbye = zmq::ControlFrom(victim);
  goodbye.mutable_bye();
  auto unsubscribe = zmq::ControlFrom(victim);
  unsubscribe.mutable_unsubscribe()->set_channel("scan");
  impostor.Say(goodbye);
  impostor.Say(unsubscribe);
  EXPECT_TRUE(Eventually([&] { return Refusals(server) == 2; }));
  EXPECT_TRUE(
      server.Said("it is in the name of " + server.transport->Peers().at(0).name() + ", which has another key"));
  EXPECT_EQ(server.listener.gone, 0);
  ASSERT_EQ(out.Publish("still here"), PublishStatus::kOk);
  EXPECT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  EXPECT_EQ(out.channel->subscriber_count(), 1u);
}

// It may see what is sent until its filter was read, see docs/decisions/0008-filters-are-whole-topics.md.
TEST_F(ZmqCurveIdentity, AClientThatSubscribesToWhatIsForAnotherSessionIsClosed) {
  for (const std::string& topic : {zmq::ControlTopic(victim), PeerTopic("scan", victim)}) {
    const std::uint64_t before = Refusals(server);
    const Impostor impostor(ZMQ_XSUB, keys.stranger, keys.server);
    const test::RawSocket monitor(impostor, "inproc://monitor", ZMQ_EVENT_DISCONNECTED);
    impostor.Connect(server.Bound());
    impostor.Send({'\1' + topic});
    EXPECT_TRUE(Eventually([&] { return Refusals(server) > before; }));
    EXPECT_FALSE(monitor.Receive().empty()) << "its connection is closed";
  }
  ASSERT_EQ(out.Publish("to one"), PublishStatus::kOk);
  EXPECT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  EXPECT_EQ(server.listener.gone + client.listener.gone, 0);
}

TEST_F(ZmqCurveIdentity, APublisherCannotAnswerInTheNameOfAnotherSession) {
  const Folder folder;
  const Impostor impostor(ZMQ_XPUB, keys.stranger);
  impostor.Set(ZMQ_CURVE_SERVER, 1);
  impostor.Bind(folder.Ipc());
  client.transport->AddSubscribeEndpoint({folder.Ipc(), std::nullopt, keys.stranger.public_key});
  const std::string topic = impostor.Receive().front().substr(1);
  auto welcome = zmq::ControlFrom(client.transport->Peers().at(0).id);
  welcome.mutable_welcome()->mutable_facts()->set_wire_major(1);
  welcome.mutable_welcome()->set_handshake(1);
  impostor.Send({topic, welcome.SerializeAsString()});
  EXPECT_TRUE(Eventually([&] { return Refusals(client) == 1; }));
  EXPECT_TRUE(impostor.Receive(200).empty()) << "it gets no Hello";
  ASSERT_EQ(out.Publish("from the right one"), PublishStatus::kOk);
  EXPECT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  EXPECT_EQ(client.listener.came, 1);
}

TEST_F(ZmqCurveIdentity, ASessionMayComeAgainWithItsKey) {
  client.transport->RemoveSubscribeEndpoint(server.Bound());
  EXPECT_TRUE(out.Joined(0));
  client.transport->AddSubscribeEndpoint({server.Bound(), std::nullopt, keys.server.public_key});
  EXPECT_TRUE(out.Joined());
  EXPECT_EQ(Refusals(server), 0u);
}

TEST(ZmqCurve, RefusesAnInvalidKey) {
  ZmqOptions options = test::PublishAt();
  options.security = ZmqSecurity{{"short", "short"}, {}};
  EXPECT_THROW(Place place(std::move(options)), Error);
}

// ZeroMQ may take them for connections that are full, and keep them for ever.
TEST(ZmqCurve, ConnectionsOverWhichWrongBytesComeEnd) {
  const Keys keys;
  Place server(keys.Server());
  const std::string endpoint = server.Bound();
  const std::size_t before = OpenFiles();
  for (int i = 0; i < 10; ++i) {
    const std::string channel = "scan" + std::to_string(i);
    const Publication out(*server.transport, channel);
    Spoiler spoiler(endpoint);
    const Impostor subscriber(ZMQ_SUB, keys.client, keys.server);
    subscriber.Set(ZMQ_SUBSCRIBE, PlainTopic(channel));
    subscriber.Connect(spoiler.endpoint());
    ASSERT_TRUE(out.Joined());
    spoiler.Spoil();
    subscriber.Set(ZMQ_SUBSCRIBE, PlainTopic("other"));
    ASSERT_TRUE(Eventually([&] { return spoiler.done(); }));
  }
  EXPECT_TRUE(test::Await([&] { return OpenFiles() <= before; })) << OpenFiles() << " instead of " << before;
  Place client(keys.Client(keys.client, keys.server, server));
  const Publication out(*server.transport, "scan");
  const Reception in(*client.transport, "scan");
  EXPECT_TRUE(out.Joined());
}

// ZeroMQ, here or there, reads no more of that connection, and does not end it.
TEST(ZmqCurve, SubscribersComeBackAfterWrongBytes) {
  for (const auto side : {Spoiler::Side::kClient, Spoiler::Side::kServer}) {
    const Keys keys;
    Place server(keys.Server());
    Publication out(*server.transport, "scan");
    Spoiler spoiler(server.Bound(), side, Spoiler::Then::kGoesOn);
    ZmqOptions options = keys.Client(keys.client, keys.server, server);
    options.subscribe.front().endpoint = spoiler.endpoint();
    Place client(std::move(options));
    const Reception in(*client.transport, "scan");
    ASSERT_TRUE(out.Joined());
    spoiler.Spoil();
    std::size_t before = 0;
    EXPECT_TRUE(test::Await([&] {
      if (spoiler.spoils() || spoiler.connections() < 2) before = in.sink.count();
      (void)out.Publish("again");
      return in.sink.count() > before;
    })) << static_cast<int>(side);
  }
}

}  // namespace
}  // namespace hgros
