#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

namespace hgros::epoch {

// Readers of a shared pointer never wait for writers. A reader marks itself as reading (one store), and a replaced
// object is kept until every reader that may still see it has left.
//
// Thread safety: everything here may be called from any thread.
// Invariants: a Guard covers every load of a protected pointer and every use of what it points to. A writer first
// replaces the pointer (sequentially consistent), then retires the old object.
// Argument: a reader that saw the old pointer had stored an epoch that it read before the replacement. So that epoch
// is not greater than the one in which the object was retired. An object is freed only when no reader shows an epoch
// up to that one.

struct alignas(64) Reader {
  std::atomic<std::uint64_t> active{0};  // 0: not reading
  std::atomic<bool> taken{false};
  Reader* next = nullptr;
  int depth = 0;
  bool late = false;  // Of a thread whose thread-local objects end: it gives the reader back after each use.
};

Reader& ThisThread() noexcept;
void GiveBack(Reader& reader) noexcept;
std::uint64_t Current() noexcept;

// Marks this thread as reading. Nests.
class Guard {
 public:
  Guard() noexcept : reader_(ThisThread()) {
    if (reader_.depth++ == 0) reader_.active.store(Current(), std::memory_order_seq_cst);
  }
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;
  ~Guard() {
    if (--reader_.depth != 0) return;
    reader_.active.store(0, std::memory_order_release);
    if (reader_.late) [[unlikely]]
      GiveBack(reader_);
  }

 private:
  Reader& reader_;
};

// Keeps `object` until no reader can see it, then releases it: now or in a later call.
void Retire(std::shared_ptr<const void> object);
void Collect();

}  // namespace hgros::epoch
