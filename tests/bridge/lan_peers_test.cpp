#include "bridge/lan_peers.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <map>

#include "support/await.hpp"
#include "support/few_descriptors.hpp"

namespace hgros {
namespace {

/// Keeps the endpoints that it is told to subscribe to, and connects to none.
class Endpoints final : public ZmqTransport {
 public:
  void AddSubscribeEndpoint(const SubscribeEndpoint& endpoint) override {
    EXPECT_TRUE(events.emplace(endpoint.endpoint, endpoint.on_event).second);
  }
  bool RemoveSubscribeEndpoint(const std::string& endpoint) override { return events.erase(endpoint) > 0; }
  OrderWay SendOrder(SessionId /*publisher*/, std::string_view /*request*/) override { return OrderWay::kNone; }
  void Report(const std::string& endpoint, EndpointEvent event, SessionId session = {}) const {
    events.at(endpoint)(event, session);
  }

  std::unique_ptr<OutboundChannel> Advertise(std::string_view, const TypeInfo&, OutboundSource&) override { return {}; }
  std::unique_ptr<InboundChannel> Subscribe(std::string_view, const TypeInfo&, const Demand&, InboundSink&) override {
    return {};
  }
  std::vector<PeerInfo> Peers() const override { return {}; }
  TransportStats stats() const override { return {}; }
  void Close(int, int) noexcept override {}
  void SetPublishChannels(const std::string&, ChannelList) override {}
  void SetSubscribeChannels(const std::string&, ChannelList) override {}
  void AddPublishEndpoint(const PublishEndpoint&) override {}
  bool RemovePublishEndpoint(const std::string&) override { return false; }
  std::vector<std::string> BoundEndpoints() const override { return {}; }
  std::uint64_t refused_handshakes() const override { return 0; }

  std::map<std::string, std::function<void(EndpointEvent, SessionId)>> events;
};

class LanPeersTest : public testing::Test {
 protected:
  static constexpr auto kPatience = std::chrono::milliseconds(100);

  void Hear(std::uint64_t session, const std::string& sender, std::vector<std::string> endpoints) {
    Announcement peer;
    peer.session = {session};
    peer.sender = sender;
    peer.endpoints = std::move(endpoints);
    peers.OnCame(peer);
  }
  /// That many sessions at one address, all of which answer.
  void HearThatAnswer(std::uint64_t first, std::uint64_t count, const std::string& address) {
    for (std::uint64_t i = first; i < first + count; ++i) {
      const std::string endpoint = "tcp://" + address + ":" + std::to_string(i);
      Hear(i, address, {endpoint});
      if (Has(endpoint)) zmq.Report(endpoint, EndpointEvent::kReached);
    }
  }
  [[nodiscard]] std::ptrdiff_t CountAt(const std::string& address) const {
    return std::ranges::count_if(zmq.events,
                                 [&](const auto& entry) { return entry.first.starts_with("tcp://" + address + ":"); });
  }
  void Lose(std::uint64_t session) {
    Announcement peer;
    peer.session = {session};
    peers.OnGone(peer, "It was not heard.");
  }
  /// Runs the errands that are due, until the condition holds.
  [[nodiscard]] bool RunUntil(const std::function<bool()>& condition,
                              std::chrono::nanoseconds patience = test::kPatience) {
    const auto run = [&] {
      while (!errands.empty() && errands.begin()->first <= std::chrono::steady_clock::now()) {
        errands.extract(errands.begin()).mapped()();
      }
      return condition();
    };
    return test::Await(run, patience);
  }
  [[nodiscard]] bool Has(const std::string& endpoint) const { return zmq.events.contains(endpoint); }

  const test::FewDescriptors few{1024};  // For 256 endpoints.
  Endpoints zmq;
  std::vector<std::string> lines;
  Log log{[this](LogLevel, std::string_view text) { lines.emplace_back(text); }};
  std::multimap<std::chrono::steady_clock::time_point, std::function<void()>> errands;
  LanPeers peers{zmq,
                 log,
                 kPatience,
                 [this](std::chrono::nanoseconds delay, std::function<void()> errand) {
                   errands.emplace(std::chrono::steady_clock::now() + delay, std::move(errand));
                 },
                 {"tcp://10.0.0.9:1"}};
};

TEST_F(LanPeersTest, ConnectToAllThatAnswerWithoutAnErrand) {
  for (std::uint64_t i = 1; i <= 20; ++i) Hear(i, "10.0.0.1", {"tcp://10.0.0.1:" + std::to_string(i)});
  for (std::size_t answered = 0; answered < 20; answered += LanPeers::kMaxTries) {
    ASSERT_EQ(zmq.events.size(), answered + LanPeers::kMaxTries);
    for (const auto& [endpoint, report] : std::map(zmq.events)) report(EndpointEvent::kReached, {});
  }
  EXPECT_EQ(zmq.events.size(), 20U);
  EXPECT_TRUE(lines.empty());
}

TEST_F(LanPeersTest, ConnectToASessionAtOneOfItsAddresses) {
  // Session 1 is looked for at two addresses. At one of those of session 2, a stranger's session answers.
  for (const std::uint64_t session : {1U, 2U}) {
    const std::string host = "10.0." + std::to_string(session);
    Announcement peer;
    peer.session = {session};
    peer.sender = host + ".1";
    for (const char* last : {".1", ".2", ".3"}) {
      peer.endpoints.push_back("tcp://" + host + last + ":1");
      peer.senders.push_back(host + last);
    }
    peers.OnCame(peer);
    ASSERT_TRUE(RunUntil([&] { return Has(peer.endpoints[0]) && Has(peer.endpoints[1]); }));
    zmq.Report(peer.endpoints[0], EndpointEvent::kReached, {1});
    zmq.Report(peer.endpoints[1], EndpointEvent::kReached, {9});
    const std::chrono::nanoseconds patience = session == 2 ? test::kPatience : 3 * kPatience;
    EXPECT_EQ(RunUntil([&] { return Has(peer.endpoints[2]); }, patience), session == 2);
  }
}

TEST_F(LanPeersTest, KeepAnEndpointWhileItsSessionAnswers) {
  Hear(1, "10.0.0.1", {"tcp://10.0.0.1:1"});
  zmq.Report("tcp://10.0.0.1:1", EndpointEvent::kReached);
  Lose(1);
  ASSERT_FALSE(RunUntil([&] { return !Has("tcp://10.0.0.1:1"); }, 3 * kPatience));
  zmq.Report("tcp://10.0.0.1:1", EndpointEvent::kLost);
  zmq.Report("tcp://10.0.0.1:1", EndpointEvent::kReached);
  Hear(2, "10.0.0.1", {"tcp://10.0.0.1:2"});
  EXPECT_FALSE(RunUntil([&] { return !Has("tcp://10.0.0.1:1"); }, 3 * kPatience)) << "it has come back";
  zmq.Report("tcp://10.0.0.1:1", EndpointEvent::kLost);
  EXPECT_TRUE(RunUntil([&] { return !Has("tcp://10.0.0.1:1"); }));
  EXPECT_TRUE(Has("tcp://10.0.0.1:2"));
}

TEST_F(LanPeersTest, TryEachSenderInTurn) {
  for (std::uint64_t i = 1; i <= 100; ++i) Hear(i, "10.0.0.1", {"tcp://10.0.0.1:" + std::to_string(i)});
  EXPECT_EQ(zmq.events.size(), LanPeers::kMaxTries);
  Hear(101, "10.0.0.2", {"tcp://10.0.0.7:1", "tcp://10.0.0.2:1"});
  for (const auto& [endpoint, report] : std::map(zmq.events)) report(EndpointEvent::kFailed, {});
  EXPECT_TRUE(RunUntil([&] { return Has("tcp://10.0.0.2:1"); }));
  EXPECT_FALSE(Has("tcp://10.0.0.7:1")) << "the sender's own address comes first";
  EXPECT_EQ(zmq.events.size(), LanPeers::kMaxTries);
  zmq.Report("tcp://10.0.0.2:1", EndpointEvent::kReached);
  EXPECT_EQ(zmq.events.size(), LanPeers::kMaxTries + 1U) << "it no longer counts as a try";
  EXPECT_EQ(lines.size(), 1U) << "that no session answers";
}

TEST_F(LanPeersTest, ASilentEndpointGivesWayAfterAWhile) {
  for (std::uint64_t i = 1; i <= LanPeers::kMaxTries; ++i) Hear(i, "10.0.0.1", {"tcp://10.0.0.1:" + std::to_string(i)});
  Hear(9, "10.0.0.1", {"tcp://10.0.0.1:9"});
  EXPECT_FALSE(Has("tcp://10.0.0.1:9"));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(RunUntil([&] { return Has("tcp://10.0.0.1:9"); }));
  EXPECT_GE(std::chrono::steady_clock::now() - start, LanPeers::kTryTime - std::chrono::milliseconds(100));
  EXPECT_EQ(zmq.events.size(), LanPeers::kMaxTries);
  Lose(9);
  EXPECT_TRUE(RunUntil([&] { return !Has("tcp://10.0.0.1:9"); })) << "it was never reached";
}

TEST_F(LanPeersTest, OneAddressGetsAQuarterOfWhatOthersLeave) {
  HearThatAnswer(1, 100, "10.0.0.1");
  EXPECT_EQ(CountAt("10.0.0.1"), 64);
  Hear(101, "10.0.0.2", {"tcp://10.0.0.1:101"});
  EXPECT_EQ(CountAt("10.0.0.1"), 64) << "the sender's address may be forged";
  EXPECT_EQ(lines.size(), 1U) << "that there are too many sessions at one address";
  HearThatAnswer(201, 100, "10.0.0.2");
  EXPECT_EQ(CountAt("10.0.0.2"), (256 - 64) / 4);
  HearThatAnswer(301, 10, "10.0.0.3");
  EXPECT_EQ(CountAt("10.0.0.3"), 10);
  EXPECT_EQ(lines.size(), 1U);
}

TEST_F(LanPeersTest, AnAddressWithItsShareGetsAnotherSessionWhenOneIsGone) {
  HearThatAnswer(1, 70, "10.0.0.1");
  ASSERT_FALSE(Has("tcp://10.0.0.1:70"));
  for (std::uint64_t i = 1; i <= 6; ++i) zmq.Report("tcp://10.0.0.1:" + std::to_string(i), EndpointEvent::kLost);
  for (std::uint64_t i = 1; i <= 6; ++i) Lose(i);
  EXPECT_TRUE(RunUntil([&] {
    for (std::uint64_t i = 65; i <= 70; ++i) {
      const std::string endpoint = "tcp://10.0.0.1:" + std::to_string(i);
      if (!Has(endpoint)) return false;
      zmq.Report(endpoint, EndpointEvent::kReached);
    }
    return true;
  }));
  EXPECT_EQ(CountAt("10.0.0.1"), 64);
}

TEST_F(LanPeersTest, LeaveConfiguredEndpointsAlone) {
  Hear(1, "10.0.0.9", {"tcp://10.0.0.9:1", "tcp://10.0.0.9:2"});
  EXPECT_FALSE(Has("tcp://10.0.0.9:1"));
  peers.Configure("tcp://10.0.0.9:2");
  EXPECT_FALSE(Has("tcp://10.0.0.9:2"));
  peers.Release("tcp://10.0.0.9:1");
  EXPECT_TRUE(RunUntil([&] { return Has("tcp://10.0.0.9:1"); }));
  EXPECT_FALSE(Has("tcp://10.0.0.9:2"));
}

}  // namespace
}  // namespace hgros
