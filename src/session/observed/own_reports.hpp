#pragma once

#include <string>
#include <vector>

#include "hgros/bridge/channel_directory.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "session/observed/snapshot_publisher.hpp"
#include "session/observed/trace_publisher.hpp"

namespace hgros {

// What a session tells other sessions about itself while they subscribe.
//
// Thread safety: all functions from any thread.
class OwnReports {
 public:
  struct Self {
    std::string name;
    MessageId publisher;
    TraceRecorder& recorder;
    std::shared_ptr<Log> log;
    std::shared_ptr<const HostClocks> clocks;
  };
  OwnReports(const Self& self, const SnapshotPublisher::Means& means)
      : snapshots_(self.publisher, self.log, self.clocks, means),
        traces_(self.name, self.recorder, self.publisher, self.log, self.clocks, means.later) {}

  void Join(NetworkBridge& bridge) {
    for (ChannelOutlet* outlet : Outlets()) outlet->Join(bridge);
  }
  void Detach() {
    for (ChannelOutlet* outlet : Outlets()) outlet->Detach();
  }
  void AddTo(std::vector<ChannelUse>& uses) const;

 private:
  [[nodiscard]] std::vector<ChannelOutlet*> Outlets() const {
    return {snapshots_.outlet().get(), traces_.outlet().get()};
  }

  SnapshotPublisher snapshots_;
  TracePublisher traces_;
};

}  // namespace hgros
