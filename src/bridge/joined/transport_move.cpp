#include "bridge/joined/transport_move.hpp"

#include <iterator>
#include <utility>

namespace hgros {

std::vector<InboundMessage> TransportMove::Arrive(InboundMessage&& message, TransportIndex transport) {
  std::vector<InboundMessage> on;
  if (transport == way_.to) {
    (done_ ? on : held_).push_back(std::move(message));
    return on;
  }
  // The message comes, or has come, over the new transport; or it is a late repeat from a transport before the old
  // one.
  if (done_ || transport != way_.from) return on;
  if (held_.empty()) {
    on.push_back(std::move(message));
    return on;
  }
  const std::uint64_t first = held_.front().head.id.sequence;
  const std::uint64_t sequence = message.head.id.sequence;
  if (sequence < first) on.push_back(std::move(message));
  if (sequence + 1 < first) return on;
  std::vector<InboundMessage> rest = Finish();
  on.insert(on.end(), std::make_move_iterator(rest.begin()), std::make_move_iterator(rest.end()));
  return on;
}

std::vector<InboundMessage> TransportMove::Finish() {
  done_ = true;
  return std::exchange(held_, {});
}

}  // namespace hgros
