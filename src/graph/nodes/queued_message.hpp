#pragma once

#include <cstddef>
#include <memory>

#include "hgros/codec/type_info.hpp"
#include "hgros/graph/message_info.hpp"

namespace hgros {

// A message on its way into a node.
struct QueuedMessage {
  AnyMessage message;
  MessageInfo info;
  std::shared_ptr<const void> credit;  // The remote sender's; released when the message leaves the queue.
  std::size_t bytes = 0;               // Only set if a node has a byte limit.
};

// The same message during delivery. It is borrowed, so that a node that runs its callback at once copies nothing.
struct Delivery {
  AnyMessage& message;
  const MessageInfo& info;
  const std::shared_ptr<const void>& credit;
  std::size_t bytes = 0;
  bool last = false;  // No other node needs `message` afterwards: it may be moved.
};

}  // namespace hgros
