#include "bridge/joined/cut_subscribers.hpp"

#include <algorithm>
#include <new>
#include <utility>

namespace hgros {
namespace {

CutSubscribers::Messages InOrder(std::map<std::uint64_t, OutboundMessage>&& messages) {
  CutSubscribers::Messages list;
  list.reserve(messages.size());
  for (auto& [sequence, message] : messages) list.push_back(std::move(message));
  return list;
}

}  // namespace

void CutSubscribers::Keep(Cut& cut, OutboundMessage&& message) {
  const std::uint64_t bytes = message.data.bytes.size();
  if (cut.messages.try_emplace(message.head.id.sequence, std::move(message)).second) cut.bytes += bytes;
}

std::uint64_t CutSubscribers::Add(SessionId subscriber, const Demand& demand, Messages&& unfinished) {
  const std::scoped_lock lock(mutex_);
  Cut& cut = cuts_[subscriber];
  cut.number = ++last_number_;
  cut.demand = demand;
  for (OutboundMessage& message : unfinished) Keep(cut, std::move(message));
  count_.store(cuts_.size(), std::memory_order_release);
  return cut.number;
}

bool CutSubscribers::HasRoom() const {
  const std::scoped_lock lock(mutex_);
  return std::ranges::all_of(cuts_, [](const auto& entry) {
    const Cut& cut = entry.second;
    return cut.messages.size() < cut.demand.credit_messages && cut.bytes < cut.demand.credit_bytes;
  });
}

std::size_t CutSubscribers::Push(const PacketHead& head, const Payload& data) noexcept {
  std::size_t missed = 0;
  const std::scoped_lock lock(mutex_);
  for (auto& [subscriber, cut] : cuts_) {
    try {
      Keep(cut, {head, data});
    } catch (const std::bad_alloc&) {
      ++missed;
    }
  }
  return missed;
}

CutSubscribers::Messages CutSubscribers::TakeMessages(SessionId subscriber) {
  return Drop(subscriber).value_or(Messages{});
}

std::optional<CutSubscribers::Messages> CutSubscribers::Drop(SessionId subscriber, std::optional<std::uint64_t> cut) {
  const std::scoped_lock lock(mutex_);
  const auto found = cuts_.find(subscriber);
  if (found == cuts_.end() || (cut && found->second.number != *cut)) return std::nullopt;
  Messages messages = InOrder(std::move(found->second.messages));
  cuts_.erase(found);
  count_.store(cuts_.size(), std::memory_order_release);
  return messages;
}

}  // namespace hgros
