#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <vector>

namespace hgros::zmq {

/// The flags of endpoints that a poller sets when there is input.
///
/// A waiting thread may set a flag after the endpoint was removed. So flags are never freed: one that is returned is
/// lent again, and its next borrower may find it set although nothing has arrived.
///
/// Thread safety: all functions.
class InputFlags {
 public:
  /// The flag is set: there may be input already.
  [[nodiscard]] std::atomic<bool>& Lend() {
    const std::scoped_lock lock(mutex_);
    if (returned_.empty()) return flags_.emplace_back(true);
    std::atomic<bool>& flag = *returned_.back();
    returned_.pop_back();
    flag = true;
    return flag;
  }
  void Return(std::atomic<bool>& flag) {
    const std::scoped_lock lock(mutex_);
    returned_.push_back(&flag);
  }

 private:
  std::mutex mutex_;
  std::deque<std::atomic<bool>> flags_;
  std::vector<std::atomic<bool>*> returned_;
};

/// Returns the flag at its end.
class LentFlag {
 public:
  explicit LentFlag(InputFlags& owner) : owner_(owner), flag_(owner.Lend()) {}
  ~LentFlag() { owner_.Return(flag_); }
  LentFlag(const LentFlag&) = delete;
  LentFlag& operator=(const LentFlag&) = delete;
  [[nodiscard]] std::atomic<bool>& operator*() const noexcept { return flag_; }

 private:
  InputFlags& owner_;
  std::atomic<bool>& flag_;
};

}  // namespace hgros::zmq
