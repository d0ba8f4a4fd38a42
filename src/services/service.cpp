#include "hgros/services/service.hpp"

#include <utility>

#include "hgros/base/fork_guard.hpp"
#include "services/service_host.hpp"

namespace hgros {

Service& Service::operator=(Service&& other) noexcept {
  if (this != &other) {
    Reset();
    host_ = std::move(other.host_);
  }
  return *this;
}

Service::~Service() { Reset(); }

void Service::Reset() {
  auto host = std::exchange(host_, nullptr);
  if (!host) return;
  if (host->in_forked_child()) return LeaveToParent(std::move(host));
  host->End();
}

bool Service::active() const { return host_ && !host_->ended(); }

NodeSnapshot Service::stats() const { return host_ ? host_->stats() : NodeSnapshot(); }

}  // namespace hgros
