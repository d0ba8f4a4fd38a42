#include "hgros/transport/zmq_transport.hpp"

#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "transport/zmq/zmq_core.hpp"

namespace hgros {
namespace zmq {
namespace {

class ZmqOutbound final : public OutboundChannel {
 public:
  ZmqOutbound(std::shared_ptr<ZmqCore> core, std::string_view channel, const TypeInfo& type, OutboundSource& source)
      : core_(std::move(core)), channel_(std::make_shared<OutboundCore>(channel, type, source)) {
    core_->Offer(channel_);
  }
  ~ZmqOutbound() override {
    if (IsChild()) {
      LeaveToParent(std::move(core_));
    } else {
      core_->Withdraw(channel_);
    }
  }

  std::size_t subscriber_count() const noexcept override {
    return channel_->subscribers.load(std::memory_order_relaxed);
  }
  std::vector<SessionId> Subscribers() const override { return channel_->Sessions(); }
  PublishStatus Reserve() noexcept override { return IsChild() ? PublishStatus::kClosed : core_->Reserve(*channel_); }
  void Commit(const PacketHead& head, const Payload& data) noexcept override {
    if (!IsChild()) core_->Commit(channel_, head, data);
  }
  void Cancel() noexcept override {
    if (!IsChild()) core_->Cancel(channel_);
  }
  Stats stats() const override { return channel_->stats(); }

 private:
  bool IsChild() const noexcept { return core_->carrier().fork.IsChild(); }

  std::shared_ptr<ZmqCore> core_;
  const std::shared_ptr<OutboundCore> channel_;
};

class ZmqInbound final : public InboundChannel {
 public:
  ZmqInbound(std::shared_ptr<ZmqCore> core, std::string_view channel, const TypeInfo& type, const Demand& demand,
             InboundSink& sink)
      : core_(std::move(core)), channel_(std::make_shared<InboundCore>(channel, type, demand, sink)) {
    core_->Want(channel_);
  }
  ~ZmqInbound() override {
    if (IsChild()) {
      LeaveToParent(std::move(core_));
    } else {
      core_->Unwant(channel_);
    }
  }

  std::size_t publisher_count() const noexcept override { return channel_->publishers.load(); }
  bool Asks(SessionId publisher) const override { return channel_->IsClaimed(publisher); }
  void SetDemand(const Demand& demand) override {
    if (IsChild()) return;
    channel_->SetDemand(demand);
    core_->ChangeDemand(channel_);
  }

 private:
  bool IsChild() const noexcept { return core_->carrier().fork.IsChild(); }

  std::shared_ptr<ZmqCore> core_;
  const std::shared_ptr<InboundCore> channel_;
};

class ZmqCarrierTransport final : public ZmqTransport {
 public:
  ZmqCarrierTransport(ZmqOptions options, TransportListener& listener, Log& log)
      : core_(std::make_shared<ZmqCore>(std::move(options), listener, log)) {
    core_->Start();
  }
  ~ZmqCarrierTransport() override {
    if (IsChild()) {
      LeaveToParent(std::move(core_));
    } else {
      core_->Close(static_cast<int>(core_->carrier().options.linger.count()));
    }
  }

  std::unique_ptr<OutboundChannel> Advertise(std::string_view channel, const TypeInfo& type,
                                             OutboundSource& source) override {
    RequireParent();
    RequireChannelName(channel);
    RequireTypeName(type);
    return std::make_unique<ZmqOutbound>(core_, channel, type, source);
  }
  std::unique_ptr<InboundChannel> Subscribe(std::string_view channel, const TypeInfo& type, const Demand& demand,
                                            InboundSink& sink) override {
    RequireParent();
    RequireChannelName(channel);
    RequireTypeName(type);
    return std::make_unique<ZmqInbound>(core_, channel, type, demand, sink);
  }
  std::vector<PeerInfo> Peers() const override { return core_->carrier().peers.List(); }
  TransportStats stats() const override {
    TransportStats stats;
    for (std::size_t i = 0; i < stats.faults.size(); ++i) stats.faults[i] = core_->carrier().faults[i].load();
    stats.repeats = core_->carrier().repeats.load();
    return stats;
  }
  void Close(int linger_ms) noexcept override {
    if (!IsChild()) core_->Close(linger_ms);
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
    if (!IsChild()) core_->AskAgain();
  }
  std::vector<std::string> BoundEndpoints() const override { return core_->BoundEndpoints(); }
  std::vector<SessionChannels> KnownChannels() const override { return core_->KnownChannels(); }
  std::uint64_t refused_handshakes() const override { return core_->refused_handshakes(); }

 private:
  bool IsChild() const noexcept { return core_->carrier().fork.IsChild(); }
  void RequireParent() const {
    if (!IsChild()) return;
    throw Error("A session cannot be used in a forked child.", {}, "Make the session after fork().");
  }

  std::shared_ptr<ZmqCore> core_;
};

}  // namespace
}  // namespace zmq

std::unique_ptr<ZmqTransport> MakeZmqTransport(ZmqOptions options, TransportListener& listener, Log& log) {
  return std::make_unique<zmq::ZmqCarrierTransport>(std::move(options), listener, log);
}

}  // namespace hgros
