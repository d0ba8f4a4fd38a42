#include "hgros/services/service.hpp"

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
  if (const auto host = std::exchange(host_, nullptr)) host->End();
}

bool Service::active() const { return host_ && !host_->ended(); }

NodeSnapshot Service::stats() const { return host_ ? host_->stats() : NodeSnapshot(); }

}  // namespace hgros
