#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "hgros/bridge/network_bridge.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros::test {

/// A bridge that reaches nobody. Its only transport keeps the sinks of subscriptions, so that a test can send to them.
class BareBridge {
 public:
  NetworkBridge& operator*() { return bridge_; }
  [[nodiscard]] InboundSink& sink() const { return *sink_; }

 private:
  struct Nobody final : TransportListener {
    void OnPeerCame(const PeerInfo&) noexcept override {}
    void OnPeerGone(const PeerInfo&, std::string_view) noexcept override {}
    void OnTypeMismatch(std::string_view, const PeerInfo&, std::string_view) noexcept override {}
  };
  class Nothing final : public OutboundChannel {
    [[nodiscard]] std::size_t subscriber_count() const noexcept override { return 0; }
    [[nodiscard]] std::vector<SessionId> Subscribers() const override { return {}; }
    PublishStatus Reserve() noexcept override { return PublishStatus::kOk; }
    bool Commit(const PacketHead&, const Payload&) noexcept override { return true; }
    void Cancel() noexcept override {}
    [[nodiscard]] OutboundStats stats() const override { return {}; }
  };
  class Wire final : public Transport {
   public:
    explicit Wire(InboundSink*& sink) : sink_(sink) {}
    std::unique_ptr<OutboundChannel> Advertise(std::string_view, const TypeInfo&, OutboundSource&) override {
      return std::make_unique<Nothing>();
    }
    std::unique_ptr<InboundChannel> Subscribe(std::string_view, const TypeInfo&, const Demand&,
                                              InboundSink& sink) override {
      sink_ = &sink;
      return nullptr;
    }
    [[nodiscard]] std::vector<PeerInfo> Peers() const override { return {}; }
    [[nodiscard]] TransportStats stats() const override { return {}; }
    void Close(int, int) noexcept override {}

   private:
    InboundSink*& sink_;
  };
  [[nodiscard]] BridgeOptions Options() {
    BridgeOptions options;
    options.zmq.session = SessionId::Random();
    TransportEntry entry{"wire", "a transport that reaches nobody", 10, TransportReach::kHost, {}, true};
    entry.make = [this](const TransportEntry::Takes&, TransportListener&, Log&) {
      return std::make_unique<Wire>(sink_);
    };
    options.more_transports = {entry};
    options.on_announcements = [] {};
    options.later = [](std::chrono::nanoseconds, const std::function<void()>&) {};
    return options;
  }

  InboundSink* sink_ = nullptr;
  Nobody nobody_;
  Log log_{[](LogLevel, std::string_view) {}};
  NetworkBridge bridge_{Options(), nobody_, log_};
};

}  // namespace hgros::test
