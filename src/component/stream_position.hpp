#pragma once

#include <algorithm>
#include <cstdint>

#include "hgros/component/component_move.hpp"
#include "hgros/graph/message_info.hpp"

namespace hgros {

// The message at this position.
inline MessageInfo MessageAt(const InputPosition& position) {
  MessageInfo info;
  info.id = position.last;
  info.number = position.number;
  info.remote = position.remote;
  return info;
}

// How far the messages of one publisher have come.
struct StreamPosition {
  std::uint64_t sequence = 0;
  std::uint64_t number = 0;
  bool by_number = false;  // One of the places is in the publisher's process: only numbers are the same in both.

  // How many messages this one is behind the position; 0 or less: it came before or is the last one.
  [[nodiscard]] std::int64_t Ahead(const MessageInfo& info) const {
    return by_number || !info.remote ? static_cast<std::int64_t>(info.number - number)
                                     : static_cast<std::int64_t>(info.id.sequence - sequence);
  }
  void Note(const MessageInfo& info) {
    by_number = by_number || !info.remote;
    if (info.remote) sequence = std::max(sequence, info.id.sequence);
    number = std::max(number, info.number);
  }
};

}  // namespace hgros
