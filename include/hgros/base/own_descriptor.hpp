#pragma once

#include <functional>

#include "hgros/base/export.hpp"

namespace hgros {

/// A file descriptor of this process alone: closed with this object, and in every child that this process forks, before
/// fork() returns there. Locks and sockets that must end with their process are held in one: a child would keep them
/// alive.
///
/// Thread safety: each object belongs to one thread at a time, as an int would; forks may happen at any time.
/// Lifetime: in a forked child get() is -1, and the destructor does nothing.
class HGROS_EXPORT OwnDescriptor {
 public:
  OwnDescriptor() noexcept = default;
  /// Takes over what `open` returns, if it is not negative. No fork happens while `open` runs, so no child can inherit
  /// the descriptor unseen: it must be quick, and must neither fork nor make another OwnDescriptor. errno is as `open`
  /// left it.
  explicit OwnDescriptor(const std::function<int()>& open);
  OwnDescriptor(OwnDescriptor&& other) noexcept;
  OwnDescriptor& operator=(OwnDescriptor&& other) noexcept;
  OwnDescriptor(const OwnDescriptor&) = delete;
  OwnDescriptor& operator=(const OwnDescriptor&) = delete;
  ~OwnDescriptor();

  /// -1 if there is none.
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
