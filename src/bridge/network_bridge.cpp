#include "hgros/bridge/network_bridge.hpp"

#include <utility>

#include "bridge/bridge_core.hpp"
#include "hgros/bridge/channel_directory.hpp"

namespace hgros {

NetworkBridge::NetworkBridge(BridgeOptions options, TransportListener& listener, Log& log)
    : core_(std::make_unique<BridgeCore>(std::move(options), listener, log)) {}

NetworkBridge::~NetworkBridge() = default;

std::shared_ptr<JoinedOutbound> NetworkBridge::Advertise(const std::string& channel, const TypeInfo& type,
                                                         OutboundSource& source) {
  return core_->Advertise(channel, type, source);
}

std::shared_ptr<JoinedInbound> NetworkBridge::Subscribe(const std::string& channel, const TypeInfo& type,
                                                        const TypeInfo& announced, const Demand& demand,
                                                        InboundSink& sink) {
  return core_->Subscribe(channel, type, announced, demand, sink);
}

std::shared_ptr<const void> NetworkBridge::SubscribeUnannounced(const std::string& channel, const TypeInfo& type,
                                                                const Demand& demand, InboundSink& sink) {
  const auto joined = core_->JoinInbound(channel, type, demand, sink);
  return {joined.get(), [joined](const void* /*joined*/) { joined->Close(); }};
}

void NetworkBridge::SetLossless(const std::string& channel, bool lossless) { core_->SetLossless(channel, lossless); }
void NetworkBridge::EndSubscribing(const std::string& channel) { core_->EndSubscribing(channel); }

void NetworkBridge::EndPublishing(const std::string& channel) { core_->EndPublishing(channel); }

void NetworkBridge::AddPublishEndpoint(const PublishEndpoint& endpoint) { core_->AddPublishEndpoint(endpoint); }

void NetworkBridge::AddSubscribeEndpoint(const SubscribeEndpoint& endpoint) { core_->AddSubscribeEndpoint(endpoint); }

bool NetworkBridge::RemoveSubscribeEndpoint(const std::string& endpoint) {
  return core_->RemoveSubscribeEndpoint(endpoint);
}

void NetworkBridge::SetPublishChannels(const std::string& endpoint, ChannelList channels) {
  core_->Zmq().SetPublishChannels(endpoint, std::move(channels));
}

void NetworkBridge::SetSubscribeChannels(const std::string& endpoint, ChannelList channels) {
  core_->Zmq().SetSubscribeChannels(endpoint, std::move(channels));
}

std::vector<std::string> NetworkBridge::BoundEndpoints() const {
  const ZmqTransport* const zmq = core_->zmq();
  return zmq == nullptr ? std::vector<std::string>() : zmq->BoundEndpoints();
}

OrderWay NetworkBridge::SendOrder(SessionId publisher, std::string_view request) {
  ZmqTransport* const zmq = core_->zmq();
  return zmq == nullptr ? OrderWay::kNone : zmq->SendOrder(publisher, request);
}

std::vector<PeerInfo> NetworkBridge::Peers() const { return core_->Peers(); }

bool NetworkBridge::IsOnThisHost(SessionId peer) const { return core_->IsOnThisHost(peer); }

void NetworkBridge::ListChannels(ChannelDirectory& directory) {
  for (const auto& source : core_->KnownChannels()) directory.Add(source);
}

ChannelSearch NetworkBridge::Search(const std::string& channel) { return core_->Search(channel); }

void NetworkBridge::Receive(const Visit& visit) noexcept { core_->Receive(visit); }

bool NetworkBridge::ReceiveHere(const Visit& visit) noexcept { return core_->ReceiveHere(visit); }

void NetworkBridge::WakeReceiver() noexcept { core_->WakeReceiver(); }

TransportStats NetworkBridge::stats() const { return core_->stats(); }

void NetworkBridge::Leave() noexcept { core_->Leave(); }
void NetworkBridge::Close(int linger_ms, int at_most_ms) noexcept { core_->Close(linger_ms, at_most_ms); }

}  // namespace hgros
