#pragma once

#include <memory>

#include "hgros/base/export.hpp"

namespace hgros {

/// Knows whether this process is the one that created it. A forked child has none of its parent's threads, finds locks
/// in the state of that moment and shares its parent's sockets: it must not use any of them. Thread-safe.
class HGROS_EXPORT ForkGuard {
 public:
  ForkGuard();
  ~ForkGuard();
  ForkGuard(const ForkGuard&) = delete;
  ForkGuard& operator=(const ForkGuard&) = delete;

  /// One load where the kernel can wipe a page on fork (Linux 4.14), otherwise a system call.
  [[nodiscard]] bool IsChild() const noexcept;

 private:
  const volatile unsigned char* page_ = nullptr;  // Holds 1 here and 0 in a child.
  int pid_;
};

/// For destructors in a forked child: keeps `object` until the process ends instead of destroying it.
HGROS_EXPORT void LeaveToParent(std::shared_ptr<const void> object);

}  // namespace hgros
