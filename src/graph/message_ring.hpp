#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "graph/queued_message.hpp"
#include "hgros/graph/queue.hpp"

namespace hgros {

// The bounded queue of one node. Memory grows with use, up to the depth; a keep-all queue goes beyond its limit only
// for messages that were let in without a reservation (remote ones, bounded by their senders' credit).
//
// Thread safety: none, the node locks.
// Invariants: size() == queued; bytes() == sum of their bytes; keep-last: size() <= depth.
class MessageRing {
 public:
  explicit MessageRing(const Queue& queue) : queue_(queue) {}

  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

  // Whether one more message may come, not looking at bytes. `popped` messages were taken out but still count.
  [[nodiscard]] bool HasRoom(std::size_t popped = 0) const noexcept {
    return !queue_.lossless() || size_ + reserved_messages_ + popped < queue_.depth();
  }
  // Keep-all: takes room for one message of `bytes`, or returns false. Keep-last always has room.
  [[nodiscard]] bool Reserve(std::size_t bytes, std::size_t popped = 0) noexcept {
    if (!queue_.lossless()) return true;
    if (!HasRoom(popped)) return false;
    const std::size_t messages = size_ + reserved_messages_ + popped;
    if (messages > 0 && bytes_ + reserved_bytes_ + bytes > queue_.limit_bytes()) return false;
    ++reserved_messages_;
    reserved_bytes_ += bytes;
    return true;
  }
  void Cancel(std::size_t bytes) noexcept {
    if (!queue_.lossless()) return;
    --reserved_messages_;
    reserved_bytes_ -= bytes;
  }

  // Appends; a full keep-last ring gives its oldest message back, which the caller lets go of outside its lock.
  // `credit` is kept only where losing nothing depends on it.
  std::optional<QueuedMessage> Push(const Delivery& delivery) {
    std::optional<QueuedMessage> dropped;
    if (!queue_.lossless() && size_ >= queue_.depth()) dropped = Pop();
    if (size_ == slots_.size()) Grow();
    QueuedMessage& slot = slots_[(first_ + size_) & (slots_.size() - 1)];
    if (delivery.last) {
      slot.message = std::move(delivery.message);
    } else {
      slot.message = delivery.message;
    }
    slot.info = delivery.info;
    if (queue_.lossless()) slot.credit = delivery.credit;
    slot.bytes = delivery.bytes;
    bytes_ += delivery.bytes;
    ++size_;
    return dropped;
  }

  // The oldest message; the ring must not be empty.
  QueuedMessage Pop() {
    QueuedMessage message = std::move(slots_[first_]);
    first_ = (first_ + 1) & (slots_.size() - 1);
    --size_;
    bytes_ -= message.bytes;
    return message;
  }

 private:
  void Grow() {
    std::vector<QueuedMessage> grown(slots_.empty() ? 4 : slots_.size() * 2);
    for (std::size_t i = 0; i < size_; ++i) grown[i] = std::move(slots_[(first_ + i) & (slots_.size() - 1)]);
    slots_ = std::move(grown);
    first_ = 0;
  }

  Queue queue_;
  std::vector<QueuedMessage> slots_;  // As many as a power of two.
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::size_t bytes_ = 0;
  std::size_t reserved_messages_ = 0;
  std::size_t reserved_bytes_ = 0;
};

}  // namespace hgros
