#include "services/waiting_callers.hpp"

#include <utility>

#include "services/service_host.hpp"

namespace hgros {

void WaitingCallers::Add(const std::shared_ptr<ServiceHost>& host) {
  const std::scoped_lock lock(mutex_);
  hosts_.push_back(host);
}

void WaitingCallers::Remove(const ServiceHost& host) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(hosts_, [&](const auto& entry) {
    const auto one = entry.lock();
    return !one || one.get() == &host;
  });
}

void WaitingCallers::Enter(Caller& caller) {
  const std::scoped_lock lock(mutex_);
  callers_.push_back(&caller);
  waiting_.fetch_add(1, std::memory_order_seq_cst);
}

void WaitingCallers::Leave(Caller& caller) {
  const std::scoped_lock lock(mutex_);
  std::erase(callers_, &caller);
  waiting_.fetch_sub(1, std::memory_order_seq_cst);
}

void WaitingCallers::Nudge() noexcept {
  if (waiting_.load(std::memory_order_seq_cst) == 0) return;
  const std::scoped_lock lock(mutex_);
  for (Caller* const caller : callers_) caller->Nudge();
}

bool WaitingCallers::RunOne() {
  std::vector<std::weak_ptr<ServiceHost>> hosts;
  {
    const std::scoped_lock lock(mutex_);
    hosts = hosts_;
  }
  for (const auto& entry : hosts) {
    if (const auto host = entry.lock(); host && host->RunOneRequest()) return true;
  }
  return false;
}

}  // namespace hgros
