#include "bridge/open_transports.hpp"

#include <utility>

namespace hgros {

Transport& OpenTransports::Open(TransportIndex transport, TransportEntry::Takes takes, TransportListener& listener,
                                Log& log) {
  Slot& slot = slots_[transport];
  if (slot.transport) return *slot.transport;
  slot.transport = list_[transport].make(std::move(takes), listener, log);
  if (auto* const zmq = dynamic_cast<ZmqTransport*>(slot.transport.get())) zmq_.store(zmq, std::memory_order_release);
  slot.open.store(slot.transport.get(), std::memory_order_release);
  return *slot.transport;
}

std::vector<Transport*> OpenTransports::All() const {
  std::vector<Transport*> all;
  for (const Slot& slot : slots_) {
    if (Transport* const transport = slot.open.load(std::memory_order_acquire)) all.push_back(transport);
  }
  return all;
}

bool OpenTransports::reach_other_hosts() const noexcept {
  for (TransportIndex i = 0; i < list_.size(); ++i) {
    if (list_[i].reach == TransportReach::kNetwork && (*this)[i] != nullptr) return true;
  }
  return false;
}

void OpenTransports::Receive(const Visit& visit) const noexcept {
  for (const Slot& slot : slots_) {
    if (Transport* const transport = slot.open.load(std::memory_order_acquire)) return transport->Receive(visit);
  }
  visit.first();
}

bool OpenTransports::ReceiveHere(const Visit& visit) const noexcept {
  for (const Slot& slot : slots_) {
    if (Transport* const transport = slot.open.load(std::memory_order_acquire)) return transport->ReceiveHere(visit);
  }
  return false;
}

void OpenTransports::WakeReceiver() const noexcept {
  for (const Slot& slot : slots_) {
    if (Transport* const transport = slot.open.load(std::memory_order_acquire)) return transport->WakeReceiver();
  }
}

TransportStats OpenTransports::stats() const {
  TransportStats sum;
  for (const Transport* const transport : All()) {
    const TransportStats stats = transport->stats();
    for (std::size_t i = 0; i < sum.faults.size(); ++i) sum.faults[i] += stats.faults[i];
    sum.repeats += stats.repeats;
  }
  return sum;
}

void OpenTransports::Leave() noexcept {
  for (const Slot& slot : slots_) {
    if (Transport* const transport = slot.open.load(std::memory_order_acquire)) transport->Leave();
  }
}

void OpenTransports::Close(int linger_ms, int at_most_ms) noexcept {
  for (const Slot& slot : slots_) {
    if (Transport* const transport = slot.open.load(std::memory_order_acquire)) transport->Close(linger_ms, at_most_ms);
  }
}

}  // namespace hgros
