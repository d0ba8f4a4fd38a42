#include "transport/zmq/inbound.hpp"

#include <cstring>
#include <utility>

namespace hgros::zmq {
namespace {

// Below this a copy is cheaper than keeping a whole receive buffer alive for one small message.
constexpr std::size_t kCopyBelowBytes = 4096;
constexpr std::size_t kRunsAtOnce = 4;

Payload PayloadOf(Message&& frame) {
  const Bytes bytes = frame.bytes();
  if (bytes.size() < kCopyBelowBytes) {
    constexpr std::size_t kUnit = sizeof(std::max_align_t);
    auto copy = std::make_shared_for_overwrite<std::max_align_t[]>((bytes.size() + kUnit - 1) / kUnit + 1);
    if (!bytes.empty()) std::memcpy(copy.get(), bytes.data(), bytes.size());
    const Bytes copied{reinterpret_cast<const std::byte*>(copy.get()), bytes.size()};
    return {copied, std::move(copy)};
  }
  auto owner = std::make_shared<Message>(std::move(frame));
  const Bytes kept = owner->bytes();
  return {kept, std::move(owner)};
}

}  // namespace

InboundCore::InboundCore(std::string_view channel, const TypeInfo& message_type, const Demand& demand,
                         InboundSink& sink)
    : name(channel), plain_topic(PlainTopic(channel)), type(message_type), sink_(sink), demand_(demand) {}

std::string InboundCore::TypeFault(const PacketHead& head, const InboundPacket& packet) const {
  // The paper's own head has the channel and nothing else.
  if (!head.type_name.empty() && head.type_name != type.name)
    return "it carries " + head.type_name + ", not " + type.name;
  if (head.encoding != Encoding::kNone && head.encoding != type.encoding) return "it is encoded in another way";
  if (head.fingerprint == 0 || type.fingerprint == 0 || head.fingerprint == type.fingerprint) return {};
  if (type.encoding != Encoding::kProtobuf) return "its " + type.name + " has another layout";
  // A session's schema was compared when the link was made. Nobody could compare a plain publisher's: it is trusted to
  // send what the type's name says.
  const bool compared = packet.from.value == 0 || head.fingerprint == packet.fingerprint;
  return compared ? std::string() : "its " + type.name + " has another schema than the publisher named";
}

LeaderPool::Task InboundCore::Deliver(const std::shared_ptr<InboundCore>& core, InboundPacket&& packet,
                                      Carrier& carrier, const std::string& endpoint) {
  InboundMessage message;
  if (const auto fault = DecodeHeadFrame(packet.head.bytes(), message.head); fault != PacketFault::kNone) {
    core->Fault(carrier, endpoint, fault, "channel " + core->name + ": its head cannot be read");
    return {};
  }
  if (message.head.channel != core->name) {
    core->Fault(carrier, endpoint, PacketFault::kTopic, "its topic names " + core->name + ", its head another channel");
    return {};
  }
  const std::uint64_t publisher = message.head.id.publisher;
  if (packet.from.value != 0 && publisher != 0 && publisher != packet.from.value) {
    core->Fault(carrier, endpoint, PacketFault::kHead,
                "channel " + core->name + ": its head names another publisher than the session it came from");
    return {};
  }
  if (const auto fault = core->TypeFault(message.head, packet); !fault.empty()) {
    core->Fault(carrier, endpoint, PacketFault::kType, "channel " + core->name + ": " + fault);
    return {};
  }
  if (!core->repeats_.Pass(packet.from, message.head.id)) {
    carrier.repeats.fetch_add(1, std::memory_order_relaxed);
    return {};
  }
  message.data = PayloadOf(std::move(packet.data));
  message.from = packet.from;
  message.credit = std::move(packet.credit);

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
    const std::scoped_lock lock(mutex_);
    if (owed_runs_ == 0) {
      --running_;
      return;
    }
    --owed_runs_;
  }
}

void InboundCore::Fault(Carrier& carrier, const std::string& where, PacketFault fault, std::string_view what) {
  carrier.CountFault(fault, where, what);
  gate_.Through([&] { sink_.OnFault(fault, what); });
}

bool InboundCore::Claim(SessionId publisher, const void* endpoint) {
  const std::scoped_lock lock(mutex_);
  return claims_.try_emplace(publisher, endpoint).first->second == endpoint;
}

bool InboundCore::Release(SessionId publisher, const void* endpoint) {
  const std::scoped_lock lock(mutex_);
  const auto claim = claims_.find(publisher);
  if (claim == claims_.end() || claim->second != endpoint) return false;
  claims_.erase(claim);
  return true;
}

void InboundCore::CountPublisher(const std::shared_ptr<InboundCore>& core, int change, Actions& actions) {
  core->publishers.fetch_add(static_cast<std::size_t>(change));
  actions.emplace_back([core] { core->gate_.Through([&] { core->sink_.OnPublishers(core->publishers.load()); }); });
}

Demand InboundCore::demand() const {
  const std::scoped_lock lock(mutex_);
  return demand_;
}

void InboundCore::SetDemand(const Demand& demand) {
  const std::scoped_lock lock(mutex_);
  demand_ = demand;
}

}  // namespace hgros::zmq
