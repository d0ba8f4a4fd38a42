#include "transport/inbound_core.hpp"

#include <utility>

namespace hgros {
namespace {

constexpr std::size_t kRunsAtOnce = 4;

}  // namespace

InboundCore::InboundCore(std::string_view channel, const TypeInfo& message_type, const Demand& demand,
                         InboundSink& sink)
    : name(channel), plain_topic(PlainTopic(channel)), type(message_type), sink_(sink), demand_(demand) {}

InboundCore::HeadFault InboundCore::Check(const PacketHead& head, SessionId from, std::uint64_t compared) const {
  if (head.channel != name) return {PacketFault::kTopic, "its head names another channel"};
  if (from.value != 0 && head.id.publisher != 0 && head.id.publisher != from.value) {
    return {PacketFault::kHead, "its head names another publisher than the session it came from"};
  }
  if (IsAnyType(type)) {
    if (from.value == 0 || head.fingerprint == 0 || head.fingerprint == compared) return {};
    return {PacketFault::kType, "its " + head.type_name + " has another schema than the publisher named"};
  }
  // The head of the paper contains only the channel.
  if (!head.type_name.empty() && head.type_name != type.name) {
    return {PacketFault::kType, "it carries " + head.type_name + ", not " + type.name};
  }
  if (head.encoding != Encoding::kNone && head.encoding != type.encoding) {
    return {PacketFault::kType, "it is encoded in another way"};
  }
  if (head.fingerprint == 0 || type.fingerprint == 0 || head.fingerprint == type.fingerprint) return {};
  if (type.encoding != Encoding::kProtobuf) return {PacketFault::kType, "its " + type.name + " has another layout"};
  // A session's schema was compared when the link was made. A plain publisher's schema cannot be compared, so only
  // name and encoding are checked.
  if (from.value == 0 || head.fingerprint == compared) return {};
  return {PacketFault::kType, "its " + type.name + " has another schema than the publisher named"};
}

LeaderPool::Task InboundCore::Deliver(const std::shared_ptr<InboundCore>& core, InboundMessage&& message,
                                      std::atomic<std::uint64_t>& repeats) {
  if (!core->repeats_.Pass(message.from, message.head.id)) {
    repeats.fetch_add(1, std::memory_order_relaxed);
    return {};
  }
  auto accepted = Accepted::kNothing;
  core->gate_.Through([&] {
    accepted = core->sink_.Accept(std::move(message));
    if (accepted == Accepted::kRunHere) core->sink_.Run();
  });
  if (accepted != Accepted::kRunApart || !core->StartRun()) return {};
  return [core] { core->RunApart(); };
}

bool InboundCore::StartRun() {
  const std::scoped_lock lock(mutex_);
  if (running_ < kRunsAtOnce) {
    ++running_;
    return true;
  }
  ++owed_runs_;
  return false;
}

void InboundCore::RunApart() {
  for (;;) {
    gate_.Through([this] { sink_.Run(); });
    if (LeaderPool::LeftRest()) return;
    const std::scoped_lock lock(mutex_);
    if (owed_runs_ == 0) {
      --running_;
      return;
    }
    --owed_runs_;
  }
}

void InboundCore::TellFault(PacketFault fault, std::string_view what) {
  gate_.Through([&] { sink_.OnFault(fault, what); });
}

bool AreOfOneSocket(std::uint64_t one, std::uint64_t other) noexcept {
  constexpr std::uint64_t kNear = 1ULL << 32;
  return one - other < kNear || other - one < kNear;
}

bool InboundCore::Claim(SessionId publisher, const void* endpoint, std::uint64_t handshake) {
  const std::scoped_lock lock(mutex_);
  Claimed& claim = claims_.try_emplace(publisher, Claimed{endpoint, handshake}).first->second;
  if (claim.endpoint != endpoint) return false;
  claim.handshake = handshake;
  return true;
}

bool InboundCore::IsClaimedBeside(SessionId publisher, const void* endpoint, std::uint64_t handshake) const {
  const std::scoped_lock lock(mutex_);
  const auto claim = claims_.find(publisher);
  return claim != claims_.end() && claim->second.endpoint != endpoint &&
         AreOfOneSocket(claim->second.handshake, handshake);
}

bool InboundCore::IsClaimed(SessionId publisher) const {
  const std::scoped_lock lock(mutex_);
  return claims_.contains(publisher);
}

bool InboundCore::Release(SessionId publisher, const void* endpoint) {
  const std::scoped_lock lock(mutex_);
  const auto claim = claims_.find(publisher);
  if (claim == claims_.end() || claim->second.endpoint != endpoint) return false;
  claims_.erase(claim);
  return true;
}

void InboundCore::CountPublisher(const std::shared_ptr<InboundCore>& core, SessionId who, int change, Actions& actions,
                                 OfferEnd why) {
  core->publishers.fetch_add(static_cast<std::size_t>(change));
  actions.emplace_back([core, who, why, ended = change < 0] {
    core->gate_.Through([&] {
      if (ended) core->sink_.OnOfferEnded(who, why);
      core->sink_.OnPublishers(core->publishers.load());
    });
  });
}

void InboundCore::TellOffer(const std::shared_ptr<InboundCore>& core, const PeerInfo& from,
                            const std::shared_ptr<const MessageSchema>& schema, Actions& actions) {
  if (!IsAnyType(core->type)) return;
  actions.emplace_back([core, from, schema] { core->gate_.Through([&] { core->sink_.OnOffer(from, schema); }); });
}

Demand InboundCore::demand() const {
  const std::scoped_lock lock(mutex_);
  return demand_;
}

void InboundCore::SetDemand(const Demand& demand) {
  const std::scoped_lock lock(mutex_);
  demand_ = demand;
}

}  // namespace hgros
