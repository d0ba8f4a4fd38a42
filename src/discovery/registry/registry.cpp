#include "hgros/discovery/registry.hpp"

#include <utility>

#include "discovery/registry/registry_core.hpp"
#include "hgros/base/error.hpp"

namespace hgros {
namespace {

class Registry final : public Discovery {
 public:
  Registry(const RegistryOptions& options, DiscoveryListener& listener, Log& log)
      : core_(std::make_shared<discovery::RegistryCore>(options, listener, log)) {}
  ~Registry() override {
    if (core_->in_forked_child()) LeaveToParent(std::move(core_));
  }

  void Announce(const Announcement& own) override {
    if (core_->in_forked_child()) {
      throw Error("A forked child cannot announce its parent's session.", {}, "Open a registry of its own.");
    }
    core_->Announce(own);
  }
  std::vector<Announcement> List(const Which& which) const override {
    return core_->in_forked_child() ? std::vector<Announcement>() : core_->List(which);
  }

 private:
  std::shared_ptr<discovery::RegistryCore> core_;
};

}  // namespace

std::unique_ptr<Discovery> OpenRegistry(const RegistryOptions& options, DiscoveryListener& listener, Log& log) {
  return std::make_unique<Registry>(options, listener, log);
}

}  // namespace hgros
