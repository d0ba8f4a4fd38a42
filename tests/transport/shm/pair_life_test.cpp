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
  static bool Subscribe(FalsePeer& peer, const std::string& channel, std::uint64_t bytes = 10'000) {
    return peer.Meet() && peer.Subscribe(channel, TextType(), 4, bytes);
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

/// Keeps the unconfirmed messages of subscribers that may still be alive.
struct KeepingSource final : conformance::Source {
  bool OnCut(SessionId, const Demand&, std::vector<OutboundMessage>&&) noexcept override {
    ++cuts;
    return true;
  }
  std::atomic<int> cuts{0};
};

TEST_F(ShmPairLife, ASlowPayloadOrReaderOfALargeMessageIsNotSilentAndASourceKeepsNothingForOneThatIs) {
  constexpr std::size_t kSize = 64 << 20;
  const auto large = std::make_shared<const std::string>(kSize, 'x');  // Before there is a peer that waits for it.
  Publication out(*reader, "out");
  KeepingSource keeping;
  const auto kept_out = reader->Advertise("kept", TextType(), keeping);
  FalsePeer writing(place), reading(place), silent(place);

  ASSERT_TRUE(writing.Publish(4, 1 << 20));
  const std::string data(90'000, 'x');
  wire::PairMessage said;
  said.mutable_payload()->set_link(writing.wish.link());
  said.mutable_payload()->set_number(1);
  said.mutable_payload()->set_data(data);
  std::string frame(8, '\0');
  said.AppendToString(&frame);
  const auto length = static_cast<std::uint32_t>(frame.size() - 8);
  std::memcpy(frame.data(), &length, sizeof length);
  Descriptor next = writing.NextMessage();
  next.segment = kOnSocket;
  next.size_bytes = data.size();
  writing.Write(next);
  ASSERT_TRUE(Subscribe(reading, "out", kSize));
  ASSERT_EQ(out.channel->Reserve(), PublishStatus::kOk);
  out.channel->Commit(out.NextHead(), {AsBytes(*large), large});
  ASSERT_TRUE(Subscribe(silent, "kept"));
  EXPECT_EQ(kept_out->subscriber_count(), 1U);
  // From now on their heartbeats stand still. One sends only single bytes of the frame, another only reads.
  std::size_t sent = 0;
  std::size_t received = 0;
  std::string room(1 << 20, '\0');
  const auto receive = [&](std::size_t most) {
    const ssize_t got = recv(reading.socket().handle()->fd(), room.data(), most, MSG_DONTWAIT);
    received += static_cast<std::size_t>(std::max(got, ssize_t{0}));
    return got > 0;
  };
  ASSERT_TRUE(Await([&] {
    writing.SayRaw(frame.substr(sent++, 1));
    receive(8192);  // The socket takes more when it is half empty.
    return kept_out->subscriber_count() == 0;
  }));
  EXPECT_EQ(keeping.cuts, 0);
  EXPECT_LT(received, kSize) << "it was to be slow";
  writing.SayRaw(frame.substr(sent));
  EXPECT_TRUE(Await([&] { return lies->sink.count() == 1; }));
  EXPECT_TRUE(Await([&] {
    while (receive(room.size())) {
    }
    return received > kSize;
  }));
  EXPECT_EQ(listener.gone, 1);
  FalsePeer lost(place);
  ASSERT_TRUE(Subscribe(lost, "kept"));
  lost.Hang();
  ASSERT_TRUE(Await([&] { return kept_out->subscriber_count() == 0; }));
  EXPECT_EQ(keeping.cuts, 1) << "it may still be alive";
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
