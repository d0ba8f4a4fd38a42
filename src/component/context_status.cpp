// The status of a component: its state, its exceptions and late callbacks.
#include <utility>

#include "component/context_core.hpp"

namespace hgros {

void ContextCore::NoteException(const std::string& what) {
  {
    const std::scoped_lock lock(mutex_);
    ++status_.exceptions;
    status_.exception = what;
  }
  Report();
}

void ContextCore::NoteLate(const std::string& sentence) {
  log_.WriteLimited(LogLevel::kWarning, "late", sentence);
  {
    const std::scoped_lock lock(mutex_);
    ++status_.late;
  }
  Report();
}

ComponentStatus ContextCore::status() const {
  const std::scoped_lock lock(mutex_);
  return status_;
}

// Under a lock of its own, so that the last report has the latest status.
void ContextCore::Report() const {
  if (!means_.options.on_change) return;
  const std::scoped_lock lock(report_mutex_);
  means_.options.on_change(status());
}

void ContextCore::SetState(ComponentState state, std::string sentence) {
  {
    const std::scoped_lock lock(mutex_);
    if (status_.state >= ComponentState::kFinished) return;
    status_.state = state;
    status_.sentence = std::move(sentence);
  }
  Report();
}

void ContextCore::EndBySelf(ComponentState state, std::string sentence) {
  {
    const std::scoped_lock lock(mutex_);
    if (status_.state >= ComponentState::kFinished) return;
    status_.state = state;
    status_.sentence = sentence;
  }
  if (state == ComponentState::kFailed) log_.Write(LogLevel::kError, "It has failed: " + sentence);
  Report();
}

Transforms& ContextCore::UseTransforms() {
  bool undeclared = false;
  {
    const std::scoped_lock lock(mutex_);
    if (!constructed_) {
      description_.transforms = true;
    } else if (!description_.transforms) {
      undeclared = !std::exchange(status_.undeclared_transforms, true);
    }
  }
  if (undeclared) Report();
  return transforms_.Get();
}

}  // namespace hgros
