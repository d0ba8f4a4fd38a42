#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <thread>
#include <vector>

namespace hgros::bench {

/// Writes the pattern that fills every message before its stamp is written.
inline void Fill(std::byte* bytes, std::size_t size_bytes) {
  for (std::size_t i = 0; i < size_bytes; ++i) bytes[i] = static_cast<std::byte>(i * 131 + 7);
}

/// A filled buffer.
inline std::vector<std::byte> FilledBuffer(std::size_t size_bytes) {
  std::vector<std::byte> bytes(size_bytes);
  Fill(bytes.data(), size_bytes);
  return bytes;
}

/// Messages that are passed on by (std or boost) shared pointer and return when nothing else refers to them.
template <class Pointer>
class PointerRing {
 public:
  /// `make` returns a filled message.
  template <class Make>
  PointerRing(std::size_t count, Make make) {
    for (std::size_t i = 0; i < count; ++i) messages_.push_back(make());
  }
  /// Returns the next free one. Waits for it, which slows down a fast sender.
  const Pointer& Take() {
    for (std::size_t tries = 0;; ++tries) {
      const Pointer& message = messages_[next_];
      next_ = (next_ + 1) % messages_.size();
      if (message.use_count() == 1) {
        std::atomic_thread_fence(std::memory_order_acquire);
        return message;
      }
      if (tries >= messages_.size()) std::this_thread::yield();
    }
  }

 private:
  std::vector<Pointer> messages_;
  std::size_t next_ = 0;
};

}  // namespace hgros::bench
