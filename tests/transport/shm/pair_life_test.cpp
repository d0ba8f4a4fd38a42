// The end of a pair, and the order in which pairs are read.
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "conformance/transport_conformance.hpp"
#include "hgros/transport/shm_transport.hpp"
#include "support/await.hpp"
#include "transport/shm/false_peer.hpp"

namespace hgros::shm {
namespace {

using conformance::TextType;
using test::Await;

constexpr auto kTimeout = std::chrono::milliseconds(2000);

/// Notes the order of messages. If there is a door, the first message waits at it.
class OrderSink : public InboundSink {
 public:
  struct Came {
    SessionId from;
    std::uint64_t sequence;
  };
  Accepted Accept(InboundMessage&& message) noexcept override {
    {
      const std::scoped_lock lock(mutex_);
      came_.push_back({message.from, message.head.id.sequence});
    }
    if (door != nullptr) door->Pass();
    return answer;
  }
  void Run() noexcept override {}
  void OnFault(PacketFault, std::string_view) noexcept override {}
  void OnPublishers(std::size_t) noexcept override {}
  [[nodiscard]] std::vector<Came> came() const {
    const std::scoped_lock lock(mutex_);
    return came_;
  }

  test::Door* door = nullptr;
  Accepted answer = Accepted::kNothing;

 private:
  mutable std::mutex mutex_;
  std::vector<Came> came_;  // Guarded by mutex_.
};

class ShmPairLife : public testing::Test {
 protected:
  void SetUp() override {
    ShmOptions options;
    options.session = SessionId{1'000'000};
    options.place = place;
    options.heartbeat = std::chrono::milliseconds(50);
    options.peer_timeout = kTimeout;
    options.limit_bytes = 0;  // What it publishes goes over the sockets.
    reader = MakeShmTransport(options, listener, log);
    lies = reader->Subscribe("lies", TextType(), {.credit_messages = 256, .credit_bytes = 1 << 20}, sink);
  }
  /// Subscribes to the channel `out`.
  static bool Subscribe(FalsePeer& peer, std::uint64_t bytes = 10'000) {
    wire::PairMessage said;
    auto& wish = *said.mutable_wish();
    WriteType("out", TextType(), *wish.mutable_wanted());
    wish.set_link(1);
    wish.set_cell(1);
    wish.set_lossless(true);
    wish.set_credit_messages(4);
    wish.set_credit_bytes(bytes);
    const bool met = peer.Meet();
    peer.Say(said);
    return met && peer.ReadUntil(wire::PairMessage::kGranted);
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
  /// From now on the reading thread waits at the door.
  void HoldReader() {
    gate.door = &door;
    held = reader->Subscribe("gate", TextType(), {}, gate);
    ShmOptions options;
    options.peers = {place};
    gatekeeper = MakeShmTransport(options, listener, log);
    to_gate = gatekeeper->Advertise("gate", TextType(), source);
    ASSERT_TRUE(Await([&] { return to_gate->subscriber_count() == 1; }));
  }
  void CloseGate() {
    PacketHead head;
    head.id = {0, 1, 1};
    to_gate->Commit(head, {});
    ASSERT_TRUE(Await([&] { return !gate.came().empty(); }));
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
  conformance::Source source;
  Log log{[](LogLevel, std::string_view) {}};
  test::Door door;
  OrderSink gate;
  OrderSink sink;
  std::unique_ptr<ShmTransport> reader;
  std::unique_ptr<InboundChannel> lies;
  std::unique_ptr<InboundChannel> held;
  std::unique_ptr<ShmTransport> gatekeeper;
  std::unique_ptr<OutboundChannel> to_gate;
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
  EXPECT_TRUE(Await([&] { return sink.came().size() == 1; }));
  EXPECT_EQ(listener.gone, 1);
}

TEST_F(ShmPairLife, ASlowReaderOfALargeMessageDoesNotCountAsSilent) {
  constexpr std::size_t kSize = 64 << 20;
  const auto data = std::make_shared<const std::string>(kSize, 'x');  // Before there is a peer that waits for it.
  const auto out = reader->Advertise("out", TextType(), source);
  FalsePeer peer(place);
  ASSERT_TRUE(Subscribe(peer, kSize));
  ASSERT_EQ(out->Reserve(), PublishStatus::kOk);
  PacketHead head;
  head.id = {0, 1, 1};
  out->Commit(head, {AsBytes(*data), data});
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
  ASSERT_TRUE(Await([&] { return lies->publisher_count() == 1; }));
  CloseGate();
  Write(first, 1, 100);
  FalsePeer second(place, first.id());
  second.incarnation = 2;
  ASSERT_TRUE(second.Publish(256, 1 << 20));
  ASSERT_TRUE(Await([&] { return lies->publisher_count() == 2; }));
  Write(second, 101, 200);
  door.Open();
  ASSERT_TRUE(Await([&] { return sink.came().size() == 200; })) << sink.came().size() << " of 200 messages came";
  const auto came = sink.came();
  for (std::size_t i = 0; i < came.size(); ++i) ASSERT_EQ(came[i].sequence, i + 1);
}

TEST_F(ShmPairLife, ABusyPairDoesNotKeepOthersFromBeingRead) {
  HoldReader();
  sink.answer = Accepted::kRunApart;
  FalsePeer quiet(place);
  ASSERT_TRUE(quiet.Publish(256, 1 << 20));
  FalsePeer busy(place);
  ASSERT_TRUE(busy.Publish(256, 1 << 20));
  ASSERT_TRUE(Await([&] { return lies->publisher_count() == 2; }));
  CloseGate();
  Write(quiet, 1, 1);
  Write(busy, 1, 200);
  door.Open();
  ASSERT_TRUE(Await([&] { return sink.came().size() == 201; }));
  EXPECT_EQ(sink.came().back().from, busy.id());
}

}  // namespace
}  // namespace hgros::shm
