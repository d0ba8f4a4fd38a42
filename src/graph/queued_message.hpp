#pragma once

#include <cstddef>
#include <memory>

#include "hgros/codec/type_info.hpp"
#include "hgros/graph/message_info.hpp"

namespace hgros {

// One message on its way into a node.
struct QueuedMessage {
  AnyMessage message;
  MessageInfo info;
  std::shared_ptr<const void> credit;  // The remote sender's; let go of when the message leaves the queue.
  std::size_t bytes = 0;               // Only counted where a node has a byte limit.
};

}  // namespace hgros
