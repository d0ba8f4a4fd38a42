#include "graph/channel/fanout.hpp"

#include <utility>

#include "hgros/codec/raw_message.hpp"

namespace hgros {

bool CancelReservations(const Fanout& fanout, std::size_t count, std::size_t bytes) noexcept {
  bool missed = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (fanout.nodes[i]->lossless()) missed = fanout.nodes[i]->CancelReservation(bytes) || missed;
  }
  return missed;
}

std::shared_ptr<const Fanout> MakeFanout(std::vector<std::shared_ptr<Node>> nodes) {
  auto fanout = std::make_shared<Fanout>();
  for (const std::shared_ptr<Node>& node : nodes) {
    const NodeSetting& setting = node->setting();
    if (setting.queue.lossless()) fanout->sole_lossless = fanout->lossless ? nullptr : node.get();
    fanout->lossless = fanout->lossless || setting.queue.lossless();
    fanout->count_bytes = fanout->count_bytes || setting.queue.limit_bytes() != Queue::kUnlimitedBytes;
    fanout->has_inline = fanout->has_inline || setting.executor.kind() == Executor::Kind::kInline;
    // A node that reads the bytes in place gets them without a copy; copies are made only for the other nodes.
    fanout->raw += IsAnyType(*setting.type) ? 1 : 0;
    const bool raw =
        fanout->inbound != nullptr && IsAnyType(*fanout->inbound);  // Messages of other types are made from it.
    const bool better = setting.type->encode_in_place != nullptr || IsAnyType(*setting.type);
    if (fanout->inbound == nullptr || (better && !raw)) fanout->inbound = setting.type;
  }
  fanout->nodes = std::move(nodes);
  return fanout;
}

}  // namespace hgros
