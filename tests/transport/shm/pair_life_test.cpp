// The end of a pair, and the order in which pairs are read.
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>

#include "conformance/transport_conformance.hpp"
#include "hgros/transport/shm_transport.hpp"
#include "support/await.hpp"
#include "transport/shm/false_peer.hpp"

namespace hgros::shm {
namespace {

using conformance::Publication;
using conformance::Reception;
using conformance::Sink;
using conformance::TextType;
using test::Await;

class ShmPairLife : public testing::Test {
 protected:
  void SetUp() override {
    ShmOptions options;
    options.session = SessionId{1'000'000};
    options.place = place;
    options.heartbeat = std::chrono::milliseconds(50);
    options.peer_timeout = std::chrono::milliseconds(2000);
    options.limit_bytes = 0;  // What it publishes goes over the sockets.
    reader = MakeShmTransport(options, listener, kept.log);
    lies.emplace(*reader, "lies", TextType(), Demand{.credit_messages = 256, .credit_bytes = 1 << 20});
  }
  /// Subscribes to the channel `out`.
  static bool Subscribe(FalsePeer& peer, std::uint64_t bytes = 10'000) {
    return peer.Meet() && peer.Subscribe("out", TextType(), 4, bytes);
  }
  /// Calls `act` every few milliseconds until a peer that begins now, and then does nothing, was silent for too long. A
  /// peer that beats no more, and whose acts are no sign of life, goes no later than that one.
  void ActUntilAnotherIsTooSilent(const std::function<void()>& act) {
    FalsePeer silent(place);
    ASSERT_TRUE(silent.Meet());
    const auto is_peer = [&] {
      const auto peers = reader->Peers();
      return std::ranges::any_of(peers, [&](const PeerInfo& peer) { return peer.id == silent.id(); });
    };
    ASSERT_TRUE(Await(is_peer));
    ASSERT_TRUE(Await([&] {
      act();
      return !is_peer();
    }));
  }
  /// Prepares that the reading thread waits at the door.
  void HoldReader() {
    held.emplace(*reader, "gate", TextType(), Demand{}, [&](Sink& sink) { sink.on_accept = [&] { door.Pass(); }; });
    ShmOptions options;
    options.peers = {place};
    gatekeeper = MakeShmTransport(options, listener, kept.log);
    to_gate.emplace(*gatekeeper, "gate");
    ASSERT_TRUE(to_gate->Joined());
  }
  void CloseGate() {
    ASSERT_EQ(to_gate->Publish("x"), PublishStatus::kOk);
    ASSERT_TRUE(Await([&] { return held->sink.count() > 0; }));
  }
  static void Write(FalsePeer& peer, std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t sequence = first; sequence <= last; ++sequence) {
      Descriptor next = peer.NextMessage();
      next.sequence = sequence;
      peer.Write(next);
    }
  }

  const std::string place = "hgros-test-" + SessionId::Random().ToString();
  conformance::Listener listener;
  conformance::KeptLog kept;
  test::Door door;
  std::unique_ptr<ShmTransport> reader;
  std::optional<Reception> lies;
  std::optional<Reception> held;
  std::unique_ptr<ShmTransport> gatekeeper;
  std::optional<Publication> to_gate;
};

TEST_F(ShmPairLife, ASlowPayloadDoesNotCountAsSilence) {
  FalsePeer peer(place);
  ASSERT_TRUE(peer.Publish(4, 1 << 20));
  const std::string data(90'000, 'x');
  wire::PairMessage said;
  said.mutable_payload()->set_link(peer.wish.link());
  said.mutable_payload()->set_number(1);
  said.mutable_payload()->set_data(data);
  std::string frame(8, '\0');
  said.AppendToString(&frame);
  const auto length = static_cast<std::uint32_t>(frame.size() - 8);
  std::memcpy(frame.data(), &length, sizeof length);
  Descriptor next = peer.NextMessage();
  next.segment = kOnSocket;
  next.size_bytes = data.size();
  peer.Write(next);
  // From now on its heartbeat stands still; it sends only single bytes of the frame.
  std::size_t sent = 0;
  ActUntilAnotherIsTooSilent([&] { peer.SayRaw(frame.substr(sent++, 1)); });
  peer.SayRaw(frame.substr(sent));
  EXPECT_TRUE(Await([&] { return lies->sink.count() == 1; }));
  EXPECT_EQ(listener.gone, 1);
}

TEST_F(ShmPairLife, ASlowReaderOfALargeMessageDoesNotCountAsSilent) {
  constexpr std::size_t kSize = 64 << 20;
  const auto data = std::make_shared<const std::string>(kSize, 'x');  // Before there is a peer that waits for it.
  Publication out(*reader, "out");
  FalsePeer peer(place);
  ASSERT_TRUE(Subscribe(peer, kSize));
  ASSERT_EQ(out.channel->Reserve(), PublishStatus::kOk);
  out.channel->Commit(out.NextHead(), {AsBytes(*data), data});
  // From now on its heartbeat stands still; it only reads.
  std::string room(1 << 20, '\0');
  std::size_t received = 0;
  const auto receive = [&](std::size_t most) {
    received += static_cast<std::size_t>(
        std::max(recv(peer.socket().handle()->fd(), room.data(), most, MSG_DONTWAIT), ssize_t{0}));
  };
  ActUntilAnotherIsTooSilent([&] { receive(65'536); });  // The socket takes more when it is half empty.
  EXPECT_LT(received, kSize) << "it was to be slow";
  EXPECT_TRUE(Await([&] {
    receive(room.size());
    return received > kSize;
  }));
  EXPECT_EQ(listener.gone, 1);
}

/// Keeps the unconfirmed messages of subscribers that may still be alive.
struct KeepingSource final : conformance::Source {
  bool OnCut(SessionId, const Demand&, std::vector<OutboundMessage>&&) noexcept override {
    ++cuts;
    return true;
  }
  std::atomic<int> cuts{0};
};

TEST_F(ShmPairLife, SourceKeepsMessagesForALostPeerButNotForASilentOne) {
  KeepingSource keeping;
  const auto out = reader->Advertise("out", TextType(), keeping);
  FalsePeer silent(place);
  ASSERT_TRUE(Subscribe(silent));
  EXPECT_EQ(out->subscriber_count(), 1U);
  ASSERT_TRUE(Await([&] { return out->subscriber_count() == 0; })) << "its heartbeat stands still";
  EXPECT_EQ(keeping.cuts, 0);
  FalsePeer lost(place);
  ASSERT_TRUE(Subscribe(lost));
  lost.Hang();
  ASSERT_TRUE(Await([&] { return out->subscriber_count() == 0; }));
  EXPECT_EQ(keeping.cuts, 1);
}

TEST_F(ShmPairLife, ReadsPairsOfOneSessionInOrderOfTheirCreation) {
  HoldReader();
  FalsePeer first(place, SessionId{~std::uint64_t{0}});
  ASSERT_TRUE(first.Publish(256, 1 << 20));
  ASSERT_TRUE(Await([&] { return lies->channel->publisher_count() == 1; }));
  CloseGate();
  Write(first, 1, 100);
  FalsePeer second(place, first.id());
  second.incarnation = 2;
  ASSERT_TRUE(second.Publish(256, 1 << 20));
  ASSERT_TRUE(Await([&] { return lies->channel->publisher_count() == 2; }));
  Write(second, 101, 200);
  door.Open();
  ASSERT_TRUE(Await([&] { return lies->sink.count() == 200; })) << lies->sink.count() << " of 200 messages came";
  lies->channel.reset();
  for (std::size_t i = 0; i < 200; ++i) ASSERT_EQ(lies->sink.ids[i].sequence, i + 1);
}

TEST_F(ShmPairLife, ABusyPairDoesNotKeepOthersFromBeingRead) {
  HoldReader();
  lies->sink.answer = Accepted::kRunApart;
  FalsePeer quiet(place);
  ASSERT_TRUE(quiet.Publish(256, 1 << 20));
  FalsePeer busy(place);
  ASSERT_TRUE(busy.Publish(256, 1 << 20));
  ASSERT_TRUE(Await([&] { return lies->channel->publisher_count() == 2; }));
  CloseGate();
  Write(quiet, 1, 1);
  Write(busy, 1, 200);
  door.Open();
  ASSERT_TRUE(Await([&] { return lies->sink.count() == 201; }));
  lies->channel.reset();
  EXPECT_EQ(lies->sink.ids.back().publisher, busy.id().value);
}

}  // namespace
}  // namespace hgros::shm
