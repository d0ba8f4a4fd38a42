#include "session/peer_carriers.hpp"

#include <algorithm>
#include <utility>

namespace hgros {
namespace {

constexpr std::size_t IndexOf(CarrierKind kind) { return static_cast<std::size_t>(kind); }

constexpr CarrierKind Other(CarrierKind kind) {
  return kind == CarrierKind::kShm ? CarrierKind::kZmq : CarrierKind::kShm;
}

CarrierSet RuleOf(const CarrierRules& rules, std::string_view channel) {
  const auto rule = rules.find(channel);
  return rule == rules.end() ? CarrierSet{} : rule->second;
}

}  // namespace

std::string_view NameOf(CarrierKind kind) noexcept { return kind == CarrierKind::kShm ? "shared memory" : "ZeroMQ"; }

std::string NameOf(const PeerInfo& peer) {
  return "Session " + peer.id.ToString() + " (" + peer.process + ", process " + std::to_string(peer.pid) +
         (peer.host.empty() ? "" : " on " + peer.host) + ")";
}

bool PeerCarriers::IsReached(const Peer& peer) {
  return std::ranges::any_of(peer.reached, [](const auto& info) { return info.has_value(); });
}

CarrierSet PeerCarriers::Allowed(const Peer& peer, std::string_view channel) const {
  return RuleOf(rules_, channel).In(RuleOf(peer.rules, channel));
}

std::string PeerCarriers::Why(const Peer& peer, const PeerInfo& info, CarrierKind kind) const {
  if (kind == CarrierKind::kShm) return "same host";
  if (peer.expected) return "shared memory does not reach it yet";
  if (peer.found) return "no memory can be shared with it";
  if (info.host != host_) return "another host";
  return looks_ ? "not found on this host" : "sessions of this host are not looked for";
}

void PeerCarriers::Forget(SessionId id) {
  const auto entry = peers_.find(id);
  if (entry != peers_.end() && !entry->second.found && !entry->second.taken && !IsReached(entry->second)) {
    peers_.erase(entry);
  }
}

bool PeerCarriers::Take(SessionId id, std::string_view channel, CarrierKind kind) {
  const std::scoped_lock lock(mutex_);
  Peer& peer = peers_[id];
  if (const CarrierSet allowed = Allowed(peer, channel); !allowed.all()) return allowed.Has(kind);
  if (peer.moving) return kind == CarrierKind::kShm || !peer.moved.contains(channel);
  if (!peer.taken && (kind == CarrierKind::kShm || !peer.expected)) peer.taken = kind;
  return peer.taken == kind;
}

void PeerCarriers::Found(SessionId id, bool shares, CarrierRules rules) {
  const std::scoped_lock lock(mutex_);
  Peer& peer = peers_[id];
  peer.found = true;
  peer.expected = shares;
  peer.rules = std::move(rules);
}

void PeerCarriers::Lost(SessionId id) {
  const std::scoped_lock lock(mutex_);
  const auto entry = peers_.find(id);
  if (entry == peers_.end()) return;
  entry->second.found = false;
  entry->second.expected = false;
  entry->second.rules.clear();
  Forget(id);
}

bool PeerCarriers::SetRules(SessionId id, CarrierRules rules) {
  const std::scoped_lock lock(mutex_);
  const auto entry = peers_.find(id);
  if (entry == peers_.end() || !entry->second.found || entry->second.rules == rules) return false;
  entry->second.rules = std::move(rules);
  return true;
}

PeerCarriers::Without PeerCarriers::GiveUp(SessionId id) {
  const std::scoped_lock lock(mutex_);
  const auto entry = peers_.find(id);
  if (entry == peers_.end()) return Without::kNotNeeded;
  Peer& peer = entry->second;
  if (!peer.expected || peer.taken || peer.reached[IndexOf(CarrierKind::kShm)]) return Without::kNotNeeded;
  peer.expected = false;
  return IsReached(peer) ? Without::kReached : Without::kUnreached;
}

bool PeerCarriers::Came(PeerInfo info, CarrierKind kind) {
  info.carrier = NameOf(kind);
  const std::scoped_lock telling(telling_);
  bool first = false;
  bool carries = false;
  bool moves = false;
  {
    const std::scoped_lock lock(mutex_);
    Peer& peer = peers_[info.id];
    first = !IsReached(peer);
    info.why = Why(peer, info, kind);
    carries = peer.taken ? peer.taken == kind : kind == CarrierKind::kShm;
    peer.reached[IndexOf(kind)] = info;
    moves = kind == CarrierKind::kShm && peer.taken == CarrierKind::kZmq;
    peer.moving = peer.moving || moves;
  }
  if (moves) {
    log_.Write(LogLevel::kInfo, NameOf(info) + " is reached through shared memory now; its messages move there.");
  } else if (first) {
    listener_.OnPeerCame(info);
  } else {
    log_.Write(LogLevel::kInfo, NameOf(info) + " is reached through " + info.carrier + " as well; " +
                                    std::string(NameOf(carries ? kind : Other(kind))) + " carries its messages.");
  }
  return moves;
}

void PeerCarriers::Moved(SessionId id, std::string_view channel) {
  const std::scoped_lock lock(mutex_);
  const auto entry = peers_.find(id);
  if (entry != peers_.end() && entry->second.moving) entry->second.moved.emplace(channel);
}

bool PeerCarriers::FinishMove(SessionId id) {
  const std::scoped_lock lock(mutex_);
  const auto entry = peers_.find(id);
  if (entry == peers_.end() || !entry->second.moving) return false;
  entry->second.moving = false;
  entry->second.moved.clear();
  entry->second.taken = CarrierKind::kShm;
  return true;
}

bool PeerCarriers::Gone(const PeerInfo& info, CarrierKind kind, std::string_view reason) {
  const std::scoped_lock telling(telling_);
  bool last = false;
  bool free = false;
  {
    const std::scoped_lock lock(mutex_);
    const auto entry = peers_.find(info.id);
    if (entry == peers_.end()) return false;
    Peer& peer = entry->second;
    peer.reached[IndexOf(kind)].reset();
    if (std::exchange(peer.moving, false)) {  // What remains has them all.
      peer.moved.clear();
      peer.taken = Other(kind);
      free = true;
    } else if (peer.taken == kind) {
      peer.taken.reset();
      free = peer.reached[IndexOf(Other(kind))].has_value();
    }
    last = !IsReached(peer);
    Forget(info.id);
  }
  if (last) {
    listener_.OnPeerGone(info, reason);
  } else {
    log_.Write(LogLevel::kInfo, NameOf(info) + " is no longer reached through " + std::string(NameOf(kind)) + ": " +
                                    std::string(reason) + ". " + std::string(NameOf(Other(kind))) + " remains.");
  }
  return free;
}

std::vector<PeerInfo> PeerCarriers::List() const {
  const std::scoped_lock lock(mutex_);
  std::vector<PeerInfo> list;
  for (const auto& [id, peer] : peers_) {
    for (const CarrierKind kind : {peer.taken.value_or(CarrierKind::kShm), CarrierKind::kShm, CarrierKind::kZmq}) {
      const auto& reached = peer.reached[IndexOf(kind)];
      if (!reached) continue;
      list.push_back(*reached);
      list.back().why = Why(peer, *reached, kind);
      break;
    }
  }
  return list;
}

CarrierSet PeerCarriers::Allowed(SessionId id, std::string_view channel) const {
  const std::scoped_lock lock(mutex_);
  const auto entry = peers_.find(id);
  return entry == peers_.end() ? RuleOf(rules_, channel) : Allowed(entry->second, channel);
}

bool PeerCarriers::IsFound(SessionId id) const {
  const std::scoped_lock lock(mutex_);
  const auto entry = peers_.find(id);
  return entry != peers_.end() && entry->second.found;
}

bool PeerCarriers::IsReached(SessionId id, CarrierKind kind) const {
  const std::scoped_lock lock(mutex_);
  const auto entry = peers_.find(id);
  return entry != peers_.end() && entry->second.reached[IndexOf(kind)].has_value();
}

}  // namespace hgros
