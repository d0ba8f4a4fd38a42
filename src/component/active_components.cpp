#include "component/active_components.hpp"

#include <algorithm>
#include <stop_token>
#include <system_error>
#include <utility>

#include "component/one_component.hpp"

namespace hgros {

ActiveComponents::~ActiveComponents() = default;

void ActiveComponents::Add(OneComponent& one) {
  const std::scoped_lock lock(mutex_);
  active_.push_back(&one);
}

bool ActiveComponents::Has(OneComponent& one) const {
  const std::scoped_lock lock(mutex_);
  return std::ranges::find(active_, &one) != active_.end();
}

bool ActiveComponents::Take(OneComponent& one) {
  std::unique_lock lock(mutex_);
  if (std::erase(active_, &one) > 0) return true;
  changed_.wait(lock, [&] { return !taken_.contains(&one); });
  return false;
}

void ActiveComponents::BeginEnd() noexcept {
  try {
    const std::scoped_lock lock(mutex_);
    ends_ = true;
    if (active_.empty() || watch_.joinable()) return;
    watch_ = std::jthread([this](const std::stop_token& stop) { Watch(stop); });
  } catch (const std::system_error&) {  // No thread is left. Then each waits for those behind it.
  }
}

bool ActiveComponents::ends() const {
  const std::scoped_lock lock(mutex_);
  return ends_;
}

std::string ActiveComponents::SetBusy(std::string name) {
  const std::scoped_lock lock(mutex_);
  return std::exchange(busy_, std::move(name));
}

void ActiveComponents::Watch(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (changed_.wait_for(lock, stop, kPatience, [] { return false; }) || stop.stop_requested()) return;
  const std::string busy = busy_;
  const bool others = !active_.empty();
  while (!active_.empty()) {
    OneComponent& one = *active_.back();
    taken_.insert(&one);
    active_.pop_back();
    try {
      threads_.emplace_back([this, &one] { Deactivate(one); });
    } catch (const std::system_error&) {  // One after the other, then.
      lock.unlock();
      Deactivate(one);
      lock.lock();
    }
  }
  lock.unlock();
  if (busy.empty()) return;
  say_(busy,
       std::string("It holds up the end of its process.") + (others ? " The others are deactivated meanwhile." : ""));
}

void ActiveComponents::Deactivate(OneComponent& one) {
  one.core.SetPlace(ContextCore::Place::kHeld);  // Its timers do nothing any more.
  one.CallDeactivate();
  const std::scoped_lock lock(mutex_);
  taken_.erase(&one);
  changed_.notify_all();
}

}  // namespace hgros
