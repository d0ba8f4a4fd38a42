#pragma once

#include <sys/types.h>

namespace hgros {

/// Knows whether this process is still the one that made it. A forked child shares sockets with its parent and must
/// not touch them. Thread-safe.
class ForkGuard {
 public:
  ForkGuard();
  ~ForkGuard();
  ForkGuard(const ForkGuard&) = delete;
  ForkGuard& operator=(const ForkGuard&) = delete;

  /// One load where the kernel can wipe a page on fork (Linux 4.14), otherwise a system call.
  [[nodiscard]] bool IsChild() const noexcept;

 private:
  const volatile unsigned char* page_ = nullptr;  // Holds 1 here and 0 in a child.
  pid_t pid_;
};

}  // namespace hgros
