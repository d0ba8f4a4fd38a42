#include "bridge/joined/joined_outbound.hpp"

#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros::joined_outbound_test {
namespace {

/// Holds every thread that comes, until it is opened.
struct Barrier {
  std::promise<void> came;
  std::promise<void> open;
  std::shared_future<void> opened = open.get_future().share();
};

/// A channel with one subscriber. Its first loan takes until the barrier is opened.
class SlowChannel final : public OutboundChannel {
 public:
  SlowChannel(Barrier& barrier, OutboundSource& source) : barrier_(barrier) { source.OnSubscribers(1); }
  [[nodiscard]] std::size_t subscriber_count() const noexcept override { return 1; }
  [[nodiscard]] std::vector<SessionId> Subscribers() const override { return {SessionId{7}}; }
  PublishStatus Reserve() noexcept override { return PublishStatus::kOk; }
  bool Commit(const PacketHead&, const Payload&) noexcept override { return true; }
  void Cancel() noexcept override {}
  [[nodiscard]] std::optional<Block> Loan(std::size_t size_bytes) override {
    if (!std::exchange(first_, false)) return std::nullopt;
    barrier_.came.set_value();
    barrier_.opened.wait();
    return Block::Allocate(size_bytes);
  }
  [[nodiscard]] OutboundStats stats() const override { return {}; }

 private:
  Barrier& barrier_;
  bool first_ = true;
};

class SlowTransport final : public Transport {
 public:
  explicit SlowTransport(Barrier& barrier) : barrier_(barrier) {}
  std::unique_ptr<OutboundChannel> Advertise(std::string_view, const TypeInfo&, OutboundSource& source) override {
    return std::make_unique<SlowChannel>(barrier_, source);
  }
  std::unique_ptr<InboundChannel> Subscribe(std::string_view, const TypeInfo&, const Demand&, InboundSink&) override {
    return nullptr;
  }
  [[nodiscard]] std::vector<PeerInfo> Peers() const override { return {}; }
  [[nodiscard]] TransportStats stats() const override { return {}; }
  void Close(int, int) noexcept override {}

 private:
  Barrier& barrier_;
};

struct Nobody final : TransportListener {
  void OnPeerCame(const PeerInfo&) noexcept override {}
  void OnPeerGone(const PeerInfo&, std::string_view) noexcept override {}
  void OnTypeMismatch(std::string_view, const PeerInfo&, std::string_view) noexcept override {}
};

/// An outlet into a bridge with such a transport.
class SlowLoan : public testing::Test {
 protected:
  SlowLoan() {
    BridgeOptions options;
    options.zmq.session = SessionId::Random();
    TransportEntry entry{"slow", "a slow transport", 10, TransportReach::kHost, {}, true};
    entry.make = [this](const TransportEntry::Takes&, TransportListener&, Log&) {
      return std::make_unique<SlowTransport>(barrier);
    };
    options.more_transports = {entry};
    options.on_announcements = [] {};
    options.later = [](std::chrono::nanoseconds, const std::function<void()>&) {};
    bridge.emplace(std::move(options), nobody, *log);
    outlet->Join(*bridge);
    loan = std::async(std::launch::async, [this] { return outlet->Loan(100).has_value(); });
    barrier.came.get_future().wait();
  }
  ~SlowLoan() override {
    outlet->Detach();
    bridge->Close(0);
  }

  const std::shared_ptr<Log> log = std::make_shared<Log>([](LogLevel, std::string_view) {});
  Nobody nobody;
  Barrier barrier;
  std::optional<NetworkBridge> bridge;
  const std::shared_ptr<ChannelOutlet> outlet =
      std::make_shared<ChannelOutlet>("images", AnyType(), MessageId{1, 1, 0}, log,
                                      OutletEvents{[] {}, [] {}, [] { return true; }}, std::make_shared<HostClocks>());
  std::future<bool> loan;
};

constexpr auto kPatience = std::chrono::seconds(20);

TEST_F(SlowLoan, DelaysNobodyElse) {
  auto others = std::async(std::launch::async, [this] {
    const AnyMessage message = std::make_shared<const RawMessage>(RawMessage{nullptr, Block::Allocate(8).payload()});
    PreparedMessage prepared;
    EXPECT_EQ(outlet->Reserve(message.get(), AnyType(), prepared), PublishStatus::kOk);
    EXPECT_TRUE(outlet->Commit(message, AnyType(), {}, std::move(prepared)));
    EXPECT_EQ(outlet->Subscribers().size(), 1U);
    ChannelTraffic traffic;
    outlet->AddTo(traffic);
  });
  EXPECT_EQ(others.wait_for(kPatience), std::future_status::ready);
  barrier.open.set_value();
  EXPECT_TRUE(loan.get());
}

TEST_F(SlowLoan, EndsBeforeItsTransportIsLeft) {
  auto leave = std::async(std::launch::async, [this] { outlet->Detach(); });
  EXPECT_EQ(leave.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
  barrier.open.set_value();
  EXPECT_TRUE(loan.get());
  leave.get();
}

/// A transport whose subscribers the test sets.
class SetTransport final : public Transport {
 public:
  std::unique_ptr<OutboundChannel> Advertise(std::string_view, const TypeInfo&, OutboundSource& its_source) override {
    source = &its_source;
    return std::make_unique<SetChannel>(subscribers);
  }
  std::unique_ptr<InboundChannel> Subscribe(std::string_view, const TypeInfo&, const Demand&, InboundSink&) override {
    return nullptr;
  }
  [[nodiscard]] std::vector<PeerInfo> Peers() const override { return {}; }
  [[nodiscard]] TransportStats stats() const override { return {}; }
  void Close(int, int) noexcept override {}

  void Comes(SessionId subscriber) {
    subscribers.push_back(subscriber);
    source->OnSubscribers(subscribers.size());
  }
  void Ends(SessionId subscriber) {
    std::erase(subscribers, subscriber);
    source->OnUnsubscribed(subscriber);
    source->OnSubscribers(subscribers.size());
  }
  std::vector<SessionId> subscribers;
  OutboundSource* source = nullptr;

 private:
  class SetChannel final : public OutboundChannel {
   public:
    explicit SetChannel(const std::vector<SessionId>& subscribers) : subscribers_(subscribers) {}
    [[nodiscard]] std::size_t subscriber_count() const noexcept override { return subscribers_.size(); }
    [[nodiscard]] std::vector<SessionId> Subscribers() const override { return subscribers_; }
    PublishStatus Reserve() noexcept override { return PublishStatus::kOk; }
    bool Commit(const PacketHead&, const Payload&) noexcept override { return true; }
    void Cancel() noexcept override {}
    [[nodiscard]] std::optional<Block> Loan(std::size_t) override { return std::nullopt; }
    [[nodiscard]] OutboundStats stats() const override { return {}; }

   private:
    const std::vector<SessionId>& subscribers_;
  };
};

struct CountingSource final : OutboundSource {
  std::vector<OutboundMessage> Latched(SessionId) noexcept override { return {}; }
  void OnRoom() noexcept override {}
  void OnSubscribers(std::size_t) noexcept override {}
  void OnUnsubscribed(SessionId) noexcept override { ++ends; }
  int ends = 0;
};

class SubscriberEnd : public testing::Test {
 protected:
  SubscriberEnd() {
    joined->Add(first);
    joined->Add(second);
  }
  ~SubscriberEnd() override { joined->Close(); }

  const SessionId session{7};
  Log log{[](LogLevel, std::string_view) {}};
  CountingSource source;
  SetTransport first;
  SetTransport second;
  const std::shared_ptr<JoinedOutbound> joined = std::make_shared<JoinedOutbound>(
      "calls", AnyType(), source, 2, [](SessionId, const auto&) {}, log);
};

TEST_F(SubscriberEnd, IsToldOnceAndNotForAMoveToAnotherTransport) {
  first.Comes(session);
  second.Comes(session);
  first.Ends(session);
  EXPECT_EQ(source.ends, 0) << "It has moved.";
  second.Ends(session);
  EXPECT_EQ(source.ends, 1);
  second.Comes(session);
  second.Ends(session);
  EXPECT_EQ(source.ends, 2);
}

TEST_F(SubscriberEnd, IsToldThoughItHasSubscribedAgainOverOneTransportMeanwhile) {
  first.Comes(session);
  second.Comes(session);
  second.Ends(session);
  second.Comes(session);
  first.Ends(session);
  EXPECT_EQ(source.ends, 1);
  first.Comes(session);
  second.Ends(session);
  first.Ends(session);
  EXPECT_EQ(source.ends, 2);
}

}  // namespace
}  // namespace hgros::joined_outbound_test
