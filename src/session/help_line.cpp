#include "session/help_line.hpp"

#include <utility>

#include "session/service_host.hpp"

namespace hgros {

void HelpLine::Add(const std::shared_ptr<ServiceHost>& host) {
  const std::scoped_lock lock(mutex_);
  hosts_.push_back(host);
}

void HelpLine::Remove(const ServiceHost& host) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(hosts_, [&](const auto& entry) {
    const auto one = entry.lock();
    return !one || one.get() == &host;
  });
}

void HelpLine::Enter(Waiter& waiter) {
  const std::scoped_lock lock(mutex_);
  waiters_.push_back(&waiter);
  waiting_.fetch_add(1, std::memory_order_seq_cst);
}

void HelpLine::Leave(Waiter& waiter) {
  const std::scoped_lock lock(mutex_);
  std::erase(waiters_, &waiter);
  waiting_.fetch_sub(1, std::memory_order_seq_cst);
}

void HelpLine::Nudge() noexcept {
  if (waiting_.load(std::memory_order_seq_cst) == 0) return;
  const std::scoped_lock lock(mutex_);
  for (Waiter* const waiter : waiters_) waiter->Nudge();
}

bool HelpLine::RunOne() {
  std::vector<std::weak_ptr<ServiceHost>> hosts;
  {
    const std::scoped_lock lock(mutex_);
    hosts = hosts_;
  }
  for (const auto& entry : hosts) {
    if (const auto host = entry.lock(); host && host->Help()) return true;
  }
  return false;
}

}  // namespace hgros
