#include "hgros/transport/shm_transport.hpp"

#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "transport/shm/shm_core.hpp"

namespace hgros {
namespace shm {
namespace {

class ShmOutbound final : public OutboundChannel {
 public:
  ShmOutbound(std::shared_ptr<ShmCore> core, std::string_view channel, const TypeInfo& type, OutboundSource& source)
      : core_(std::move(core)), channel_(std::make_shared<OutChannel>(channel, type, source)) {
    core_->Offer(channel_);
  }
  ~ShmOutbound() override {
    if (core_->IsChild()) {
      LeaveToParent(std::move(core_));
    } else {
      core_->Withdraw(channel_);
    }
  }

  std::size_t subscriber_count() const noexcept override {
    return channel_->subscribers.load(std::memory_order_relaxed);
  }
  std::vector<SessionId> Subscribers() const override { return channel_->Sessions(); }
  PublishStatus Reserve() noexcept override {
    return core_->IsChild() ? PublishStatus::kClosed : core_->Reserve(*channel_);
  }
  void Commit(const PacketHead& head, const Payload& data) noexcept override {
    if (!core_->IsChild()) core_->Commit(channel_, head, data);
  }
  void Cancel() noexcept override {
    if (!core_->IsChild()) core_->Cancel(channel_);
  }
  std::optional<Block> Loan(std::size_t size_bytes) override {
    return core_->IsChild() ? std::nullopt : core_->Loan(size_bytes);
  }
  Stats stats() const override { return channel_->stats(); }

 private:
  std::shared_ptr<ShmCore> core_;
  const std::shared_ptr<OutChannel> channel_;
};

class ShmInbound final : public InboundChannel {
 public:
  ShmInbound(std::shared_ptr<ShmCore> core, std::string_view channel, const TypeInfo& type, const Demand& demand,
             InboundSink& sink)
      : core_(std::move(core)), channel_(std::make_shared<InboundCore>(channel, type, demand, sink)) {
    core_->Want(channel_);
  }
  ~ShmInbound() override {
    if (core_->IsChild()) {
      LeaveToParent(std::move(core_));
    } else {
      core_->Unwant(channel_);
    }
  }

  std::size_t publisher_count() const noexcept override { return channel_->publishers.load(); }
  void SetDemand(const Demand& demand) override {
    if (core_->IsChild()) return;
    channel_->SetDemand(demand);
    core_->ChangeDemand(channel_);
  }

 private:
  std::shared_ptr<ShmCore> core_;
  const std::shared_ptr<InboundCore> channel_;
};

class ShmCarrierTransport final : public ShmTransport {
 public:
  ShmCarrierTransport(ShmOptions options, TransportListener& listener, Log& log)
      : core_(std::make_shared<ShmCore>(std::move(options), listener, log)) {
    core_->Start();
  }
  ~ShmCarrierTransport() override {
    if (core_->IsChild()) {
      LeaveToParent(std::move(core_));
    } else {
      core_->Close(static_cast<int>(core_->options().linger.count()));
    }
  }

  std::unique_ptr<OutboundChannel> Advertise(std::string_view channel, const TypeInfo& type,
                                             OutboundSource& source) override {
    RequireParent();
    RequireChannelName(channel);
    RequireTypeName(type);
    return std::make_unique<ShmOutbound>(core_, channel, type, source);
  }
  std::unique_ptr<InboundChannel> Subscribe(std::string_view channel, const TypeInfo& type, const Demand& demand,
                                            InboundSink& sink) override {
    RequireParent();
    RequireChannelName(channel);
    RequireTypeName(type);
    return std::make_unique<ShmInbound>(core_, channel, type, demand, sink);
  }
  std::vector<PeerInfo> Peers() const override { return core_->Peers(); }
  TransportStats stats() const override { return core_->stats(); }
  void Close(int linger_ms) noexcept override {
    if (!core_->IsChild()) core_->Close(linger_ms);
  }

  void AddPeer(const std::string& place) override {
    RequireParent();
    core_->AddPeer(place);
  }
  void RemovePeer(const std::string& place) override {
    RequireParent();
    core_->RemovePeer(place);
  }
  void AskAgain() override {
    if (!core_->IsChild()) core_->AskAgain();
  }
  const std::string& place() const noexcept override { return core_->options().place; }
  std::optional<Block> Loan(std::size_t size_bytes) override { return core_->Loan(size_bytes); }
  ShmUsage usage() const override { return core_->usage(); }
  void Receive(const Visit& visit) noexcept override { core_->IsChild() ? visit.first() : core_->Receive(visit); }

 private:
  void RequireParent() const {
    if (!core_->IsChild()) return;
    throw Error("A session cannot be used in a forked child.", {}, "Make the session after fork().");
  }

  std::shared_ptr<ShmCore> core_;
};

}  // namespace
}  // namespace shm

bool ShmTransport::IsVisitor() noexcept { return LeaderPool::IsVisitor(); }

std::unique_ptr<ShmTransport> MakeShmTransport(ShmOptions options, TransportListener& listener, Log& log) {
  return std::make_unique<shm::ShmCarrierTransport>(std::move(options), listener, log);
}

}  // namespace hgros
