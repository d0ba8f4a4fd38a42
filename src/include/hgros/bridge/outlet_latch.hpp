#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <vector>

#include "hgros/base/bytes.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/internal/codec/packet.hpp"

namespace hgros {

// What an outlet keeps for subscribers that come later.
//
// Thread safety: all functions. Messages that are kept no longer are returned, because their destructors are user code.
class OutletLatch {
 public:
  struct Kept {
    AnyMessage message;
    const TypeInfo* type;
    PacketHead head;              // Without a number: it stays inside.
    std::uint64_t own_number;     // In this process; 0: none.
    std::optional<Payload> data;  // Set if encoded already; without an owner: it cannot be encoded.
  };
  using Messages = std::deque<Kept>;

  // Keeps at most `depth` messages, this one included.
  [[nodiscard]] Messages Keep(Kept&& message, std::size_t depth);
  [[nodiscard]] Messages All() const;
  [[nodiscard]] Messages Clear();
  // Calls `change(kept)` for each, under the mutex.
  template <typename Change>
  void ChangeAll(const Change& change) {
    const std::scoped_lock lock(mutex_);
    for (Kept& one : kept_) change(one);
  }
  // Calls `number(kept)` for those without a number, sorts all by their numbers, and returns those that have got one.
  template <typename Number>
  [[nodiscard]] std::vector<Kept> NumberThose(const Number& number) {
    std::vector<Kept> numbered;
    const std::scoped_lock lock(mutex_);
    numbered.reserve(kept_.size());
    for (Kept& one : kept_) {
      if (one.head.id.sequence != 0) continue;
      number(one);
      numbered.push_back(one);
    }
    Sort();
    return numbered;
  }

 private:
  void Sort();

  mutable std::mutex mutex_;
  Messages kept_;
};

}  // namespace hgros
