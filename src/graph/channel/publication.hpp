#pragma once

#include <cstddef>

#include "graph/channel/fanout.hpp"
#include "hgros/graph/message_info.hpp"
#include "hgros/internal/graph/outlet.hpp"

namespace hgros {

// A local message with its number, on its way to all nodes. The pointers are valid as long as the epoch guard.
struct Publication {
  AnyMessage message;
  const TypeInfo* type;
  MessageInfo info;
  const Fanout* fanout;
  const Fanout* after;  // The nodes when the message was latched.
  Outlet* outlet;       // Null: the message stays in the process.
  std::size_t bytes;
  bool reserved;
  bool local;
  PreparedMessage prepared;  // By the outlet.
};

}  // namespace hgros
