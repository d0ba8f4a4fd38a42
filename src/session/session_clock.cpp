// The part of SessionCore that follows a published clock and the clocks of other hosts.
#include <memory>
#include <vector>

#include "hgros/session/clock_publisher.hpp"
#include "session/clock_follower.hpp"
#include "session/session_core.hpp"

namespace hgros {

std::vector<Subscription> SessionCore::FollowClock() {
  std::vector<Subscription> subscriptions;
  if (!followed_clock_) return subscriptions;
  const auto follower = std::make_shared<ClockFollower>(followed_clock_, log_);
  NodeOptions options{"hgros/clock", {}, Executor::Inline()};
  const TypeInfo& type = TypeOf<SimulatedTime>();
  subscriptions.push_back(
      SubscribeAny(graph_->Open(kClockChannel, type, CallSite::Current()), type, Invoke::kSerial,
                   EraseCallback<SimulatedTime>([follower](const SimulatedTime& time, const MessageInfo& info) {
                     follower->OnTime(time, info);
                   }),
                   options));
  options.name = "hgros/clock peers";
  subscriptions.push_back(graph_->FromGraph<PeerEvent>(
      kPeerEventsChannel, Invoke::kSerial, [follower](const PeerEvent& event) { follower->OnPeer(event); }, options));
  return subscriptions;
}

std::optional<ClockOffset> SessionCore::OffsetTo(SessionId peer) const {
  if (peer == id_) return ClockOffset{};
  {
    const std::scoped_lock lock(mutex_);
    if (bridge_ && bridge_->IsOnThisHost(peer)) return ClockOffset{};
  }
  return host_clocks_->OffsetTo(peer);
}

}  // namespace hgros
