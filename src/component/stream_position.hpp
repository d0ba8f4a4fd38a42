#pragma once

#include <algorithm>
#include <cstdint>

#include "component/number_gaps.hpp"
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
class StreamPosition {
 public:
  // One of the places is in the publisher's process: only numbers are the same in both.
  void UseNumbers() noexcept { by_number_ = true; }
  // How many messages this one is behind the position; 0 or less: it came before or is the last one.
  [[nodiscard]] std::int64_t Ahead(const MessageInfo& info) const {
    return by_number_ || !info.remote ? static_cast<std::int64_t>(info.number - number_)
                                      : static_cast<std::int64_t>(info.id.sequence - sequence_);
  }
  // A later message has come, but not this one.
  [[nodiscard]] bool Misses(const MessageInfo& info) const { return gaps_.Has(info.number); }
  [[nodiscard]] bool misses_any() const noexcept { return !gaps_.empty(); }
  void Note(const MessageInfo& info) {
    gaps_.Note(number_, info.number);
    if (info.remote) {
      sequence_ = std::max(sequence_, info.id.sequence);
    } else {
      UseNumbers();
    }
    number_ = std::max(number_, info.number);
  }
  void NoteGaps(const NumberGaps& gaps) { gaps_ = gaps; }

 private:
  std::uint64_t sequence_ = 0;
  std::uint64_t number_ = 0;
  bool by_number_ = false;
  NumberGaps gaps_;  // Also of messages that were not sent here.
};

}  // namespace hgros
