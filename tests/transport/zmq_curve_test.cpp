#include <gtest/gtest.h>

#include "hgros/base/error.hpp"
#include "transport/zmq_places.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::TextType;
using test::Place;

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
  EXPECT_TRUE(
      Eventually([&] { return mistaken.Said("No connection to " + endpoint) && mistaken.Said("`server_key`"); }));
  EXPECT_TRUE(Eventually([&] { return keyless.Said("asks for keys"); }));
  EXPECT_FALSE(right.Said("No connection to"));
}

TEST(ZmqCurve, LogsThatAPublisherDoesNotEncrypt) {
  const Keys keys;
  Place open(test::PublishAt("tcp://127.0.0.1:*"));
  Place client(keys.Client(keys.client, keys.server, open));
  EXPECT_TRUE(Eventually([&] { return client.Said("does not encrypt"); }));
  EXPECT_EQ(client.listener.came, 0);
}

TEST(ZmqCurve, RefusesAnInvalidKey) {
  ZmqOptions options = test::PublishAt("tcp://127.0.0.1:*");
  options.security = ZmqSecurity{{"short", "short"}, {}};
  EXPECT_THROW(Place place(std::move(options)), Error);
}

}  // namespace
}  // namespace hgros
