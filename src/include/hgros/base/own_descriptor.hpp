#pragma once

#include <functional>

#include "hgros/base/export.hpp"

namespace hgros {

/// A file descriptor of this process alone: closed with this object, and in every forked child before fork() returns
/// there. For locks and sockets that must end with their process: a child would keep them alive.
///
/// Thread safety: each object belongs to one thread at a time; other threads may fork at any time.
/// Lifetime: in a forked child get() is -1, and the destructor does nothing.
class HGROS_EXPORT OwnDescriptor {
 public:
  OwnDescriptor() noexcept = default;
  /// Owns the descriptor that `open` returns, unless it is negative. No fork happens while `open` runs, so a child
  /// never inherits the descriptor. `open` must be quick, must not fork and must not create another OwnDescriptor.
  /// errno is as `open` left it.
  explicit OwnDescriptor(const std::function<int()>& open);
  OwnDescriptor(OwnDescriptor&& other) noexcept;
  OwnDescriptor& operator=(OwnDescriptor&& other) noexcept;
  OwnDescriptor(const OwnDescriptor&) = delete;
  OwnDescriptor& operator=(const OwnDescriptor&) = delete;
  ~OwnDescriptor();

  /// -1 if empty.
  [[nodiscard]] int get() const noexcept { return fd_; }
  explicit operator bool() const noexcept { return fd_ >= 0; }

 private:
  friend struct OwnDescriptors;
  void Close() noexcept;
  void TakeFrom(OwnDescriptor& other) noexcept;

  int fd_ = -1;
  OwnDescriptor* before_ = nullptr;  // The list of all that a child closes; guarded by the lock that fork takes.
  OwnDescriptor* after_ = nullptr;
};

}  // namespace hgros
