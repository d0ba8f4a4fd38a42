#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "graph/nodes/node.hpp"

namespace hgros {

// The nodes of a channel at one moment. It never changes; a new one replaces it.
struct Fanout {
  std::vector<std::shared_ptr<Node>> nodes;
  bool lossless = false;              // At least one node is lossless.
  Node* sole_lossless = nullptr;      // The lossless node, if there is exactly one.
  bool count_bytes = false;           // At least one node has a byte limit.
  bool has_inline = false;            // At least one node runs its callback in the delivering thread.
  const TypeInfo* inbound = nullptr;  // The type as which remote messages are decoded; null: no node.
  std::size_t raw = 0;                // Number of nodes that take messages raw.
};

// Gives back what the lossless among the first `count` nodes have reserved. True if somebody waits for that room.
[[nodiscard]] bool CancelReservations(const Fanout& fanout, std::size_t count, std::size_t bytes) noexcept;
[[nodiscard]] std::shared_ptr<const Fanout> MakeFanout(std::vector<std::shared_ptr<Node>> nodes);

}  // namespace hgros
