// How a session finds others of its host and its network, and is found.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "session/carriers.hpp"

namespace hgros {
namespace {

// What is said when all have had the time to be reached.
constexpr auto kTimeToBeReached = std::chrono::seconds(3);

std::string NameOf(const Announcement& peer) {
  return "Session " + peer.session.ToString() + " (" + peer.process + ", process " + std::to_string(peer.pid) + ")";
}

bool Names(const std::vector<std::string>& only, const std::string& process) {
  return only.empty() || std::ranges::find(only, process) != only.end();
}

CarrierRules RulesOf(const Announcement& peer) {
  CarrierRules rules;
  for (const ChannelAnnouncement& channel : peer.channels) {
    const CarrierSet rule{channel.by_shared_memory, channel.by_endpoints};
    if (!rule.all()) rules.emplace(channel.channel, rule);
  }
  return rules;
}

}  // namespace

void Carriers::OpenShm() {
  ShmOptions shm = *options_.shm;
  shm.takes = [this](SessionId peer, std::string_view channel) {
    return peers_.Take(peer, channel, CarrierKind::kShm);
  };
  try {
    shm_ = MakeShmTransport(std::move(shm), shm_ear_, log_);
    own_.shared_memory = shm_->place();
  } catch (const std::exception& error) {
    log_.Write(LogLevel::kWarning,
               std::string("Sessions of this host are not reached through shared memory. ") + error.what());
  }
}

void Carriers::LookOnHost() {
  try {
    auto registry = OpenRegistry(*options_.registry, *this, log_);
    registry->Announce(own_);
    const std::scoped_lock lock(announcing_);
    registry_ = std::move(registry);
  } catch (const std::exception& error) {
    log_.Write(LogLevel::kWarning, std::string("Sessions of this host are not looked for. ") + error.what());
  }
}

// Who hears us connects to an endpoint of ours; if there is none, one is bound.
void Carriers::LookOnNetwork() {
  ZmqTransport& zmq = Zmq();
  std::set<std::string> configured;
  for (const SubscribeEndpoint& endpoint : options_.zmq.subscribe) configured.insert(endpoint.endpoint);
  lan_ = std::make_unique<LanPeers>(zmq, log_, std::move(configured));
  try {
    const auto bound = zmq.BoundEndpoints();
    if (std::ranges::none_of(bound, [](const auto& endpoint) { return ReachesOtherHosts(endpoint); })) {
      zmq.AddPublishEndpoint({"tcp://*:*", std::nullopt});
    }
    auto beacon = OpenBeacon(*options_.beacon, *lan_, log_);
    const std::scoped_lock lock(announcing_);
    beacon_ = std::move(beacon);
  } catch (const std::exception& error) {
    log_.Write(LogLevel::kWarning, std::string("Sessions of other hosts are not looked for. ") + error.what());
  }
  Announce();
}

ChannelAnnouncement& Carriers::Own(const std::string& channel, const TypeInfo& type) {
  const auto known = std::ranges::find(own_.channels, channel, &ChannelAnnouncement::channel);
  ChannelAnnouncement& entry = known == own_.channels.end() ? own_.channels.emplace_back() : *known;
  entry.channel = channel;
  const CarrierSet rule = RuleOf(channel);
  entry.by_shared_memory = rule.shared_memory;
  entry.by_endpoints = rule.zmq;
  if (IsAnyType(type)) return entry;
  entry.type_name = type.name;
  entry.encoding = type.encoding;
  entry.fingerprint = type.fingerprint;
  return entry;
}

void Carriers::Unannounce(const std::string& channel) {
  {
    const std::scoped_lock lock(announcing_);
    const auto entry = std::ranges::find(own_.channels, channel, &ChannelAnnouncement::channel);
    if (entry == own_.channels.end()) return;
    entry->subscribes = false;
    if (!entry->publishes) own_.channels.erase(entry);
  }
  Announce();
}

void Carriers::Withdraw(const std::string& channel) {
  {
    const std::scoped_lock lock(announcing_);
    const auto entry = std::ranges::find(own_.channels, channel, &ChannelAnnouncement::channel);
    if (entry == own_.channels.end()) return;
    entry->publishes = false;
    if (!entry->subscribes) own_.channels.erase(entry);
  }
  Announce();
}

std::vector<SessionChannels> Carriers::AnnouncedChannels() {
  std::vector<SessionChannels> announced;
  const std::scoped_lock lock(announcing_);
  if (!registry_) return announced;
  for (const Announcement& peer : registry_->List()) {
    if (!IsWanted(peer)) continue;
    SessionChannels& session = announced.emplace_back();
    session.session.id = peer.session;
    session.session.process = peer.process;
    session.session.host = peer.host;
    session.session.pid = peer.pid;
    for (const ChannelAnnouncement& one : peer.channels) {
      session.channels.push_back(
          {one.channel, one.type_name, one.encoding, one.fingerprint, one.publishes, one.subscribes, one.lossless});
    }
  }
  return announced;
}

ChannelSearch Carriers::Search(const std::string& channel) {
  ChannelSearch search;
  const std::scoped_lock lock(announcing_);
  if (registry_) {
    for (const Announcement& peer : registry_->List()) {
      const bool there = std::ranges::any_of(
          peer.channels, [&](const auto& entry) { return entry.subscribes && entry.channel == channel; });
      if (!there || !IsWanted(peer)) continue;
      PeerInfo& info = search.announced.emplace_back();
      info.id = peer.session;
      info.process = peer.process;
      info.pid = peer.pid;
    }
  }
  if (zmq() != nullptr) return search;  // Whoever it reaches, now or later, may subscribe.
  search.complete_at = last_came_.load() + kTimeToSubscribe;
  search.complete = std::chrono::steady_clock::now() >= search.complete_at;
  return search;
}

void Carriers::Announce() {
  const std::scoped_lock lock(announcing_);
  if (zmq() != nullptr) own_.endpoints = zmq()->BoundEndpoints();
  const auto announce = [this](Discovery& discovery, const std::string& who) {
    try {
      discovery.Announce(own_);
    } catch (const std::exception& error) {
      log_.WriteLimited(LogLevel::kWarning, "announce " + who,
                        "Other sessions of " + who + " do not see what has changed here. " + error.what());
    }
  };
  if (registry_) announce(*registry_, "this host");
  if (beacon_) announce(*beacon_, "this network");
  listener_.OnChannels();
}

// Either of two sessions may narrow down whom it has to do with.
bool Carriers::IsWanted(const Announcement& peer) {
  const bool by_us = Names(options_.only, peer.process);
  return by_us && Names(peer.only, options_.zmq.process);
}

// Of two sessions the one with the smaller id connects.
void Carriers::OnCame(const Announcement& peer) {
  last_came_ = std::chrono::steady_clock::now();
  options_.on_announcements();
  listener_.OnChannels();
  if (!IsWanted(peer)) {
    log_.Write(LogLevel::kInfo,
               NameOf(peer) + " of this host is not connected to: `discovery: local` " +
                   (Names(options_.only, peer.process) ? "there does not list \"" + options_.zmq.process + "\"."
                                                       : "here does not list \"" + peer.process + "\"."));
    return;
  }
  const bool shares = shm_ && !peer.shared_memory.empty() && peer.boot_id == own_.boot_id;
  CarrierRules rules = RulesOf(peer);
  if (!rules.empty()) ruled_ = true;
  peers_.Found(peer.session, shares, std::move(rules));
  SayLaterWhatCannotPass();
  if (!shares) return;
  AwaitSharedMemory(peer.session, peer.process, peer.pid);
  if (options_.zmq.session.value < peer.session.value) shm_->AddPeer(peer.shared_memory);
}

void Carriers::OnChanged(const Announcement& peer) {
  options_.on_announcements();
  listener_.OnChannels();
  CarrierRules rules = RulesOf(peer);
  if (!rules.empty()) ruled_ = true;
  SayLaterWhatCannotPass();
  if (!peers_.SetRules(peer.session, std::move(rules))) return;
  ForgetRuledMoves(peer.session);
  AskAgain(CarrierKind::kShm);
  AskAgain(CarrierKind::kZmq);
}

void Carriers::OnGone(const Announcement& last, std::string_view /*reason*/) {
  peers_.Lost(last.session);
  options_.on_announcements();
  listener_.OnChannels();
  GiveUpSubscriber(last.session);
  AskAgain(CarrierKind::kZmq);  // What is still reached otherwise is no longer left to shared memory.
  if (shm_ && !last.shared_memory.empty()) shm_->RemovePeer(last.shared_memory);
}

// It is on this host, and may still not be able to share memory with us, in a container for one.
void Carriers::AwaitSharedMemory(SessionId id, const std::string& process, std::int64_t pid) {
  options_.later(kSharedMemoryPatience, [this, id, process, pid] {
    const PeerCarriers::Without without = peers_.GiveUp(id);
    if (without == PeerCarriers::Without::kNotNeeded) return;
    const std::string who = "Session " + id.ToString() + " (" + process + ", process " + std::to_string(pid) +
                            ") was found on this host, but no memory can be shared with it";
    const std::string mend = " Check whether both run as one user and in one network namespace.";
    if (without == PeerCarriers::Without::kReached) {
      log_.Write(LogLevel::kWarning, who + ": ZeroMQ carries its messages." + mend);
    } else {
      log_.Write(LogLevel::kWarning, who + ", and no endpoint leads to it: nothing passes between the two." + mend);
    }
    AskAgain(CarrierKind::kZmq);
  });
}

void Carriers::SayLaterWhatCannotPass() {
  if (ruled_) options_.later(kTimeToBeReached, [this] { SayWhatCannotPass(); });
}

// Channels that two sessions of this host share, and whose rules leave them no way: once each.
void Carriers::SayWhatCannotPass() {
  const std::scoped_lock lock(announcing_);
  if (!registry_) return;
  for (const Announcement& peer : registry_->List()) {
    if (!IsWanted(peer)) continue;
    for (const ChannelAnnouncement& there : peer.channels) {
      const auto here = std::ranges::find(own_.channels, there.channel, &ChannelAnnouncement::channel);
      if (here == own_.channels.end()) continue;
      const bool shared = (here->publishes && there.subscribes) || (here->subscribes && there.publishes);
      const CarrierSet allowed = peers_.Allowed(peer.session, there.channel);
      const CarrierKind left = allowed.zmq ? CarrierKind::kZmq : CarrierKind::kShm;
      if (!shared || allowed.all() || (!allowed.none() && peers_.IsReached(peer.session, left))) continue;
      if (!said_.emplace(there.channel, peer.session.value).second) continue;
      log_.Write(LogLevel::kWarning,
                 "Nothing passes on channel \"" + there.channel + "\" between this session and " +
                     peer.session.ToString() + " (" + peer.process + ", process " + std::to_string(peer.pid) + "): " +
                     (allowed.none() ? "what `carriers` allow it here and there has nothing in common."
                                     : "its `carriers` allow " + std::string(NameOf(left)) +
                                           " only, which does not reach that session.") +
                     " Change channels: " + there.channel + ": carriers" +
                     (allowed.zmq ? ", or give the publishing side an endpoint." : "."));
    }
  }
}

}  // namespace hgros
