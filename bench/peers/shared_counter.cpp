#include "shared_counter.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <climits>

#include "stamp.hpp"

namespace hgros::bench {

void SharedCounter::Add(std::uint32_t count) {
  value_.fetch_add(count, std::memory_order_seq_cst);
  if (waiting_.load(std::memory_order_seq_cst) == 0) return;
  syscall(SYS_futex, &value_, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

bool SharedCounter::AwaitAtLeast(std::uint32_t value, std::int64_t limit_ns) {
  const std::int64_t deadline = NowNs() + limit_ns;
  while (Get() < value) {
    const std::int64_t left = deadline - NowNs();
    if (left <= 0) return false;
    const timespec patience{left / 1'000'000'000, left % 1'000'000'000};
    waiting_.fetch_add(1, std::memory_order_seq_cst);
    const std::uint32_t seen = value_.load(std::memory_order_seq_cst);
    if (seen < value) syscall(SYS_futex, &value_, FUTEX_WAIT, seen, &patience, nullptr, 0);
    waiting_.fetch_sub(1, std::memory_order_seq_cst);
  }
  return true;
}

}  // namespace hgros::bench
