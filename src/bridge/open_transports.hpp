#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/bridge/transport_list.hpp"
#include "hgros/transport/zmq_transport.hpp"

namespace hgros {

/// The transports that a session has opened.
///
/// Thread safety: all functions; only one thread at a time opens transports. Invariants: an open transport stays
/// until the end.
class OpenTransports {
 public:
  /// `list` outlives it.
  explicit OpenTransports(const TransportList& list) : list_(list), slots_(list.size()) {}

  /// Throws Error. `listener` and `log` outlive it.
  Transport& Open(TransportIndex transport, TransportEntry::Takes takes, TransportListener& listener, Log& log);
  /// Null if it is not open.
  [[nodiscard]] Transport* operator[](TransportIndex transport) const noexcept {
    return slots_[transport].open.load(std::memory_order_acquire);
  }
  /// All that are open, the cheapest first.
  [[nodiscard]] std::vector<Transport*> All() const;
  [[nodiscard]] bool reach_other_hosts() const noexcept;
  /// The one with endpoints; null if it is not open.
  [[nodiscard]] ZmqTransport* zmq() const noexcept { return zmq_.load(std::memory_order_acquire); }

  /// See Transport::Receive(). The cheapest transport is read.
  void Receive(const Visit& visit) const noexcept;
  [[nodiscard]] bool ReceiveHere(const Visit& visit) const noexcept;
  void WakeReceiver() const noexcept;
  [[nodiscard]] TransportStats stats() const;
  void Leave() noexcept;
  void Close(int linger_ms, int at_most_ms) noexcept;

 private:
  struct Slot {
    std::unique_ptr<Transport> transport;
    std::atomic<Transport*> open{nullptr};  // Read while another thread opens it.
  };

  const TransportList& list_;
  std::vector<Slot> slots_;
  std::atomic<ZmqTransport*> zmq_{nullptr};
};

}  // namespace hgros
