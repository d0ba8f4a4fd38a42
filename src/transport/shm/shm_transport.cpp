#include "hgros/transport/shm_transport.hpp"

#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "transport/channel_ends.hpp"
#include "transport/shm/shm_core.hpp"

namespace hgros {
namespace shm {
namespace {

using ShmPublishing = PublishingEnd<ShmCore, OutChannel>;
using ShmSubscribing = SubscribingEnd<ShmCore>;

class SharedMemoryTransport final : public ShmTransport {
 public:
  SharedMemoryTransport(ShmOptions options, TransportListener& listener, Log& log)
      : core_(std::make_shared<ShmCore>(std::move(options), listener, log)) {
    core_->Start();
  }
  ~SharedMemoryTransport() override {
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
    return std::make_unique<ShmPublishing>(core_, channel, type, source);
  }
  std::unique_ptr<InboundChannel> Subscribe(std::string_view channel, const TypeInfo& type, const Demand& demand,
                                            InboundSink& sink) override {
    RequireParent();
    RequireChannelName(channel);
    RequireTypeName(type);
    return std::make_unique<ShmSubscribing>(core_, channel, type, demand, sink);
  }
  std::vector<PeerInfo> Peers() const override { return core_->Peers(); }
  TransportStats stats() const override { return core_->stats(); }
  void Close(int linger_ms, int /*at_most_ms*/) noexcept override {
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
  std::string Obstacle(SessionId peer, const std::string& place) const override { return core_->Obstacle(peer, place); }
  const std::string& place() const noexcept override { return core_->options().place; }
  std::optional<Block> Loan(std::size_t size_bytes) override { return core_->Loan(size_bytes); }
  ShmUsage usage() const override { return core_->usage(); }
  void Receive(const Visit& visit) noexcept override { core_->IsChild() ? visit.first() : core_->Receive(visit); }
  bool ReceiveHere(const Visit& visit) noexcept override { return !core_->IsChild() && core_->ReceiveHere(visit); }
  void WakeReceiver() noexcept override {
    if (!core_->IsChild()) core_->WakeReceiver();
  }

 private:
  void RequireParent() const {
    if (!core_->IsChild()) return;
    throw Error("A session cannot be used in a forked child.", {}, "Make the session after fork().");
  }

  std::shared_ptr<ShmCore> core_;
};

}  // namespace
}  // namespace shm

std::unique_ptr<ShmTransport> MakeShmTransport(ShmOptions options, TransportListener& listener, Log& log) {
  return std::make_unique<shm::SharedMemoryTransport>(std::move(options), listener, log);
}

}  // namespace hgros
