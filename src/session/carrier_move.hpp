#pragma once

#include <vector>

#include "hgros/session/carrier_set.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// One publisher's messages on one channel, while they move from one carrier to another and come over both: which go
/// on, and when. The publisher gives each message to both, so their numbers tell: what comes over the new one waits
/// until the old one has brought all that was published before it; from then on the old one's are repeats.
///
/// Not thread-safe.
class CarrierMove {
 public:
  explicit CarrierMove(CarrierKind to) : to_(to) {}

  /// What goes on now that `message` has come over `kind`, in order.
  [[nodiscard]] std::vector<InboundMessage> Arrive(InboundMessage&& message, CarrierKind kind);
  /// Likewise when the old one brings nothing more.
  [[nodiscard]] std::vector<InboundMessage> Finish();
  [[nodiscard]] bool done() const noexcept { return done_; }

 private:
  const CarrierKind to_;
  bool done_ = false;
  std::vector<InboundMessage> held_;  // Their credits bound them.
};

}  // namespace hgros
