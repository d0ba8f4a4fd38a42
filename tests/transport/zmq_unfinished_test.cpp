// Publishers whose messages take long, or do not end.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

#include "hgros/base/memory_room.hpp"
#include "support/await.hpp"
#include "support/relay_port.hpp"
#include "support/seed.hpp"
#include "transport/agreement.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq_places.hpp"
#include "transport/zmq_spoiler.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::Reception;
using test::Frame;
using test::Place;
using test::PublishAt;
using test::SubscribeAt;

/// A port where a program speaks ZMTP as an XPUB socket does, but sends any bytes.
class Server {
 public:
  Server() = default;
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  ~Server() { close(connection_); }

  /// Waits for a subscriber, and greets it. False if none came.
  [[nodiscard]] bool Accept(int patience_ms = 10'000) {
    close(std::exchange(connection_, -1));
    pollfd ready{listening_.listener(), POLLIN, 0};
    if (poll(&ready, 1, patience_ms) != 1) return false;
    connection_ = accept4(listening_.listener(), nullptr, nullptr, SOCK_CLOEXEC);
    if (!Send(test::Greeting("XPUB"))) return false;
    std::array<char, 64> greeting{};
    return recv(connection_, greeting.data(), greeting.size(), MSG_WAITALL) == 64;
  }
  /// False if the connection was closed.
  [[nodiscard]] bool Send(std::string_view bytes) const {
    while (!bytes.empty()) {
      const auto sent = send(connection_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }

 private:
  const test::RelayPort listening_{0};
  int connection_ = -1;

 public:
  const std::string endpoint = "tcp://127.0.0.1:" + std::to_string(listening_.port());
};

/// Sends the frames of one message until the connection is closed. The frames that were sent.
std::uint64_t SendWithoutEnd(const Server& server, std::string_view body, std::uint64_t most) {
  constexpr int kAtOnce = 10'000;
  std::string frames;
  for (int i = 0; i < kAtOnce; ++i) frames += Frame(body, true);
  std::uint64_t sent = 0;
  while (sent < most && server.Send(frames)) sent += kAtOnce;
  return sent;
}

TEST(ZmqUnfinishedMessage, AConnectionWithEmptyFramesWithoutEndIsClosed) {
  Server server;
  Place subscriber{SubscribeAt(server.endpoint)};
  const Reception in(*subscriber.transport, "scan");
  ASSERT_TRUE(server.Accept());
  const std::uint64_t before = ResidentBytes();
  constexpr std::uint64_t kMost = 100'000'000;  // They would take 6.4 GB.
  const std::uint64_t sent = SendWithoutEnd(server, "", kMost);
  EXPECT_LT(sent, kMost);
  EXPECT_TRUE(Eventually([&] { return subscriber.Said("it consists of very many frames, and does not end"); }));
  EXPECT_EQ(subscriber.Overruns(), 1U);
  const std::uint64_t after = ResidentBytes();
  EXPECT_LT(after, before + (1500ULL << 20)) << sent;
  EXPECT_FALSE(server.Accept(500)) << "it is not tried again at once";
  EXPECT_TRUE(server.Accept());
}

TEST(ZmqUnfinishedMessage, AConnectionWithAMessageThatIsTooLongIsClosed) {
  Server server;
  ZmqOptions options = SubscribeAt(server.endpoint);
  options.max_message_bytes = 8ULL << 20;
  Place subscriber{options};
  const Reception in(*subscriber.transport, "scan");
  ASSERT_TRUE(server.Accept());
  constexpr std::uint64_t kMost = 1'000'000;
  EXPECT_LT(SendWithoutEnd(server, std::string(200, 'x'), kMost), kMost);
  EXPECT_TRUE(Eventually([&] { return subscriber.Said("the message is longer than 8 MiB"); }));
  EXPECT_EQ(subscriber.Overruns(), 1U);
}

// A plain publisher may send what it likes, and more than this session can use.
TEST(ZmqUnfinishedMessage, AConnectionWithManyWholeMessagesStays) {
  Server server;
  Place subscriber{SubscribeAt(server.endpoint)};
  const Reception in(*subscriber.transport, "scan");
  ASSERT_TRUE(server.Accept());
  std::string messages;
  for (int i = 0; i < 10'000; ++i) messages += Frame("other", true) + Frame("");
  for (int i = 0; i < test::Rounds(50, 200); ++i) ASSERT_TRUE(server.Send(messages));
  for (int i = 0; i < test::Rounds(5, 20); ++i)
    ASSERT_TRUE(server.Send(Frame("other", true) + Frame(std::string(4 << 20, 'x'))));
  test::Linger(std::chrono::milliseconds(200));
  EXPECT_TRUE(server.Send(messages));
  EXPECT_EQ(subscriber.Overruns(), 0U);
}

TEST(ZmqUnreadAnswers, EndTheConnectionToAPublisher) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "A million messages take too long with a sanitizer.";
#endif
  Server server;
  Place subscriber{SubscribeAt(server.endpoint, SessionId{7})};
  ASSERT_TRUE(server.Accept());
  auto welcome = zmq::ControlFrom(SessionId{9});
  WriteFacts(OwnFacts(SessionId{9}, "greedy"), *welcome.mutable_welcome()->mutable_facts());
  welcome.mutable_welcome()->set_handshake(1);
  const std::string topic = Frame(zmq::ControlTopic(SessionId{7}), true);
  ASSERT_TRUE(server.Send(topic + Frame(welcome.SerializeAsString())));
  ASSERT_TRUE(Eventually([&] { return subscriber.listener.came == 1; }));
  auto heartbeat = zmq::ControlFrom(SessionId{9});
  heartbeat.mutable_heartbeat()->set_asked_ns(1);
  std::string messages;
  for (int i = 0; i < 1000; ++i) messages += topic + Frame(heartbeat.SerializeAsString());
  for (int i = 0; i < 10'000 && server.Send(messages); ++i) {
  }
  EXPECT_TRUE(Eventually([&] { return subscriber.Said("it does not read the answers to its messages"); }));
  EXPECT_TRUE(Eventually([&] { return subscriber.listener.gone == 1; }));
  EXPECT_FALSE(server.Accept(500)) << "it is not tried again at once";
}

TEST(ZmqUnfinishedMessage, ItsProgressIsASignOfLife) {
  const Place publisher{PublishAt()};
  test::Spoiler slow(publisher.Bound(), test::Spoiler::Side::kServer, test::Spoiler::Then::kGoesOn,
                     [](std::span<char> bytes) {
                       test::Linger(std::chrono::microseconds(bytes.size()));  // It spoils nothing.
                       return false;
                     });
  slow.Spoil();
  conformance::Publication out(*publisher.transport, "scan");
  Place subscriber{SubscribeAt(slow.endpoint()), std::chrono::seconds(2)};
  const Reception in(*subscriber.transport, "scan");
  ASSERT_TRUE(out.Joined());
  // It takes longer than the patience with a silent peer: 2 s.
  ASSERT_EQ(out.Publish(std::string(3'000'000, 'x')), PublishStatus::kOk);
  EXPECT_TRUE(test::Await([&] { return in.sink.count() == 1; }, std::chrono::seconds(60)));
  EXPECT_EQ(subscriber.listener.gone, 0);
  EXPECT_EQ(subscriber.Overruns(), 0U);
}

}  // namespace
}  // namespace hgros
