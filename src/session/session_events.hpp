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

// Reports peers and channels to nodes of the session, on a thread that owns no socket, because a node may run inline.
//
// Thread safety: all functions. The ErrandThread that is passed must end before this object.
class SessionEvents {
 public:
  // `self` is this session's name in lines of the log.
  SessionEvents(std::string self, DataGraph& graph, std::shared_ptr<Log> log);

  void PublishPeer(ErrandThread& thread, PeerEvent event) noexcept;
  // The Report functions also write to the log. `closing`: this session is shutting down.
  void ReportCame(ErrandThread& thread, const PeerInfo& peer) noexcept;
  void ReportGone(ErrandThread& thread, const PeerInfo& peer, std::string_view reason, bool closing) noexcept;
  // `what` names the channel and both types. Returns the logged sentence.
  std::string ReportTypeMismatch(ErrandThread& thread, const PeerInfo& peer, std::string_view channel,
                                 std::string_view what) noexcept;
  // Call it when channels have changed. Cheap while no node subscribes to the event.
  void PublishChannels(ErrandThread& thread) noexcept;

 private:
  const std::string self_;
  DataGraph& graph_;
  const std::shared_ptr<Log> log_;
  const Publisher<PeerEvent> peers_;
  const Publisher<ChannelsChanged> channels_;
  std::atomic<bool> telling_channels_{false};
  std::uint64_t channel_changes_ = 0;  // Used only on the errand thread.
};

}  // namespace hgros
