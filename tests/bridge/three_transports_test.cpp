// Two bridges that can use three transports. Two of these exist only in this test.
#include <map>
#include <optional>
#include <thread>

#include "bridge/joined/joined_inbound.hpp"
#include "bridge/joined/joined_outbound.hpp"
#include "conformance/transport_conformance.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "hgros/clock/errand_thread.hpp"
#include "session/session_fixture.hpp"
#include "support/at_once.hpp"
#include "support/gated_transport.hpp"

namespace hgros::test::three_transports_test {
namespace {

struct Gates {
  explicit Gates(bool open) : loop(open), pipe(open) {}
  Gate loop;
  Gate pipe;
};

/// A session that has only a bridge.
class Bridged {
 public:
  Bridged(ZmqOptions zmq, Gates& gates, const std::string& domain,
          std::map<std::string, TransportKeys, std::less<>> rules) {
    BridgeOptions options;
    options.zmq = std::move(zmq);
    options.zmq.session = id_;
    options.zmq.process = "bridged";
    options.zmq.heartbeat = std::chrono::milliseconds(100);
    options.zmq.peer_timeout = std::chrono::milliseconds(2000);
    options.more_transports = {GatedEntry("pipe", "a pipe", 20, options.zmq.session, gates.pipe),
                               GatedEntry("loop", "a loop", 10, options.zmq.session, gates.loop)};
    options.registry.emplace().domain = domain;
    options.rules = std::move(rules);
    options.on_announcements = [] {};
    options.later = [this](std::chrono::nanoseconds delay, std::function<void()> errand) {
      errands_.PostIn(delay, std::move(errand));
    };
    bridge_.reset(new NetworkBridge(std::move(options), listener_, log_));
  }
  ~Bridged() {
    bridge_->Close(0);
    errands_.End();
    bridge_.reset();
  }
  [[nodiscard]] SessionId id() const { return id_; }
  NetworkBridge* operator->() { return bridge_.get(); }
  [[nodiscard]] std::string UsedTransport() const {
    const auto peers = bridge_->Peers();
    return peers.size() == 1 ? peers[0].transport : std::to_string(peers.size()) + " peers";
  }
  // The warnings about sessions that are not reached.
  [[nodiscard]] std::vector<std::string> Unreached() const {
    const std::scoped_lock lock(mutex_);
    return unreached_;
  }

 private:
  const SessionId id_ = SessionId::Random();
  mutable std::mutex mutex_;
  std::vector<std::string> unreached_;  // Under mutex_.
  Log log_{[this](LogLevel level, std::string_view line) {
    const std::scoped_lock lock(mutex_);
    if (level == LogLevel::kWarning && line.find("does not reach it") != line.npos) unreached_.emplace_back(line);
  }};
  conformance::Listener listener_;
  ErrandThread errands_;
  std::unique_ptr<NetworkBridge> bridge_;
};

/// Publishes numbers without pause.
class Counting {
 public:
  Counting(Bridged& session, const std::string& channel) : out_(session->Advertise(channel, TypeOf<Note>(), source_)) {
    head_.channel = channel;
    head_.type_name = TypeOf<Note>().name;
    head_.encoding = TypeOf<Note>().encoding;
    head_.fingerprint = TypeOf<Note>().fingerprint;
    head_.id = {session.id().value, 1, 0};
    data_ = TypeOf<Note>().encode(std::make_shared<const Note>("x"));
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        if (out_->subscriber_count() > 0 && out_->Reserve() == PublishStatus::kOk) {
          head_.id.sequence = ++published;
          out_->Commit(head_, data_);
        }
        Linger(std::chrono::microseconds(500));
      }
    });
  }
  void Stop() {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
  }
  [[nodiscard]] std::size_t subscribers() const { return out_->subscriber_count(); }
  std::atomic<std::uint64_t> published{0};

 private:
  conformance::Source source_;
  PacketHead head_;
  Payload data_;
  std::shared_ptr<JoinedOutbound> out_;
  std::jthread thread_;
};

/// Checks the numbers that arrive.
class Checking final : private InboundSink {
 public:
  Checking(Bridged& session, const std::string& channel)
      : in_(session->Subscribe(channel, TypeOf<Note>(), TypeOf<Note>(), {.lossless = true, .credit_messages = 32},
                               *this)) {}
  std::atomic<std::uint64_t> last{0};
  std::atomic<std::uint64_t> lost{0};
  std::atomic<std::uint64_t> repeated{0};

 private:
  Accepted Accept(InboundMessage&& message) noexcept override {
    const std::uint64_t sequence = message.head.id.sequence;
    if (sequence <= last) {
      ++repeated;  // Dropped, as a session does.
    } else {
      lost += sequence - last - 1;
      last = sequence;
    }
    return Accepted::kNothing;
  }
  void Run() noexcept override {}
  void OnFault(PacketFault /*fault*/, std::string_view what) noexcept override { ADD_FAILURE() << what; }
  void OnPublishers(std::size_t /*count*/) noexcept override {}

  std::shared_ptr<JoinedInbound> in_;
};

/// Two sessions that find only each other.
struct Two {
  explicit Two(bool open = false, const std::map<std::string, TransportKeys, std::less<>>& rules = {})
      : gates(open), talker(Publishing(bus), gates, domain, rules), listener(Subscribing(bus), gates, domain, {}) {}
  static ZmqOptions Publishing(const Bus& bus) {
    ZmqOptions options;
    options.publish = {{bus.Endpoint("a"), std::nullopt}};
    return options;
  }
  static ZmqOptions Subscribing(const Bus& bus) {
    ZmqOptions options;
    options.subscribe = {{bus.Endpoint("a"), std::nullopt, {}}};
    return options;
  }
  void ExpectUse(const std::string& transport) {
    EXPECT_TRUE(Await([&] { return listener.UsedTransport() == transport && check.last > 100; })) << transport;
  }
  // Messages still flow, over one transport.
  void ExpectFlow() {
    const std::uint64_t before = check.last;
    EXPECT_TRUE(Await([&] { return check.last > before + 50 && numbers.subscribers() == 1; }));
    EXPECT_EQ(check.lost, 0U);
  }
  void ExpectAll() {
    numbers.Stop();
    EXPECT_TRUE(Await([&] { return check.last == numbers.published; })) << check.last << " of " << numbers.published;
    EXPECT_EQ(check.lost, 0U);
  }

  const Bus bus;
  const std::string domain = "test-" + SessionId::Random().ToString();
  Gates gates;
  Bridged talker;
  Bridged listener;
  Counting numbers{talker, "numbers"};
  Checking check{listener, "numbers"};
};

void MessagesMoveToACheaperTransportAndThenToTheCheapest() {
  Two two;
  two.ExpectUse("ZeroMQ");
  two.gates.pipe.Open();
  two.ExpectUse("a pipe");
  two.ExpectFlow();
  two.gates.loop.Open();
  two.ExpectUse("a loop");
  two.ExpectFlow();
  two.ExpectAll();
}

void TransportThatComesDuringAMoveIsUsedNext() {
  Two two;
  two.ExpectUse("ZeroMQ");
  two.gates.pipe.Open();
  two.gates.loop.Open();
  two.ExpectUse("a loop");
  two.ExpectFlow();
  two.ExpectAll();
}

void CheapestIsUsedAndMessagesFallBackToTheNextOneWhenItBreaks() {
  Two two(true);
  two.ExpectUse("a loop");
  two.ExpectFlow();
  EXPECT_EQ(two.check.repeated, 0U);
  two.gates.loop.Close();
  two.ExpectUse("a pipe");
  two.ExpectFlow();
  two.gates.pipe.Close();
  two.ExpectUse("ZeroMQ");
  two.ExpectFlow();
  two.gates.loop.Open();
  two.ExpectUse("a loop");  // It is the cheapest again.
  two.ExpectFlow();
  two.ExpectAll();
}

void OneIsSaidToReachNobodyWithoutACause() {
  Two two;
  EXPECT_TRUE(Await([&] { return !two.listener.Unreached().empty() && !two.talker.Unreached().empty(); }));
  Linger(std::chrono::seconds(1));
  for (const auto* const one : {&two.listener, &two.talker}) {
    const std::vector<std::string> said = one->Unreached();
    ASSERT_EQ(said.size(), 1U);
    EXPECT_NE(said[0].find("no cause was found, and the attempts go on. ZeroMQ carries its messages."), said[0].npos)
        << said[0];
  }
  two.ExpectAll();
}

TEST(ThreeTransports, LoseNothingWhenTheyComeAndBreak) {
  AtOnce({MessagesMoveToACheaperTransportAndThenToTheCheapest, TransportThatComesDuringAMoveIsUsedNext,
          CheapestIsUsedAndMessagesFallBackToTheNextOneWhenItBreaks, OneIsSaidToReachNobodyWithoutACause});
}

TEST(ThreeTransports, RuleKeepsAChannelOnTheOtherTransports) {
  Two two(true, {{"numbers", std::vector<std::string>{"pipe", "zmq"}}});
  two.ExpectFlow();
  EXPECT_EQ(two.listener.UsedTransport(), "a loop") << "for channels without a rule";
  two.ExpectAll();
}

}  // namespace
}  // namespace hgros::test::three_transports_test
