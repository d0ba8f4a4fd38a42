// Programs that use the id of another program's session at a publish endpoint.
#include <gtest/gtest.h>

#include "transport/agreement.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq_places.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::TextType;

constexpr SessionId kVictim{7};
constexpr std::uint64_t kProof = 1234;

/// A connection that speaks for the session, but answers nothing by itself.
class Speaker {
 public:
  explicit Speaker(const std::string& endpoint) {
    socket_.Connect(endpoint);
    Send('\1' + zmq::ControlTopic(kVictim));
    Send('\1' + PeerTopic("scan", kVictim));
  }
  void Send(const std::string& frame) const { socket_.Send({frame}); }
  /// The next such control message; empty at the deadline.
  [[nodiscard]] wire::Control ControlThat(bool (wire::Control::*has)() const) const {
    for (;;) {
      const auto frames = socket_.Receive();
      if (frames.empty()) return {};
      if (frames.size() != 2) continue;
      const auto control = zmq::ParseControl(AsBytes(frames[1]));
      if (control && ((*control).*has)()) return *control;
    }
  }
  /// The handshake of the next Welcome.
  [[nodiscard]] std::uint64_t Welcome() const { return ControlThat(&wire::Control::has_welcome).welcome().handshake(); }
  [[nodiscard]] wire::Subscribed Subscribed() const { return ControlThat(&wire::Control::has_subscribed).subscribed(); }
  void SayHello(std::uint64_t handshake, std::uint64_t proof) const {
    auto message = zmq::ControlFrom(kVictim);
    WriteFacts(OwnFacts(kVictim, "speaker"), *message.mutable_hello()->mutable_facts());
    message.mutable_hello()->mutable_facts()->set_incarnation(1);
    message.mutable_hello()->set_handshake(handshake);
    message.mutable_hello()->set_proof(proof);
    Send(zmq::UpstreamFrame(message));
  }
  void Ask(std::uint64_t handshake, std::uint64_t link = 0, std::uint64_t received = 0) const {
    auto message = zmq::ControlFrom(kVictim);
    auto& asked = *message.mutable_subscribe();
    WriteType("scan", TextType(), *asked.mutable_wanted());
    asked.set_handshake(handshake);
    asked.set_lossless(true);
    asked.set_credit_messages(100);
    asked.set_credit_bytes(1 << 20);
    asked.set_link(link);
    asked.set_received_messages(received);
    asked.set_received_bytes(received * bytes_);
    Send(zmq::UpstreamFrame(message));
  }
  /// The number of the next packet on the link, and its data; empty if there is none for 10 s.
  [[nodiscard]] std::string Packet() {
    for (;;) {
      const auto frames = socket_.Receive();
      if (frames.empty()) return {};
      const auto topic = zmq::ParseDataTopic(AsBytes(frames[0]));
      if (frames.size() != 3 || !topic) continue;
      bytes_ = frames[1].size() + frames[2].size();
      return std::to_string(topic->number) + " " + frames[2];
    }
  }

 private:
  test::RawSocket socket_{ZMQ_XSUB};
  std::uint64_t bytes_ = 0;  // Of a packet.
};

class ZmqForgedSession : public testing::Test {
 protected:
  void Publish(const std::string& text) { ASSERT_EQ(out_.Publish(text), PublishStatus::kOk); }
  /// The session joins. Its link.
  [[nodiscard]] std::uint64_t Join(const Speaker& session) const {
    const std::uint64_t handshake = session.Welcome();
    session.SayHello(handshake, kProof);
    session.Ask(handshake);
    return session.Subscribed().link();
  }

  test::Place publisher{test::PublishAt()};
  const std::string endpoint = publisher.Bound();

 private:
  conformance::Publication out_{*publisher.transport, "scan"};
};

TEST_F(ZmqForgedSession, DoesNotPauseTheLinksOfTheSession) {
  Speaker session(endpoint);
  ASSERT_NE(Join(session), 0U);
  const Speaker stranger(endpoint);
  const std::uint64_t handshake = session.Welcome();
  ASSERT_NE(handshake, 0U);
  Publish("1");
  EXPECT_EQ(session.Packet(), "1 1");
  stranger.SayHello(stranger.Welcome(), kProof + 1);
  ASSERT_TRUE(Eventually([&] { return publisher.Said("a Hello in the name of speaker:"); }));
  test::Linger(std::chrono::milliseconds(300));  // It may get a Welcome again.
  stranger.SayHello(0, 0);
  ASSERT_NE(session.Welcome(), 0U);
  Publish("2");
  EXPECT_EQ(session.Packet(), "2 2");
}

TEST_F(ZmqForgedSession, DoesNotMakeTheSessionsAnswersGetMessagesTwice) {
  Speaker session(endpoint);
  const std::uint64_t link = Join(session);
  Publish("1");
  EXPECT_EQ(session.Packet(), "1 1");
  const Speaker stranger(endpoint);
  const std::uint64_t handshake = session.Welcome();
  Publish("2");
  session.SayHello(handshake, kProof);
  session.Ask(handshake, link, 1);
  Publish("3");
  EXPECT_EQ(session.Packet(), "2 2");
  EXPECT_EQ(session.Packet(), "3 3");
  Publish("4");
  EXPECT_EQ(session.Packet(), "4 4");
}

TEST_F(ZmqForgedSession, DoesNotEndALinkThatTheSessionHasNotReadAbout) {
  Speaker session(endpoint);
  const std::uint64_t link = Join(session);
  Publish("1");
  const Speaker stranger(endpoint);
  std::uint64_t handshake = session.Welcome();
  session.SayHello(handshake, kProof);
  session.Ask(handshake);
  handshake = session.Welcome();
  ASSERT_NE(handshake, 0U) << "the links are paused, so that it reads what is on its way";
  session.SayHello(handshake, kProof);
  session.Ask(handshake, link);
  EXPECT_EQ(session.Subscribed().link(), link);
  EXPECT_EQ(session.Packet(), "1 1");
}

// The publisher has not noticed that its first connection ended.
TEST_F(ZmqForgedSession, IsNotASessionWithANewConnectionAndItsProof) {
  Speaker session(endpoint);
  const std::uint64_t link = Join(session);
  Publish("1");
  EXPECT_EQ(session.Packet(), "1 1");
  Speaker again(endpoint);
  std::uint64_t handshake = again.Welcome();
  Publish("2");  // Sent to the first connection as well.
  again.SayHello(handshake, kProof);
  again.Ask(handshake, link, 1);
  handshake = again.Welcome();
  ASSERT_NE(handshake, 0U);
  Publish("3");
  again.SayHello(handshake, kProof);
  again.Ask(handshake, link, 1);
  EXPECT_EQ(again.Packet(), "2 2");
  EXPECT_EQ(again.Packet(), "3 3");
}

}  // namespace
}  // namespace hgros
