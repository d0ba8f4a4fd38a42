#include "hgros/transport/zmq_transport.hpp"

#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "transport/channel_ends.hpp"
#include "transport/zmq/zmq_core.hpp"

namespace hgros {
namespace zmq {
namespace {

using ZmqPublishing = PublishingEnd<ZmqCore, OutboundCore>;
using ZmqSubscribing = SubscribingEnd<ZmqCore>;

class OwningZmqTransport final : public ZmqTransport {
 public:
  OwningZmqTransport(ZmqOptions options, TransportListener& listener, Log& log)
      : core_(std::make_shared<ZmqCore>(std::move(options), listener, log)) {
    core_->Start();
  }
  ~OwningZmqTransport() override {
    if (core_->IsChild()) {
      LeaveToParent(std::move(core_));
    } else {
      const auto& options = core_->shared().options;
      core_->Close(static_cast<int>(options.linger.count()), static_cast<int>(options.peer_timeout.count()));
    }
  }

  std::unique_ptr<OutboundChannel> Advertise(std::string_view channel, const TypeInfo& type,
                                             OutboundSource& source) override {
    RequireParent();
    RequireChannelName(channel);
    RequireTypeName(type);
    return std::make_unique<ZmqPublishing>(core_, channel, type, source);
  }
  std::unique_ptr<InboundChannel> Subscribe(std::string_view channel, const TypeInfo& type, const Demand& demand,
                                            InboundSink& sink) override {
    RequireParent();
    RequireChannelName(channel);
    RequireTypeName(type);
    return std::make_unique<ZmqSubscribing>(core_, channel, type, demand, sink);
  }
  std::vector<PeerInfo> Peers() const override { return core_->shared().peers.List(); }
  TransportStats stats() const override {
    TransportStats stats;
    for (std::size_t i = 0; i < stats.faults.size(); ++i) stats.faults[i] = core_->shared().faults[i].load();
    stats.repeats = core_->shared().repeats.load();
    return stats;
  }
  void Leave() noexcept override { core_->shared().leaving = true; }
  void Close(int linger_ms, int at_most_ms) noexcept override {
    if (!core_->IsChild()) core_->Close(linger_ms, at_most_ms);
  }

  void SetPublishChannels(const std::string& endpoint, ChannelList channels) override {
    RequireParent();
    core_->SetPublishChannels(endpoint, channels);
  }
  void SetSubscribeChannels(const std::string& endpoint, ChannelList channels) override {
    RequireParent();
    core_->SetSubscribeChannels(endpoint, channels);
  }
  void AddPublishEndpoint(const PublishEndpoint& endpoint) override {
    RequireParent();
    core_->AddPublisher(endpoint);
  }
  void AddSubscribeEndpoint(const SubscribeEndpoint& endpoint) override {
    RequireParent();
    core_->AddSubscriber(endpoint);
  }
  bool RemovePublishEndpoint(const std::string& endpoint) override {
    RequireParent();
    return core_->RemovePublisher(endpoint);
  }
  bool RemoveSubscribeEndpoint(const std::string& endpoint) override {
    RequireParent();
    return core_->RemoveSubscriber(endpoint);
  }
  void AskAgain() override {
    if (!core_->IsChild()) core_->AskAgain(nullptr);
  }
  OrderWay SendOrder(SessionId publisher, std::string_view request) override {
    return core_->IsChild() ? OrderWay::kNone : core_->SendOrder(publisher, request);
  }
  std::vector<std::string> BoundEndpoints() const override { return core_->BoundEndpoints(); }
  std::vector<SessionChannels> KnownChannels() const override { return core_->KnownChannels(); }
  std::uint64_t refused_handshakes() const override { return core_->refused_handshakes(); }

 private:
  void RequireParent() const {
    if (!core_->IsChild()) return;
    throw Error("A session cannot be used in a forked child.", {}, "Make the session after fork().");
  }

  std::shared_ptr<ZmqCore> core_;
};

}  // namespace
}  // namespace zmq

std::unique_ptr<ZmqTransport> MakeZmqTransport(ZmqOptions options, TransportListener& listener, Log& log) {
  return std::make_unique<zmq::OwningZmqTransport>(std::move(options), listener, log);
}

}  // namespace hgros
