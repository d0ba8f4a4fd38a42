#include "hgros/graph/helping.hpp"

#include <utility>

#include "graph/tbb_executor.hpp"

namespace hgros {
namespace {

thread_local Helping* here = nullptr;     // Takes what becomes ready.
thread_local Helping* present = nullptr;  // Of this thread, whether wanted or not, until it runs what it took.

}  // namespace

Helping::Helping(bool wanted) noexcept : outer_(std::exchange(present, this)) {
  if (wanted && here == nullptr) here = this;
}

Helping::~Helping() {
  if (here == this) here = nullptr;
  if (present == this) present = outer_;
  PassOn();
}

Helping::Invited::Invited() noexcept : one_(here == nullptr ? present : nullptr) {
  if (one_ != nullptr) here = one_;
}

Helping::Invited::~Invited() {
  if (one_ != nullptr && here == one_) here = nullptr;
}

bool Helping::Keep(const std::shared_ptr<Activation>& ready,
                   const std::shared_ptr<std::atomic<bool>>& helped) noexcept {
  if (here == nullptr || here->kept_ || helped->exchange(true, std::memory_order_acquire)) return false;
  here->kept_ = ready;
  here->helped_ = helped;
  return true;
}

void Helping::PassOn() noexcept {
  if (!kept_) return;
  const auto kept = std::exchange(kept_, nullptr);
  helped_->store(false, std::memory_order_release);
  kept->PassOn();
}

void Helping::Run() noexcept {
  if (here == this) here = nullptr;  // What the callbacks publish goes to the workers.
  if (present == this) present = nullptr;
  if (!kept_) return;
  std::exchange(kept_, nullptr)->Activate();
  helped_->store(false, std::memory_order_release);
}

}  // namespace hgros
