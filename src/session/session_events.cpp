#include "session/session_events.hpp"

#include <chrono>
#include <utility>

namespace hgros {
namespace {

// A burst of changes, as when a program starts, becomes one event.
constexpr auto kTimeToGather = std::chrono::milliseconds(20);

}  // namespace

SessionEvents::SessionEvents(std::string self, DataGraph& graph, std::shared_ptr<Log> log)
    : self_(std::move(self)),
      graph_(graph),
      log_(std::move(log)),
      peers_(graph.Advertise<PeerEvent>(kPeerEventsChannel)),
      channels_(graph.Advertise<ChannelsChanged>(kChannelEventsChannel)) {}

void SessionEvents::PublishPeer(ErrandThread& thread, PeerEvent event) noexcept {
  thread.Post([this, shared = std::make_shared<const PeerEvent>(std::move(event))] {
    if (peers_(shared) == PublishStatus::kFull) {
      log_->WriteLimited(LogLevel::kWarning, "peer events", "A peer event was not delivered: a lossless node is full.");
    }
  });
}

void SessionEvents::ReportCame(ErrandThread& thread, const PeerInfo& peer) noexcept {
  // The socket name of a shared memory pair tells people nothing, so it is not logged.
  const bool at = !peer.endpoint.empty() && peer.endpoint.find("://") != std::string::npos;
  log_->WriteLimited(LogLevel::kDebug, "peer " + peer.id.ToString(),
                     "Session " + self_ + " reaches session " + peer.name() + " through " + peer.transport +
                         (at ? " at " + peer.endpoint : std::string()) + ": " + peer.why + ".");
  PublishPeer(thread, {PeerEvent::Kind::kCame, peer, {}, {}});
}

void SessionEvents::ReportGone(ErrandThread& thread, const PeerInfo& peer, std::string_view reason,
                               bool closing) noexcept {
  log_->WriteLimited(LogLevel::kDebug, "peer " + peer.id.ToString(),
                     "Session " + self_ + " no longer reaches session " + peer.name() +
                         (closing ? ": " : ", which is gone: ") + std::string(reason) + ".");
  PublishPeer(thread, {PeerEvent::Kind::kGone, peer, {}, std::string(reason)});
}

std::string SessionEvents::ReportTypeMismatch(ErrandThread& thread, const PeerInfo& peer, std::string_view channel,
                                              std::string_view what) noexcept {
  std::string sentence = std::string(what) + (what.ends_with('.') ? "" : ".") +
                         " Use one type in both programs, or give one of the two another channel.";
  log_->WriteLimited(LogLevel::kError, "type mismatch " + std::string(channel), sentence);
  PublishPeer(thread, {PeerEvent::Kind::kTypeMismatch, peer, std::string(channel), sentence});
  return sentence;
}

void SessionEvents::PublishChannels(ErrandThread& thread) noexcept {
  if (graph_.NodeCount(kChannelEventsChannel) == 0 || telling_channels_.exchange(true)) return;
  thread.PostIn(kTimeToGather, [this] {
    telling_channels_ = false;
    (void)channels_(std::make_unique<ChannelsChanged>(ChannelsChanged{++channel_changes_}));
  });
}

}  // namespace hgros
