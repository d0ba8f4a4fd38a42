#include "session/peer_carriers.hpp"

#include <algorithm>
#include <utility>

namespace hgros {
namespace {

constexpr std::size_t IndexOf(CarrierKind kind) { return static_cast<std::size_t>(kind); }

constexpr CarrierKind Other(CarrierKind kind) {
  return kind == CarrierKind::kShm ? CarrierKind::kZmq : CarrierKind::kShm;
}

std::string NameOf(CarrierKind kind) { return kind == CarrierKind::kShm ? "shared memory" : "ZeroMQ"; }

}  // namespace

bool PeerCarriers::IsReached(const Peer& peer) {
  return std::ranges::any_of(peer.reached, [](const auto& info) { return info.has_value(); });
}

void PeerCarriers::Forget(SessionId id) {
  const auto found = peers_.find(id);
  if (found != peers_.end() && !found->second.expected && !found->second.taken && !IsReached(found->second)) {
    peers_.erase(found);
  }
}

bool PeerCarriers::Take(SessionId id, CarrierKind kind) {
  const std::scoped_lock lock(mutex_);
  Peer& peer = peers_[id];
  if (!peer.taken && (kind == CarrierKind::kShm || !peer.expected)) peer.taken = kind;
  return peer.taken == kind;
}

void PeerCarriers::Expect(SessionId id) {
  const std::scoped_lock lock(mutex_);
  peers_[id].expected = true;
}

void PeerCarriers::Unexpect(SessionId id) {
  const std::scoped_lock lock(mutex_);
  const auto found = peers_.find(id);
  if (found == peers_.end()) return;
  found->second.expected = false;
  Forget(id);
}

PeerCarriers::Without PeerCarriers::GiveUp(SessionId id) {
  const std::scoped_lock lock(mutex_);
  const auto found = peers_.find(id);
  if (found == peers_.end()) return Without::kNotNeeded;
  Peer& peer = found->second;
  if (!peer.expected || peer.taken || peer.reached[IndexOf(CarrierKind::kShm)]) return Without::kNotNeeded;
  peer.expected = false;
  const bool reached = IsReached(peer);
  Forget(id);
  return reached ? Without::kReached : Without::kUnreached;
}

void PeerCarriers::Came(PeerInfo info, CarrierKind kind) {
  info.carrier = NameOf(kind);
  const std::scoped_lock telling(telling_);
  bool first = false;
  {
    const std::scoped_lock lock(mutex_);
    Peer& peer = peers_[info.id];
    first = !IsReached(peer);
    peer.reached[IndexOf(kind)] = info;
  }
  if (first) {
    listener_.OnPeerCame(info);
  } else {
    log_.Write(LogLevel::kInfo, "Session " + info.id.ToString() + " (" + info.process + " on " + info.host +
                                    ") is reached through " + NameOf(kind) + " as well.");
  }
}

bool PeerCarriers::Gone(const PeerInfo& info, CarrierKind kind, std::string_view reason) {
  const std::scoped_lock telling(telling_);
  bool last = false;
  bool free = false;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = peers_.find(info.id);
    if (found == peers_.end()) return false;
    Peer& peer = found->second;
    peer.reached[IndexOf(kind)].reset();
    if (peer.taken == kind) {
      peer.taken.reset();
      free = peer.reached[IndexOf(Other(kind))].has_value();
    }
    last = !IsReached(peer);
    Forget(info.id);
  }
  if (last) {
    listener_.OnPeerGone(info, reason);
  } else {
    log_.Write(LogLevel::kInfo, "Session " + info.id.ToString() + " (" + info.process + " on " + info.host +
                                    ") is no longer reached through " + NameOf(kind) + ": " + std::string(reason) +
                                    ". " + NameOf(Other(kind)) + " remains.");
  }
  return free;
}

std::vector<PeerInfo> PeerCarriers::List() const {
  const std::scoped_lock lock(mutex_);
  std::vector<PeerInfo> list;
  for (const auto& [id, peer] : peers_) {
    const auto& taken = peer.taken ? peer.reached[IndexOf(*peer.taken)] : std::nullopt;
    if (taken) {
      list.push_back(*taken);
    } else if (const auto any = std::ranges::find_if(peer.reached, [](const auto& info) { return info.has_value(); });
               any != peer.reached.end()) {
      list.push_back(**any);
    }
  }
  return list;
}

}  // namespace hgros
