#include "hgros/base/fork_guard.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <utility>

namespace hgros {
namespace {

constexpr std::size_t kPageBytes = 4096;

// The objects that a child keeps. The list has no lock: the fork may have happened while another thread held it.
struct Left {
  std::shared_ptr<const void> object;
  Left* next;
};
std::atomic<Left*> left_to_parent{nullptr};

}  // namespace

ForkGuard::ForkGuard() : pid_(getpid()) {
  void* page = mmap(nullptr, kPageBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return;
  if (madvise(page, kPageBytes, MADV_WIPEONFORK) != 0) {
    munmap(page, kPageBytes);
    return;
  }
  *static_cast<unsigned char*>(page) = 1;
  page_ = static_cast<unsigned char*>(page);
}

ForkGuard::~ForkGuard() {
  if (page_ != nullptr) munmap(const_cast<unsigned char*>(page_), kPageBytes);
}

bool ForkGuard::IsChild() const noexcept {
  if (page_ != nullptr) return *page_ == 0;
  return getpid() != pid_;
}

void LeaveToParent(std::shared_ptr<const void> object) {
  auto* left = new Left{std::move(object), left_to_parent.load(std::memory_order_relaxed)};
  while (!left_to_parent.compare_exchange_weak(left->next, left, std::memory_order_relaxed)) {
  }
}

}  // namespace hgros
