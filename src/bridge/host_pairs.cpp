#include "bridge/host_pairs.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/session_name.hpp"
#include "hgros/discovery/peer_process.hpp"

namespace hgros {
namespace {

// An errand that is this late was held up by a process that was stopped, or by a machine without time for it.
constexpr auto kLate = std::chrono::milliseconds(500);

}  // namespace

HostPairs::HostPairs(Means means) : means_(std::move(means)) {}

TransportSet HostPairs::Expected(const Announcement& peer) const {
  TransportSet expected;
  for (TransportIndex i = 0; i < means_.transports.size(); ++i) {
    const bool here = means_.transports.on_host().Has(i) && means_.open[i] != nullptr;
    if (here && peer.places.contains(means_.transports[i].key)) expected.Add(i);
  }
  return IsOfThisBoot(peer) ? expected : TransportSet();
}

HostPairs::Use HostPairs::UseOf(SessionId session, const ChannelAnnouncement& channel) const {
  return {session, channel.publishes, channel.subscribes, means_.transports.SetOf(channel.transports)};
}

// A channel that may not use a transport of this host needs no pair.
bool HostPairs::Exchange(const ChannelAnnouncement& ours, const Use& theirs) const {
  const bool used = (ours.publishes && theirs.subscribes) || (ours.subscribes && theirs.publishes);
  return used &&
         !means_.transports.SetOf(ours.transports).In(theirs.transports).In(means_.transports.on_host()).empty();
}

void HostPairs::Remember(const Announcement& stranger) {
  std::vector<std::pair<std::string, Use>> uses;
  uses.reserve(stranger.channels.size());
  for (const ChannelAnnouncement& one : stranger.channels) uses.emplace_back(one.channel, UseOf(stranger.session, one));
  strangers_.Remember(stranger.session, std::move(uses));
}

void HostPairs::Found(const Announcement& peer, TransportRules rules) {
  means_.peers.Found(peer.session, Expected(peer), std::move(rules));
  Changed(peer);
  if (means_.peers.IsPartner(peer.session) || giving_up_.exchange(true)) return;
  means_.options.later(kHostPatience, [this] {
    giving_up_ = false;
    if (means_.peers.GiveUpStrangers()) means_.ask_again();
  });
}

// This reads our announcement after the peer's was stored, and OwnChanged() reads the peer's after ours was stored. So
// one of the two sees both.
void HostPairs::Changed(const Announcement& peer) {
  if (means_.peers.IsPartner(peer.session)) return;
  Remember(peer);
  if (Exchanges(peer)) Connect(peer);
}

bool HostPairs::Exchanges(const Announcement& peer) const {
  return std::ranges::any_of(peer.channels, [&](const ChannelAnnouncement& theirs) {
    const auto ours = means_.announcer.OwnChannel(theirs.channel);
    return ours && Exchange(*ours, UseOf(peer.session, theirs));
  });
}

void HostPairs::OwnChanged(const std::string& channel) {
  const auto ours = means_.announcer.OwnChannel(channel);
  if (!ours) return;
  std::vector<SessionId> found;
  for (const Use& theirs : strangers_.UsesOf(channel)) {
    if (Exchange(*ours, theirs)) found.push_back(theirs.session);
  }
  if (found.empty()) return;
  const auto partners = means_.announcer.PeersOnHost([&](const Announcement& peer) {
    return std::ranges::find(found, peer.session) != found.end() && !means_.peers.IsPartner(peer.session);
  });
  for (const Announcement& peer : partners) Connect(peer);
}

// The session with the smaller id connects; the other one decides in the same way, and waits.
void HostPairs::Connect(const Announcement& peer) {
  const TransportSet expected = Expected(peer);
  if (!means_.peers.MakePartner(peer.session, expected)) return;
  strangers_.Forget(peer.session);
  if (expected.empty()) return;
  Await(peer.session);
  if (means_.options.zmq.session.value > peer.session.value) return;
  for (TransportIndex i = 0; i < means_.transports.size(); ++i) {
    if (expected.Has(i)) means_.open[i]->AddPeer(peer.places.at(means_.transports[i].key));
  }
  // It may have been lost, on another thread, before it was added.
  if (!means_.peers.IsPartner(peer.session)) Lost(peer);
}

void HostPairs::Lost(const Announcement& last) {
  strangers_.Forget(last.session);
  for (TransportIndex i = 0; i < means_.transports.size(); ++i) {
    const auto place = last.places.find(means_.transports[i].key);
    if (means_.open[i] != nullptr && place != last.places.end()) means_.open[i]->RemovePeer(place->second);
  }
}

void HostPairs::Later(std::chrono::nanoseconds delay, std::function<void()> errand) {
  const auto due = std::chrono::steady_clock::now() + delay;
  means_.options.later(delay, [this, delay, due, errand = std::move(errand)]() mutable {
    const bool late = std::chrono::steady_clock::now() > due + kLate;
    late ? means_.options.later(delay, std::move(errand)) : errand();
  });
}

// A session may be on this host and still unreachable, for example in a container.
void HostPairs::Await(SessionId peer) {
  Later(kHostPatience, [this, peer] { GiveUp(peer); });
}

void HostPairs::GiveUp(SessionId peer) {
  const PeerTransports::GivenUp given_up = means_.peers.GiveUp(peer);
  if (given_up.missing.empty()) return;
  if (given_up.matters) ReportIfUnreached(peer, given_up, false);
  means_.ask_again();
}

void HostPairs::ReportIfUnreached(SessionId peer, const PeerTransports::GivenUp& given_up, bool finally) {
  const auto found = means_.announcer.PeersOnHost([peer](const Announcement& one) { return one.session == peer; });
  if (found.empty() || !means_.peers.IsPartner(peer)) return;
  if (!means_.peers.ReachedBy(peer).In(means_.transports.on_host()).empty()) return;
  const Announcement& there = found.front();
  // What they exchanged may have ended before the other one, which connects, knew of it.
  if (!Exchanges(there)) return;
  // A session that has just ended is still found for a moment, and a busy machine needs time. So causes that may pass
  // are reported only if they last.
  std::string cause = ObstacleOf(there);
  if (cause.empty() && !given_up.reached_by && !finally) {
    Later(kLongPatience, [this, peer, given_up] { ReportIfUnreached(peer, given_up, true); });
    return;
  }
  if (cause.empty()) cause = Obstacle(there, given_up.missing);
  if (cause.empty()) cause = "no cause was found, and the attempts go on";
  const Announcement own = means_.announcer.own();
  means_.log.WriteLimited(
      LogLevel::kWarning, "not reached on this host",
      "Session " + SessionName(own.process, own.pid) + " found session " + SessionName(there.process, there.pid) +
          " on this host, but " + means_.transports.NamesOf(given_up.missing) + " does not reach it: " + cause + ". " +
          (given_up.reached_by ? means_.transports.name(*given_up.reached_by) + " carries its messages."
                               : "No endpoint leads to it either: nothing passes between the two."));
}

std::string HostPairs::Obstacle(const Announcement& peer, TransportSet missing) const {
  std::string obstacle;
  for (TransportIndex i = 0; obstacle.empty() && i < means_.transports.size(); ++i) {
    const auto place = peer.places.find(means_.transports[i].key);
    if (!missing.Has(i) || means_.open[i] == nullptr || place == peer.places.end()) continue;
    obstacle = means_.open[i]->Obstacle(peer.session, place->second);
  }
  return obstacle;
}

}  // namespace hgros
