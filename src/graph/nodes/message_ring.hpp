#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "graph/nodes/queued_message.hpp"
#include "hgros/graph/queue.hpp"

namespace hgros {

// The bounded queue of one node. Its memory grows with use, block by block, up to the depth. It exceeds its limit only
// for messages that were accepted without a reservation (remote ones, within their credit).
//
// Thread safety: none; the node locks.
// Invariants: size() == queued; bytes() == sum of their bytes, which count only under a byte limit; keep-last: size()
// <= depth; no block but the last has room, and none but the last is empty; back_ is the last of the chain that begins
// at front_, or null.
class MessageRing {
 public:
  // Messages in the order of arrival. A popped block belongs to the caller, which may empty it without locks.
  class Block {
   public:
    static constexpr std::size_t kSize = 32;
    [[nodiscard]] std::span<QueuedMessage> messages() noexcept { return {slots_.data() + first_, end_ - first_}; }

   private:
    friend class MessageRing;
    std::array<QueuedMessage, kSize> slots_;
    std::size_t first_ = 0;
    std::size_t end_ = 0;
    std::unique_ptr<Block> next_;
  };

  explicit MessageRing(const Queue& queue) : queue_(queue) {}
  MessageRing(const MessageRing&) = delete;
  MessageRing& operator=(const MessageRing&) = delete;
  ~MessageRing() {
    while (front_) TakeFront();  // One by one: destroying a chain would recurse.
  }

  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

  // Whether there is room for one more message, ignoring bytes. `popped` messages were taken out but have not run.
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

  // Appends the message. A full keep-last ring returns its oldest message, which the caller destroys outside its
  // lock. `credit` is kept only in lossless queues.
  std::optional<QueuedMessage> Push(const Delivery& delivery) {
    std::optional<QueuedMessage> dropped;
    if (!queue_.lossless() && size_ >= queue_.depth()) dropped = Pop();
    if (back_ == nullptr || back_->end_ == Block::kSize) Append();
    Block& block = *back_;
    QueuedMessage& slot = block.slots_[block.end_++];
    if (delivery.last) {
      slot.message = std::move(delivery.message);
    } else {
      slot.message = delivery.message;
    }
    slot.info = delivery.info;
    if (queue_.lossless()) slot.credit = delivery.credit;
    slot.bytes = queue_.limit_bytes() == Queue::kUnlimitedBytes ? 0 : delivery.bytes;
    bytes_ += slot.bytes;
    ++size_;
    return dropped;
  }

  // Removes the oldest message; the ring must not be empty.
  QueuedMessage Pop() {
    Block& block = *front_;
    QueuedMessage message = std::move(block.slots_[block.first_++]);
    --size_;
    bytes_ -= message.bytes;
    if (block.first_ < block.end_) return message;
    if (&block == back_) {
      block.first_ = block.end_ = 0;  // Its first places are probably in the caches.
    } else {
      GiveBack(TakeFront());
    }
    return message;
  }

  // The oldest messages, a block of them, without touching one; the ring must not be empty. Only for queues without a
  // byte limit.
  std::unique_ptr<Block> PopBlock() {
    std::unique_ptr<Block> block = TakeFront();
    size_ -= block->messages().size();
    return block;
  }
  // Returns an emptied block for reuse.
  void GiveBack(std::unique_ptr<Block> block) noexcept {
    block->first_ = block->end_ = 0;
    if (!spare_) spare_ = std::move(block);
  }

 private:
  void Append() {
    std::unique_ptr<Block> block = spare_ ? std::move(spare_) : std::make_unique<Block>();
    Block* const appended = block.get();
    (back_ == nullptr ? front_ : back_->next_) = std::move(block);
    back_ = appended;
  }
  std::unique_ptr<Block> TakeFront() {
    std::unique_ptr<Block> block = std::move(front_);
    front_ = std::move(block->next_);
    if (!front_) back_ = nullptr;
    return block;
  }

  Queue queue_;
  std::unique_ptr<Block> front_;
  Block* back_ = nullptr;
  std::unique_ptr<Block> spare_;
  std::size_t size_ = 0;
  std::size_t bytes_ = 0;
  std::size_t reserved_messages_ = 0;
  std::size_t reserved_bytes_ = 0;
};

}  // namespace hgros
