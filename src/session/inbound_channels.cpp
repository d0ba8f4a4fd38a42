#include "session/inbound_channels.hpp"

#include <algorithm>
#include <utility>

#include "hgros/services/service_place.hpp"
#include "session/channel_uses.hpp"

namespace hgros {

// Belongs to one Subscription. Its destructor withdraws the subscription's demand from remote publishers.
class InboundChannels::DemandTicket {
 public:
  DemandTicket(std::shared_ptr<InboundChannels> channels, std::string channel, std::list<Demand>::iterator demand,
               bool raw)
      : channels_(std::move(channels)), channel_(std::move(channel)), demand_(demand), raw_(raw) {}
  DemandTicket(const DemandTicket&) = delete;
  DemandTicket& operator=(const DemandTicket&) = delete;
  ~DemandTicket() { channels_->Withdraw(channel_, demand_, raw_); }

 private:
  const std::shared_ptr<InboundChannels> channels_;
  const std::string channel_;
  const std::list<Demand>::iterator demand_;
  const bool raw_;
};

InboundChannels::InboundChannels(Means means) : means_(std::move(means)) {}
InboundChannels::~InboundChannels() = default;

std::shared_ptr<const void> InboundChannels::Add(const std::shared_ptr<InboundChannels>& self, Channel& channel,
                                                 const TypeInfo& type, const Demand& demand) {
  const std::string& name = DataGraph::NameOf(channel);
  std::shared_ptr<const void> ticket;
  {
    const std::scoped_lock lock(self->mutex_);
    if (self->closed_) return nullptr;
    Inflow& inflow = self->inflows_[name];
    const auto place = inflow.wanted.insert(inflow.wanted.end(), demand);
    const bool raw = IsAnyType(type);
    inflow.raw += raw ? 1 : 0;
    ticket = std::make_shared<DemandTicket>(self, name, place, raw);
    const Means& means = self->means_;
    if (!inflow.inlet) {
      inflow.inlet = std::make_shared<ChannelInlet>(channel, IsReplyChannel(name), means.log, means.on_change,
                                                    means.post, means.tell_misfit, means.clocks);
    } else if (inflow.joined && !IsAnyType(DataGraph::TypeOfChannel(channel))) {
      means.post([inlet = inflow.inlet] { inlet->CompareOffers(); });
    }
    if (inflow.joined) self->TellDemand(name, inflow);
  }
  self->Reconcile(name, false);
  return ticket;
}

std::shared_ptr<const void> InboundChannels::Expect(const std::shared_ptr<InboundChannels>& self,
                                                    const std::string& channel) {
  const std::scoped_lock lock(self->mutex_);
  const auto entry = self->inflows_.find(channel);
  if (entry == self->inflows_.end()) return nullptr;
  ++entry->second.expected;
  return {self.get(), [self, channel](const void*) { self->ExpectNoMore(channel); }};
}

void InboundChannels::ExpectNoMore(const std::string& channel) {
  const std::scoped_lock lock(mutex_);
  if (closed_) return;
  Inflow& inflow = inflows_.at(channel);
  if (--inflow.expected > 0 || !inflow.joined || !inflow.wanted.empty()) return;
  means_.post([this, channel] { Reconcile(channel, true); });
}

void InboundChannels::Withdraw(const std::string& channel, std::list<Demand>::iterator demand, bool raw) {
  Fifo<InboundMessage> left;  // Destroyed after the lock.
  const std::scoped_lock lock(mutex_);
  if (closed_) return;
  Inflow& inflow = inflows_.at(channel);
  inflow.wanted.erase(demand);
  inflow.raw -= raw ? 1 : 0;
  if (!inflow.wanted.empty()) {
    if (inflow.joined) TellDemand(channel, inflow);
    if (!AsksForTooMuch(inflow)) return;
  }
  if (inflow.joined && inflow.wanted.empty() && IsRequestChannel(channel)) {
    inflow.missed = true;
    // Not for a service that begins before that: the callers will hear that the last one has ended.
    if (!inflow.busy) left = inflow.inlet->Leave();
  }
  // Posted, because ending the inbound channel waits for its callbacks, and a callback may be ending this subscription.
  if (inflow.joined) means_.post([this, channel] { Reconcile(channel, true); });
}

void InboundChannels::TellDemand(const std::string& channel, const Inflow& inflow) const {
  const Demand demand = Combine(inflow.wanted);
  inflow.inlet->SetDemand(demand);
  bridge_->SetLossless(channel, demand.lossless);
}

bool InboundChannels::AsksForTooMuch(const Inflow& inflow) {
  return inflow.joined && inflow.raw == 0 && !inflow.wanted.empty() && inflow.inlet->AsksForTooMuch() &&
         !Combine(inflow.wanted).lossless;
}

void InboundChannels::Reconcile(const std::string& channel, bool may_wait) {
  std::unique_lock lock(mutex_);
  const auto entry = inflows_.find(channel);
  if (entry == inflows_.end() || entry->second.busy) return;
  Inflow& inflow = entry->second;
  inflow.busy = true;
  const auto leave = [](Inflow* one) { one->busy = false; };
  const std::unique_ptr<Inflow, decltype(leave)> busy(&inflow, leave);  // Joining can throw.
  const auto fits = [&] {
    return inflow.joined == IsWanted(channel, inflow) && !inflow.missed && !(may_wait && AsksForTooMuch(inflow));
  };
  while (bridge_ != nullptr && !closed_ && !fits()) {
    if (inflow.joined && !may_wait) {  // Forbidden meanwhile, or to be subscribed to again.
      means_.post([this, channel] { Reconcile(channel, true); });
      break;
    }
    if (inflow.joined) {
      {
        const auto left = inflow.wanted.empty() ? inflow.inlet->Leave() : Fifo<InboundMessage>();
        lock.unlock();
      }
      inflow.inlet->Detach();
      lock.lock();
      inflow.joined = false;
      inflow.missed = false;
      bridge_->EndSubscribing(channel);
    } else {
      inflow.inlet->Join(*bridge_, Combine(inflow.wanted));
      inflow.joined = true;
    }
  }
  if (!may_wait && AsksForTooMuch(inflow)) means_.post([this, channel] { Reconcile(channel, true); });
  means_.on_change();  // Who waits for IsSettled() takes the mutex first.
}

bool InboundChannels::SetForbidden(const std::string& channel, bool forbidden) {
  bool ends_lossless = false;
  {
    const std::scoped_lock lock(mutex_);
    const auto inflow = inflows_.find(channel);
    const bool lossless = inflow != inflows_.end() && inflow->second.joined && !inflow->second.wanted.empty() &&
                          Combine(inflow->second.wanted).lossless;
    ends_lossless = forbidden && lossless;
    if (forbidden) forbidden_.insert(channel);
    if (!forbidden) forbidden_.erase(channel);
  }
  Reconcile(channel, true);
  return ends_lossless;
}

void InboundChannels::Join(NetworkBridge& bridge) {
  const std::scoped_lock lock(mutex_);
  bridge_ = &bridge;
  for (auto& [name, inflow] : inflows_) {
    if (!IsWanted(name, inflow) || inflow.joined || inflow.busy) continue;
    inflow.inlet->Join(bridge, Combine(inflow.wanted));
    inflow.joined = true;
  }
}

void InboundChannels::Close() {
  std::vector<std::shared_ptr<ChannelInlet>> inlets;
  NetworkBridge* bridge = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
    bridge = bridge_;
    for (auto& [name, inflow] : inflows_) inlets.push_back(inflow.inlet);
  }
  // After Leave(), peers learn that the subscriptions end from the goodbye only, and Detach() waits for running
  // callbacks before it. So while a callback runs, End() comes first, and no lossless publisher waits for the callback.
  // This does not hold for a callback that begins after the check.
  const bool busy = std::ranges::any_of(inlets, [](const auto& inlet) { return inlet->busy(); });
  if (bridge != nullptr && !busy) bridge->Leave();
  for (const auto& inlet : inlets) inlet->End();
  if (bridge != nullptr) bridge->Leave();
  for (const auto& inlet : inlets) inlet->Detach();
}

void InboundChannels::Drop() {
  std::map<std::string, Inflow, std::less<>> dropped;
  const std::scoped_lock lock(mutex_);
  dropped.swap(inflows_);
}

// The demand that satisfies all: lossless if one of them is, with the smallest credit of the lossless ones.
Demand InboundChannels::Combine(const std::list<Demand>& wanted) {
  Demand combined = wanted.front();
  for (const Demand& demand : wanted) {
    if (demand.lossless && !combined.lossless) {
      combined = demand;
    } else if (demand.lossless == combined.lossless && demand.lossless) {
      combined.credit_messages = std::min(combined.credit_messages, demand.credit_messages);
      combined.credit_bytes = std::min(combined.credit_bytes, demand.credit_bytes);
    } else if (demand.lossless == combined.lossless) {
      combined.queue_depth = std::max(combined.queue_depth, demand.queue_depth);
    }
  }
  return combined;
}

std::size_t InboundChannels::PublisherCount(std::string_view channel) const {
  const std::scoped_lock lock(mutex_);
  const auto entry = inflows_.find(channel);
  return entry == inflows_.end() ? 0 : entry->second.inlet->publisher_count();
}

bool InboundChannels::IsSettled(std::string_view channel) const {
  const std::scoped_lock lock(mutex_);
  const auto entry = inflows_.find(channel);
  return entry == inflows_.end() || !entry->second.busy;
}

std::shared_ptr<const MessageSchema> InboundChannels::SchemaOf(std::string_view channel) const {
  const std::scoped_lock lock(mutex_);
  const auto entry = inflows_.find(channel);
  return entry == inflows_.end() ? nullptr : entry->second.inlet->Schema();
}

void InboundChannels::AddTo(std::vector<ChannelUse>& uses) const {
  const std::scoped_lock lock(mutex_);
  for (const auto& [name, inflow] : inflows_) {
    if (inflow.wanted.empty()) continue;
    ChannelUse& use = uses.emplace_back(UseOf(name, inflow.inlet->channel_type()));
    use.subscribes = true;
    use.lossless = Combine(inflow.wanted).lossless;
  }
}

void InboundChannels::AddTo(std::vector<ChannelTraffic>& traffic) const {
  const std::scoped_lock lock(mutex_);
  for (const auto& [name, inflow] : inflows_) {
    const auto listed = std::ranges::find(traffic, name, &ChannelTraffic::channel);
    ChannelTraffic& one = listed != traffic.end() ? *listed : traffic.emplace_back();
    one.channel = name;
    inflow.inlet->AddTo(one);
  }
}

}  // namespace hgros
