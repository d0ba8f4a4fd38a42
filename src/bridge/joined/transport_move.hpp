#pragma once

#include <vector>

#include "hgros/bridge/transport_list.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// The two transports of a move.
struct MoveWay {
  TransportIndex from = 0;
  TransportIndex to = 0;
};

/// Keeps one publisher's messages on one channel in order while they move from one transport to another and come over
/// both. The publisher gives each message to both, and the sequence numbers show the order. Messages of the new
/// transport wait until the old one has delivered everything before them. From then on those of the old one are
/// repeats.
///
/// Not thread-safe.
class TransportMove {
 public:
  explicit TransportMove(MoveWay way) : way_(way) {}

  /// The messages to deliver, in order, now that `message` has come over `transport`.
  [[nodiscard]] std::vector<InboundMessage> Arrive(InboundMessage&& message, TransportIndex transport);
  /// The messages to deliver when the old transport delivers nothing more.
  [[nodiscard]] std::vector<InboundMessage> Finish();
  [[nodiscard]] bool done() const noexcept { return done_; }
  [[nodiscard]] const MoveWay& way() const noexcept { return way_; }

 private:
  MoveWay way_;
  bool done_ = false;
  std::vector<InboundMessage> held_;  // Limited by their credit.
};

}  // namespace hgros
