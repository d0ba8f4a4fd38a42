#pragma once

namespace hgros {

/// Ends a poll(2) from another thread: an eventfd. Thread-safe.
class Waker {
 public:
  Waker();
  ~Waker();
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;

  /// Makes fd() readable until Clear().
  void Wake() noexcept;
  void Clear() noexcept;
  [[nodiscard]] int fd() const noexcept { return fd_; }

 private:
  int fd_;
};

}  // namespace hgros
