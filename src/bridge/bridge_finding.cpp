// Finds other sessions of the host and the network, and lets them find this one.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "bridge/bridge_core.hpp"
#include "hgros/base/session_name.hpp"
#include "hgros/discovery/beacon.hpp"
#include "hgros/discovery/registry.hpp"

namespace hgros {
namespace {

// If rules leave two sessions no transport, this is reported only after every transport has had time to reach the
// other one.
constexpr auto kTimeToBeReached = std::chrono::seconds(3);

std::string NameOf(const Announcement& peer) { return SessionName(peer.session, peer.process, peer.pid); }

PeerInfo InfoOf(const Announcement& peer) {
  PeerInfo info;
  info.id = peer.session;
  info.process = peer.process;
  info.host = peer.host;
  info.pid = peer.pid;
  return info;
}

}  // namespace

void BridgeCore::OpenOnHost() {
  for (TransportIndex i = 0; i < transports_.size(); ++i) {
    if (!transports_.on_host().Has(i) || !transports_[i].make || !transports_[i].opens_at_start) continue;
    try {
      Open(i);
    } catch (const std::exception& error) {
      log_.Write(LogLevel::kWarning,
                 "Sessions of this host are not reached through " + transports_.name(i) + ". " + error.what());
    }
  }
}

void BridgeCore::LookOnHost() {
  try {
    announcer_.UseRegistry(OpenRegistry(*options_.registry, *this, log_));
  } catch (const std::exception& error) {
    log_.Write(LogLevel::kWarning, std::string("Sessions of this host are not found. ") + error.what());
  }
}

TransportRules BridgeCore::RulesOf(const Announcement& peer) {
  TransportRules rules;
  for (const ChannelAnnouncement& channel : peer.channels) {
    const TransportSet rule = transports_.SetOf(channel.transports);
    if (rule != transports_.all()) rules.emplace(channel.channel, rule);
  }
  if (!rules.empty()) ruled_ = true;
  return rules;
}

// A session that hears this one connects to an endpoint here; if there is none, one is bound.
void BridgeCore::LookOnNetwork() {
  ZmqTransport& zmq = Zmq();
  std::set<std::string> configured;
  for (const SubscribeEndpoint& endpoint : options_.zmq.subscribe) configured.insert(endpoint.endpoint);
  lan_ = std::make_unique<LanPeers>(zmq, log_, std::move(configured));
  try {
    const auto bound = zmq.BoundEndpoints();
    if (std::ranges::none_of(bound, [](const auto& endpoint) { return ReachesOtherHosts(endpoint); })) {
      zmq.AddPublishEndpoint({"tcp://*:*", std::nullopt});
    }
    announcer_.UseBeacon(OpenBeacon(*options_.beacon, *lan_, log_));
  } catch (const std::exception& error) {
    log_.Write(LogLevel::kWarning, std::string("Sessions of other hosts are not found. ") + error.what());
  }
  Announce();
}

std::vector<std::vector<SessionChannels>> BridgeCore::KnownChannels() const {
  std::vector<std::vector<SessionChannels>> known(1);
  for (const Announcement& peer : announcer_.PeersOnHost()) {
    known[0].push_back({InfoOf(peer), {peer.channels.begin(), peer.channels.end()}});
  }
  for (const Transport* const transport : open_.All()) known.push_back(transport->KnownChannels());
  return known;
}

ChannelSearch BridgeCore::Search(const std::string& channel) const {
  ChannelSearch search;
  for (const Announcement& peer : announcer_.PeersOnHost()) {
    const bool there = std::ranges::any_of(
        peer.channels, [&](const auto& entry) { return entry.subscribes && entry.channel == channel; });
    if (there) search.announced.push_back(InfoOf(peer));
  }
  if (open_.reach_other_hosts()) return search;  // A session that is reached later may still subscribe.
  search.complete_at = last_came_.load() + kTimeToSubscribe;
  search.complete = std::chrono::steady_clock::now() >= search.complete_at;
  return search;
}

// The one of two sessions with the smaller id connects.
void BridgeCore::OnCame(const Announcement& peer) {
  last_came_ = std::chrono::steady_clock::now();
  options_.on_announcements();
  listener_.OnChannels();
  if (!announcer_.IsWanted(peer)) {
    log_.Write(LogLevel::kInfo,
               "No connection to session " + NameOf(peer) + " of this host: `discovery: local` " +
                   (announcer_.IsExcludedHere(peer) ? "here does not list \"" + peer.process + "\"."
                                                    : "there does not list \"" + options_.zmq.process + "\"."));
    return;
  }
  TransportSet expected;
  for (TransportIndex i = 0; i < transports_.size(); ++i) {
    const bool here = transports_.on_host().Has(i) && open_[i] != nullptr && peer.boot_id == boot_id_;
    if (here && peer.places.contains(transports_[i].key)) expected.Add(i);
  }
  peers_.Found(peer.session, expected, RulesOf(peer));
  WarnLaterOfRules();
  if (expected.empty()) return;
  AwaitHostTransports(peer.session, peer.process, peer.pid);
  if (options_.zmq.session.value > peer.session.value) return;
  for (TransportIndex i = 0; i < transports_.size(); ++i) {
    if (expected.Has(i)) open_[i]->AddPeer(peer.places.at(transports_[i].key));
  }
}

void BridgeCore::OnChanged(const Announcement& peer) {
  options_.on_announcements();
  listener_.OnChannels();
  TransportRules rules = RulesOf(peer);
  WarnLaterOfRules();
  if (!peers_.SetRules(peer.session, std::move(rules))) return;
  ForgetForbiddenMoves(peer.session);
  AskAgain();
}

void BridgeCore::OnGone(const Announcement& last, std::string_view /*reason*/) {
  peers_.Lost(last.session);
  options_.on_announcements();
  listener_.OnChannels();
  GiveUpSubscriber(last.session);
  AskAgain();  // A peer that another transport reaches is no longer left to transports of this host.
  for (TransportIndex i = 0; i < transports_.size(); ++i) {
    const auto place = last.places.find(transports_[i].key);
    if (open_[i] != nullptr && place != last.places.end()) open_[i]->RemovePeer(place->second);
  }
}

// A session may be on this host and still unreachable, for example in a container.
void BridgeCore::AwaitHostTransports(SessionId id, const std::string& process, std::int64_t pid) {
  options_.later(kHostPatience, [this, id, process, pid] {
    const PeerTransports::GivenUp given_up = peers_.GiveUp(id);
    if (given_up.missing.empty()) return;
    if (given_up.matters) {
      const std::string what = "Session " + SessionName(id, process, pid) + " was found on this host, but " +
                               transports_.NamesOf(given_up.missing) + " does not reach it";
      log_.Write(LogLevel::kWarning,
                 what +
                     (given_up.reached_by ? ": " + transports_.name(*given_up.reached_by) + " carries its messages."
                                          : ", and no endpoint leads to it: nothing passes between the two.") +
                     " Check whether both run as one user and in one network namespace.");
    }
    AskAgain();
  });
}

void BridgeCore::WarnLaterOfRules() {
  if (ruled_) options_.later(kTimeToBeReached, [this] { WarnOfRules(); });
}

// Reports, once each, the channels that two sessions of this host share and for which rules leave no transport.
void BridgeCore::WarnOfRules() {
  const Announcement own = announcer_.own();
  const auto zmq = transports_.Find(kZmqKey);
  const std::scoped_lock lock(said_mutex_);
  for (const Announcement& peer : announcer_.PeersOnHost()) {
    for (const ChannelAnnouncement& there : peer.channels) {
      const auto here = std::ranges::find(own.channels, there.channel, &ChannelAnnouncement::channel);
      if (here == own.channels.end()) continue;
      const bool shared = (here->publishes && there.subscribes) || (here->subscribes && there.publishes);
      const TransportSet allowed = peers_.Allowed(peer.session, there.channel);
      if (!shared || allowed == transports_.all() || !peers_.ReachedBy(peer.session).In(allowed).empty()) continue;
      if (!said_.emplace(there.channel, peer.session.value).second) continue;
      log_.Write(LogLevel::kWarning,
                 "Nothing passes on channel \"" + there.channel + "\" between this session and " + NameOf(peer) + ": " +
                     (allowed.empty() ? "the `transports` here and there have nothing in common."
                                      : "its `transports` allow " + transports_.NamesOf(allowed) +
                                            " only, which does not reach that session.") +
                     " Change channels: " + there.channel + ": transports" +
                     (zmq && allowed.Has(*zmq) ? ", or give the publishing side an endpoint." : "."));
    }
  }
}

}  // namespace hgros
