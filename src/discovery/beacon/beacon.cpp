#include "hgros/discovery/beacon.hpp"

#include <utility>

#include "discovery/beacon/beacon_core.hpp"
#include "hgros/base/error.hpp"

namespace hgros {
namespace {

class Beacon final : public Discovery {
 public:
  Beacon(const BeaconOptions& options, DiscoveryListener& listener, Log& log)
      : core_(std::make_shared<discovery::BeaconCore>(options, listener, log)) {}
  ~Beacon() override {
    if (core_->in_forked_child()) LeaveToParent(std::move(core_));
  }

  void Announce(const Announcement& own) override {
    if (core_->in_forked_child()) {
      throw Error("A forked child cannot announce its parent's session.", {}, "Open a beacon of its own.");
    }
    core_->Announce(own);
  }
  std::vector<Announcement> List(const Which& which) const override {
    return core_->in_forked_child() ? std::vector<Announcement>() : core_->List(which);
  }

 private:
  std::shared_ptr<discovery::BeaconCore> core_;
};

}  // namespace

std::unique_ptr<Discovery> OpenBeacon(const BeaconOptions& options, DiscoveryListener& listener, Log& log) {
  return std::make_unique<Beacon>(options, listener, log);
}

}  // namespace hgros
