#include "bridge/joined/joined_inbound.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace hgros {

// The sink, as one transport sees it.
class JoinedInbound::Part final : public InboundSink {
 public:
  Part(JoinedInbound& joined, std::size_t index, TransportIndex over)
      : transport(over), joined_(joined), index_(index) {}

  Accepted Accept(InboundMessage&& message) noexcept override {
    const std::scoped_lock lock(joined_.accepting_);
    if (joined_.moves_.empty()) return joined_.sink_.Accept(std::move(message));
    return joined_.Accept(std::move(message), transport);
  }
  void Run() noexcept override { joined_.sink_.Run(); }
  void OnFault(PacketFault fault, std::string_view what) noexcept override { joined_.sink_.OnFault(fault, what); }
  void OnOffer(const PeerInfo& from, const std::shared_ptr<const MessageSchema>& schema) noexcept override {
    const std::scoped_lock lock(joined_.telling_);
    joined_.offers_.emplace(from.id.value, index_);
    joined_.sink_.OnOffer(from, schema);
  }
  void OnOfferEnded(SessionId from, OfferEnd why) noexcept override {
    const std::scoped_lock lock(joined_.telling_);
    auto& offers = joined_.offers_;
    offers.erase({from.value, index_});
    const auto other = offers.lower_bound({from.value, 0});
    if (other == offers.end() || other->first != from.value) joined_.sink_.OnOfferEnded(from, why);
  }
  void OnPublishers(std::size_t count) noexcept override {
    const std::scoped_lock lock(joined_.telling_);
    auto& counts = joined_.publishers_;
    counts[index_] = count;
    joined_.sink_.OnPublishers(std::accumulate(counts.begin(), counts.end(), std::size_t{0}));
  }

  const TransportIndex transport;
  std::unique_ptr<InboundChannel> channel;

 private:
  JoinedInbound& joined_;
  const std::size_t index_;
};

JoinedInbound::JoinedInbound(std::string channel, const TypeInfo& type, const Demand& demand, InboundSink& sink,
                             std::size_t most_transports, OnMoved on_moved)
    : channel_(std::move(channel)),
      type_(type),
      sink_(sink),
      on_moved_(std::move(on_moved)),
      demand_(demand),
      parts_(most_transports),
      publishers_(most_transports) {}

JoinedInbound::~JoinedInbound() { Close(); }

// Whoever has found it in the bridge's list may still hold it.
void JoinedInbound::Close() {
  {
    const std::scoped_lock lock(adding_);
    no_more_parts_ = true;
  }
  gate_.Close();
  for (const auto& part : parts_) {
    if (part) part->channel.reset();
  }
}

Accepted JoinedInbound::PassOn(std::vector<InboundMessage>&& messages) {
  Accepted all = Accepted::kNothing;
  for (InboundMessage& message : messages) {
    // At most one of them finds that no thread is running.
    if (const Accepted one = sink_.Accept(std::move(message)); one != Accepted::kNothing) all = one;
  }
  return all;
}

Accepted JoinedInbound::Accept(InboundMessage&& message, TransportIndex transport) {
  const SessionId from = message.from;
  const auto move = moves_.find(from);
  if (move == moves_.end()) return sink_.Accept(std::move(message));
  const bool before = move->second.done();
  auto on = move->second.Arrive(std::move(message), transport);
  if (!before && move->second.done()) on_moved_(from, move->second.way().from);
  return PassOn(std::move(on));
}

bool JoinedInbound::Comes(SessionId publisher, TransportIndex over) const {
  return std::ranges::any_of(
      Parts(), [&](const auto& part) { return part->transport == over && part->channel->Asks(publisher); });
}

bool JoinedInbound::Move(SessionId publisher, MoveWay way) {
  bool comes = false;
  gate_.Through([&] { comes = Comes(publisher, way.from); });
  const std::scoped_lock lock(accepting_);
  moves_.erase(publisher);  // A finished move, which holds no message.
  if (comes) moves_.try_emplace(publisher, way);
  return comes;
}

void JoinedInbound::FinishMove(SessionId publisher, const Which& which) {
  gate_.Through([&] {
    Accepted accepted = Accepted::kNothing;
    {
      const std::scoped_lock lock(accepting_);
      const auto move = moves_.find(publisher);
      if (move == moves_.end() || !which(move->second.way())) return;
      accepted = PassOn(move->second.Finish());
    }
    if (accepted != Accepted::kNothing) sink_.Run();
  });
}

void JoinedInbound::ForgetMove(SessionId publisher, const Which& which) {
  std::unordered_map<SessionId, TransportMove>::node_type forgotten;  // Its messages are destroyed after the lock.
  const std::scoped_lock lock(accepting_);
  const auto move = moves_.find(publisher);
  if (move != moves_.end() && which(move->second.way())) forgotten = moves_.extract(move);
}

void JoinedInbound::Add(Transport& transport, TransportIndex over) {
  const std::scoped_lock lock(adding_);
  if (no_more_parts_) return;
  const std::size_t index = count_.load();
  parts_.at(index) = std::make_unique<Part>(*this, index, over);
  parts_[index]->channel = transport.Subscribe(channel_, type_, demand_, *parts_[index]);
  count_.store(index + 1, std::memory_order_release);
}

std::size_t JoinedInbound::publisher_count() const noexcept {
  std::size_t sum = 0;
  for (const auto& part : Parts()) sum += part->channel->publisher_count();
  return sum;
}

bool JoinedInbound::busy() const {
  return std::ranges::any_of(Parts(), [](const auto& part) { return part->channel->busy(); });
}

void JoinedInbound::End() {
  const std::scoped_lock lock(adding_);
  no_more_parts_ = true;
  for (const auto& part : Parts()) part->channel->End();
}

void JoinedInbound::SetDemand(const Demand& demand) {
  const std::scoped_lock lock(adding_);
  demand_ = demand;
  for (const auto& part : Parts()) part->channel->SetDemand(demand);
}

}  // namespace hgros
