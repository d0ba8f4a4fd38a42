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

// If the registry cannot be opened or written: the disk may get room again, or the folder its right owner.
constexpr auto kBetweenLooks = std::chrono::seconds(1);
// A program that starts sets up several channels. Others read its first announcement once it has them, and where there
// are many others, a little later.
constexpr auto kTimeForReader = std::chrono::microseconds(200);
constexpr auto kShortestStart = std::chrono::milliseconds(5);
constexpr auto kLongestStart = std::chrono::milliseconds(100);

std::string NameOf(const Announcement& peer) { return SessionName(peer.process, peer.pid); }

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
    log_.WriteLimited(LogLevel::kWarning, "look on host",
                      std::string("Sessions of this host are not found. ") + error.what() + " This is tried again.");
    options_.later(kBetweenLooks, [this] { LookOnHost(); });
    return;
  }
  // On another thread, our channels may have changed while the registry was opened.
  const std::vector<Announcement> readers = announcer_.PeersOnHost();
  for (const Announcement& peer : readers) pairs_.Changed(peer);
  options_.later(std::clamp<std::chrono::nanoseconds>(readers.size() * kTimeForReader, kShortestStart, kLongestStart),
                 [this] { AppearOnHost(); });
}

void BridgeCore::AppearOnHost() {
  try {
    announcer_.AppearOnHost();
  } catch (const std::exception& error) {
    log_.WriteLimited(
        LogLevel::kWarning, "appear on host",
        std::string("Sessions of this host do not find this one. ") + error.what() + " This is tried again.");
    options_.later(kBetweenLooks, [this] { AppearOnHost(); });
  }
}

// A session that hears this one connects to an endpoint here; if there is none, one is bound.
void BridgeCore::LookOnNetwork() {
  try {
    ZmqTransport& zmq = Zmq();
    std::set<std::string> configured;
    for (const SubscribeEndpoint& endpoint : options_.zmq.subscribe) configured.insert(endpoint.endpoint);
    lan_ = std::make_unique<LanPeers>(zmq, log_, options_.zmq.peer_timeout, options_.later, std::move(configured));
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
  const auto subscribes = [&](const Announcement& peer) {
    return std::ranges::any_of(peer.channels,
                               [&](const auto& entry) { return entry.subscribes && entry.channel == channel; });
  };
  for (const Announcement& peer : announcer_.PeersOnHost(subscribes)) search.announced.push_back(InfoOf(peer));
  if (open_.reach_other_hosts()) return search;  // A session that is reached later may still subscribe.
  search.complete_at = last_came_.load() + kTimeToSubscribe;
  search.complete = std::chrono::steady_clock::now() >= search.complete_at;
  return search;
}

// Once for a burst of changes.
void BridgeCore::TellAnnouncements() {
  listener_.OnChannels();
  if (telling_.exchange(true)) return;
  options_.later({}, [this] {
    telling_ = false;
    options_.on_announcements();
  });
}

void BridgeCore::OnCame(const Announcement& peer) {
  last_came_ = std::chrono::steady_clock::now();
  TellAnnouncements();
  if (!announcer_.IsWanted(peer)) {
    log_.WriteLimited(LogLevel::kDebug, "excluded " + peer.session.ToString(),
                      "Session " + NameOf(announcer_.own()) + " does not connect with session " + NameOf(peer) +
                          " of this host: `discovery: local` " +
                          (announcer_.IsExcludedHere(peer) ? "here does not list \"" + peer.process + "\"."
                                                           : "there does not list \"" + options_.zmq.process + "\"."));
    return;
  }
  pairs_.Found(peer, ruled_out_.RulesOf(peer));
  ruled_out_.LookLater();
}

void BridgeCore::OnChanged(const Announcement& peer) {
  TellAnnouncements();
  TransportRules rules = ruled_out_.RulesOf(peer);
  ruled_out_.LookLater();
  if (peers_.SetRules(peer.session, std::move(rules))) {
    ForgetForbiddenMoves(peer.session);
    AskAgain();
  }
  if (announcer_.IsWanted(peer)) pairs_.Changed(peer);
}

void BridgeCore::OnGone(const Announcement& last, std::string_view /*reason*/) {
  peers_.Lost(last.session);
  TellAnnouncements();
  GiveUpSubscriber(InfoOf(last));
  AskAgain();  // A peer that another transport reaches is no longer left to transports of this host.
  pairs_.Lost(last);
}

}  // namespace hgros
