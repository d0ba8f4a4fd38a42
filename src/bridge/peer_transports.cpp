#include "bridge/peer_transports.hpp"

#include <algorithm>
#include <utility>

namespace hgros {

TransportSet PeerTransports::ReachedBy(const Peer& peer) {
  TransportSet set;
  for (const auto& [transport, info] : peer.reached) set.Add(transport);
  return set;
}

bool PeerTransports::IsMoving(const Peer& peer) {
  return std::ranges::any_of(peer.choices, [](const auto& entry) { return entry.second.from.has_value(); });
}

const PeerTransports::Peer* PeerTransports::Find(SessionId id) const {
  const auto entry = peers_.find(id);
  return entry == peers_.end() ? nullptr : &entry->second;
}

TransportSet PeerTransports::Allowed(const Peer& peer, std::string_view channel) const {
  const auto allowed_by = [&](const TransportRules& rules) {
    const auto rule = rules.find(channel);
    return rule == rules.end() ? transports_.all() : rule->second;
  };
  return allowed_by(rules_).In(allowed_by(peer.rules));
}

TransportIndex PeerTransports::Current(const Peer& peer) const {
  if (const auto entry = peer.choices.find(transports_.all()); entry != peer.choices.end()) {
    const Choice& choice = entry->second;
    const auto used = choice.from ? choice.from : choice.taken;
    if (used && peer.reached.contains(*used)) return *used;
  }
  return peer.reached.begin()->first;
}

std::string PeerTransports::Why(const Peer& peer, const PeerInfo& info, TransportIndex transport) const {
  if (transports_[transport].reach == TransportReach::kHost) return "same host";
  if (peer.found && !peer.partner) return "no channel of it is used on this host";
  if (!peer.expected.empty()) return transports_.NamesOf(peer.expected) + " does not reach it yet";
  if (peer.found) return "no transport of this host reaches it";
  if (info.host != self_.host) return "another host";
  return looks_ ? "not found on this host" : "discovery on this host is off";
}

void PeerTransports::Say(const PeerInfo& peer, std::string_view what, const std::string& how) {
  log_.WriteLimited(LogLevel::kDebug, "peer transport " + peer.id.ToString(),
                    "Session " + self_.name() + " " + std::string(what) + " session " + peer.name() + " " + how + ".");
}

void PeerTransports::Forget(SessionId id) {
  const Peer* const peer = Find(id);
  if (peer == nullptr || peer->found || !peer->reached.empty()) return;
  const bool taken =
      std::ranges::any_of(peer->choices, [](const auto& entry) { return entry.second.taken.has_value(); });
  if (!taken) peers_.erase(id);
}

bool PeerTransports::Claim(SessionId id, std::string_view channel, TransportIndex transport) {
  const std::scoped_lock lock(mutex_);
  Peer& peer = peers_[id];
  const TransportSet allowed = Allowed(peer, channel);
  if (!allowed.Has(transport)) return false;
  Choice& choice = peer.choices[allowed];
  if (choice.from) {
    return (choice.taken == transport && peer.move_is_open) ||
           (choice.from == transport && !choice.moved.contains(channel));
  }
  const bool cheaper = !peer.expected.Or(ReachedBy(peer)).In(allowed).CheaperThan(transport).empty();
  if (!choice.taken && !cheaper) choice.taken = transport;
  return choice.taken == transport;
}

void PeerTransports::Found(SessionId id, TransportSet expected, TransportRules rules) {
  const std::scoped_lock lock(mutex_);
  Peer& peer = peers_[id];
  peer.found = true;
  peer.partner = false;
  peer.expected = expected;
  peer.rules = std::move(rules);
}

bool PeerTransports::MakePartner(SessionId id, TransportSet expected) {
  const std::scoped_lock lock(mutex_);
  Peer* const peer = Find(id);
  if (peer == nullptr || !peer->found || peer->partner) return false;
  peer->partner = true;
  peer->expected = expected;
  return true;
}

bool PeerTransports::GiveUpStrangers() {
  bool free = false;
  const std::scoped_lock lock(mutex_);
  for (auto& [id, peer] : peers_) {
    if (!peer.found || peer.partner || peer.expected.empty()) continue;
    peer.expected = {};
    free = free || !peer.reached.empty();
  }
  return free;
}

void PeerTransports::Lost(SessionId id) {
  const std::scoped_lock lock(mutex_);
  Peer* const peer = Find(id);
  if (peer == nullptr) return;
  peer->found = false;
  peer->partner = false;
  peer->expected = {};
  peer->rules.clear();
  Forget(id);
}

bool PeerTransports::SetRules(SessionId id, TransportRules rules) {
  const std::scoped_lock lock(mutex_);
  Peer* const peer = Find(id);
  if (peer == nullptr || !peer->found || peer->rules == rules) return false;
  peer->rules = std::move(rules);
  return true;
}

PeerTransports::GivenUp PeerTransports::GiveUp(SessionId id) {
  const std::scoped_lock lock(mutex_);
  Peer* const peer = Find(id);
  if (peer == nullptr) return {};
  GivenUp given_up;
  given_up.missing = peer->expected.Without(ReachedBy(*peer));
  peer->expected = peer->expected.Without(given_up.missing);
  const auto choice = peer->choices.find(transports_.all());
  const bool taken = choice != peer->choices.end() && choice->second.taken;
  given_up.matters = peer->partner && !taken && ReachedBy(*peer).In(transports_.on_host()).empty();
  given_up.reached_by = ReachedBy(*peer).cheapest();
  return given_up;
}

std::optional<PeerTransports::MoveNumber> PeerTransports::StartMove(Peer& peer) {
  if (peer.move) return std::nullopt;
  for (auto& [allowed, choice] : peer.choices) {
    const auto cheapest = ReachedBy(peer).In(allowed).cheapest();
    if (!choice.taken || !cheapest || *cheapest >= *choice.taken) continue;
    choice.from = std::exchange(choice.taken, cheapest);
    if (!peer.move) peer.move = ++last_move_;
    peer.move_is_open = false;
  }
  return peer.move;
}

std::optional<PeerTransports::MoveNumber> PeerTransports::Came(PeerInfo info, TransportIndex transport) {
  info.transport = transports_.name(transport);
  const std::scoped_lock telling(telling_);
  bool first = false;
  std::optional<MoveNumber> move;
  std::string current;
  {
    const std::scoped_lock lock(mutex_);
    Peer& peer = peers_[info.id];
    first = peer.reached.empty();
    peer.reached[transport] = info;
    info.why = Why(peer, info, transport);
    peer.reached[transport].why = info.why;
    move = StartMove(peer);
    current = transports_.name(Current(peer));
  }
  if (move) {
    Say(info, "now reaches", "through " + info.transport + ", and its messages move there");
  }
  if (first) {
    listener_.OnPeerCame(info);
  } else if (!move) {
    Say(info, "reaches", "through " + info.transport + " as well; " + current + " carries its messages");
  }
  return move;
}

void PeerTransports::OpenMove(SessionId id) {
  const std::scoped_lock lock(mutex_);
  if (Peer* const peer = Find(id)) peer->move_is_open = true;
}

std::optional<MoveWay> PeerTransports::MoveOf(SessionId id, std::string_view channel) const {
  const std::scoped_lock lock(mutex_);
  const Peer* const peer = Find(id);
  if (peer == nullptr) return std::nullopt;
  const auto choice = peer->choices.find(Allowed(*peer, channel));
  if (choice == peer->choices.end() || !choice->second.from) return std::nullopt;
  return MoveWay{*choice->second.from, *choice->second.taken};
}

std::vector<SessionId> PeerTransports::Moving() const {
  const std::scoped_lock lock(mutex_);
  std::vector<SessionId> moving;
  for (const auto& [id, peer] : peers_) {
    if (IsMoving(peer)) moving.push_back(id);
  }
  return moving;
}

void PeerTransports::Moved(SessionId id, std::string_view channel) {
  const std::scoped_lock lock(mutex_);
  Peer* const peer = Find(id);
  if (peer == nullptr) return;
  const auto choice = peer->choices.find(Allowed(*peer, channel));
  if (choice != peer->choices.end() && choice->second.from) choice->second.moved.emplace(channel);
}

bool PeerTransports::FinishMove(SessionId id, MoveNumber number) {
  const std::scoped_lock lock(mutex_);
  Peer* const peer = Find(id);
  if (peer == nullptr || peer->move != number || !IsMoving(*peer)) return false;
  for (auto& [allowed, choice] : peer->choices) {
    choice.from.reset();
    choice.moved.clear();
  }
  return true;
}

std::optional<PeerTransports::MoveNumber> PeerTransports::NextMove(SessionId id) {
  const std::scoped_lock lock(mutex_);
  Peer* const peer = Find(id);
  if (peer == nullptr || IsMoving(*peer)) return std::nullopt;
  peer->move.reset();
  return StartMove(*peer);
}

bool PeerTransports::Gone(const PeerInfo& info, TransportIndex transport, std::string_view reason) {
  const std::scoped_lock telling(telling_);
  bool last = false;
  bool free = false;
  std::string remains;
  {
    const std::scoped_lock lock(mutex_);
    Peer* const peer = Find(info.id);
    if (peer == nullptr) return false;
    peer->reached.erase(transport);
    for (auto& [allowed, choice] : peer->choices) {
      if (choice.from && (choice.from == transport || choice.taken == transport)) {  // The other one has all channels.
        if (choice.taken == transport) choice.taken = choice.from;
        choice.from.reset();
        choice.moved.clear();
        free = true;
      } else if (choice.taken == transport) {
        choice.taken.reset();
        free = free || !ReachedBy(*peer).In(allowed).empty();
      }
    }
    last = peer->reached.empty();
    if (!last) remains = transports_.name(Current(*peer));
    Forget(info.id);
  }
  if (last) {
    listener_.OnPeerGone(info, reason);
  } else {
    Say(info, "no longer reaches",
        "through " + transports_.name(transport) + ": " + std::string(reason) + ". " + remains + " remains");
  }
  return free;
}

std::vector<PeerInfo> PeerTransports::List() const {
  const std::scoped_lock lock(mutex_);
  std::vector<PeerInfo> list;
  for (const auto& [id, peer] : peers_) {
    if (peer.reached.empty()) continue;
    const TransportIndex current = Current(peer);
    list.push_back(peer.reached.at(current));
    list.back().why = Why(peer, list.back(), current);
  }
  return list;
}

TransportSet PeerTransports::Allowed(SessionId id, std::string_view channel) const {
  const std::scoped_lock lock(mutex_);
  const Peer* const peer = Find(id);
  return peer == nullptr ? Allowed(Peer{}, channel) : Allowed(*peer, channel);
}

TransportSet PeerTransports::ReachedBy(SessionId id) const {
  const std::scoped_lock lock(mutex_);
  const Peer* const peer = Find(id);
  return peer == nullptr ? TransportSet() : ReachedBy(*peer);
}

bool PeerTransports::IsPartner(SessionId id) const {
  const std::scoped_lock lock(mutex_);
  const Peer* const peer = Find(id);
  return peer != nullptr && peer->partner;
}

std::string PeerTransports::NameOf(SessionId id) const {
  const std::scoped_lock lock(mutex_);
  const Peer* const peer = Find(id);
  return peer == nullptr || peer->reached.empty() ? id.ToString() : peer->reached.begin()->second.name();
}

bool PeerTransports::IsFound(SessionId id) const {
  const std::scoped_lock lock(mutex_);
  const Peer* const peer = Find(id);
  return peer != nullptr && peer->found;
}

}  // namespace hgros
