#include "component/component_guard.hpp"

namespace hgros {

void ComponentGuard::Note(const char* what) noexcept {
  try {
    listener_(what);
  } catch (...) {  // NOLINT(bugprone-empty-catch): without memory for the text, the graph still counts it.
  }
}

void ComponentGuard::Enter() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !alone_; });
  ++running_;
}

void ComponentGuard::Leave() {
  const std::scoped_lock lock(mutex_);
  if (--running_ == 0) changed_.notify_all();
}

bool ComponentGuard::TryAlone(std::chrono::steady_clock::time_point deadline, const std::function<void()>& save) {
  {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_until(lock, deadline, [this] { return running_ == 0 && !alone_; })) return false;
    alone_ = true;
  }
  const auto open = [this] {
    const std::scoped_lock lock(mutex_);
    alone_ = false;
    changed_.notify_all();
  };
  try {
    save();
  } catch (...) {
    open();
    throw;
  }
  open();
  return true;
}

}  // namespace hgros
