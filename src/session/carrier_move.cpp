#include "session/carrier_move.hpp"

#include <iterator>
#include <utility>

namespace hgros {

std::vector<InboundMessage> CarrierMove::Arrive(InboundMessage&& message, CarrierKind kind) {
  std::vector<InboundMessage> on;
  if (kind == to_) {
    (done_ ? on : held_).push_back(std::move(message));
    return on;
  }
  if (done_) return on;  // It comes over the new one, or has come.
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

std::vector<InboundMessage> CarrierMove::Finish() {
  done_ = true;
  return std::exchange(held_, {});
}

}  // namespace hgros
