#include "component/component_guard.hpp"

#include <algorithm>

namespace hgros {
namespace {

constexpr std::chrono::seconds kSavePatience{1};

// "200.0 ms", or "1.8 s".
std::string TimeText(std::chrono::nanoseconds time) {
  const bool long_one = time >= std::chrono::seconds(1);
  const auto tenth = long_one ? std::chrono::milliseconds(100) : std::chrono::microseconds(100);
  const auto tenths = (time + tenth / 2) / tenth;
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + (long_one ? " s" : " ms");
}

}  // namespace

void ComponentGuard::NoteException(const char* what) noexcept {
  try {
    listener_(what);
  } catch (...) {  // NOLINT(bugprone-empty-catch): without memory for the text, the graph still counts it.
  }
}

void ComponentGuard::NoteSaving() noexcept {
  try {
    late_(
        "Saving it has taken more than 1 s so far. None of its callbacks begins until that ends, and no component of "
        "its process is saved, moved or constructed again. `hgros restart` starts the process again.");
  } catch (...) {  // NOLINT(bugprone-empty-catch): without memory for the text, nobody is told.
  }
}

void ComponentGuard::NoteLate(std::string_view node, std::chrono::nanoseconds time, bool returned) noexcept {
  try {
    late_("Callback of node \"" + std::string(node) + (returned ? "\" took " : "\" has run for ") + TimeText(time) +
          ". Its deadline is " + TimeText(deadline_) + ".");
  } catch (...) {  // NOLINT(bugprone-empty-catch): without memory for the text, the callback is not told of.
  }
}

void ComponentGuard::Enter(Pass& pass) {
  std::unique_lock lock(mutex_);
  const auto inside = [&](const Pass* other) { return other->thread == pass.thread; };
  const auto saved = [&] { return !alone_ && (closing_ == 0 || std::ranges::any_of(passes_, inside)); };
  if (!changed_.wait_for(lock, kSavePatience, saved) && !std::exchange(told_saving_, true)) {
    lock.unlock();
    NoteSaving();
    lock.lock();
  }
  changed_.wait(lock, saved);
  pass.number = ++begun_;
  passes_.push_back(&pass);
  if (deadline_.count() > 0) pass.began = std::chrono::steady_clock::now();
}

void ComponentGuard::Leave(const Pass& pass) noexcept {
  std::chrono::nanoseconds time{};
  if (deadline_.count() > 0) time = std::chrono::steady_clock::now() - pass.began;
  bool late = false;
  {
    const std::scoped_lock lock(mutex_);
    std::erase(passes_, &pass);
    late = time > deadline_ && !pass.told;
    if (passes_.empty()) {
      if (waiting_ > 0 && !alone_) alone_ = given_ = true;  // Before the next one begins.
      changed_.notify_all();
    }
  }
  if (late) NoteLate(pass.node, time, true);
}

void ComponentGuard::NoteHanging() {
  if (deadline_.count() == 0) return;
  std::vector<std::pair<std::string, std::chrono::nanoseconds>> late;
  {
    const auto now = std::chrono::steady_clock::now();
    const std::scoped_lock lock(mutex_);
    for (Pass* pass : passes_) {
      if (pass->told || now - pass->began <= deadline_) continue;
      pass->told = true;
      late.emplace_back(pass->node, now - pass->began);
    }
  }
  for (const auto& [node, time] : late) NoteLate(node, time, false);
}

bool ComponentGuard::TryAlone(std::chrono::steady_clock::time_point deadline, const std::function<void()>& save) {
  {
    std::unique_lock lock(mutex_);
    const auto may = [this] {
      return std::exchange(given_, false) || (passes_.empty() && !std::exchange(alone_, true));
    };
    const auto now = std::chrono::steady_clock::now();
    const std::uint64_t before = begun_;
    ++waiting_;
    bool alone = changed_.wait_until(lock, now + (deadline - now) / 2, may);
    if (!alone) {
      // Nobody is kept waiting in vain for a long one, which may itself wait for others.
      const int closes = std::ranges::all_of(passes_, [&](const Pass* one) { return one->number > before; }) ? 1 : 0;
      closing_ += closes;
      alone = changed_.wait_until(lock, deadline, may);
      closing_ -= closes;
    }
    --waiting_;
    if (!alone) {
      changed_.notify_all();
      return false;
    }
  }
  const auto open = [this] {
    const std::scoped_lock lock(mutex_);
    alone_ = told_saving_ = false;
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
