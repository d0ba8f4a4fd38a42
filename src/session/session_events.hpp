#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "hgros/base/log.hpp"
#include "hgros/bridge/known_channel.hpp"
#include "hgros/clock/errand_thread.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/session/peer_event.hpp"

namespace hgros {

// Tells the session's own nodes about peers and channels, on a thread that owns no socket: a node may run inline.
//
// Thread safety: all functions. The thread that is passed ends before this does.
class SessionEvents {
 public:
  SessionEvents(DataGraph& graph, std::shared_ptr<Log> log);

  void PublishPeer(ErrandThread& thread, PeerEvent event) noexcept;
  // These are also written to the log. `closing`: the session itself leaves.
  void ReportCame(ErrandThread& thread, const PeerInfo& peer) noexcept;
  void ReportGone(ErrandThread& thread, const PeerInfo& peer, std::string_view reason, bool closing) noexcept;
  // `what` names the channel and both types. The sentence that was written.
  std::string ReportTypeMismatch(ErrandThread& thread, const PeerInfo& peer, std::string_view channel,
                                 std::string_view what) noexcept;
  // Channels have changed. May be called often: costs next to nothing while nobody listens.
  void PublishChannels(ErrandThread& thread) noexcept;

 private:
  DataGraph& graph_;
  const std::shared_ptr<Log> log_;
  const Publisher<PeerEvent> peers_;
  const Publisher<ChannelsChanged> channels_;
  std::atomic<bool> telling_channels_{false};
  std::uint64_t channel_changes_ = 0;  // The errand thread's.
};

}  // namespace hgros
