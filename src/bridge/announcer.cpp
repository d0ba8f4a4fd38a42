#include "bridge/announcer.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace hgros {
namespace {

// Between two announcements; the more channels, the longer.
constexpr auto kLeastPause = std::chrono::milliseconds(2);
constexpr int kPausePerWork = 4;

bool ListNames(const std::vector<std::string>& only, const std::string& process) {
  return only.empty() || std::ranges::find(only, process) != only.end();
}

}  // namespace

Announcer::Announcer(SessionId session, const std::string& process, std::vector<std::string> only, Later later,
                     Log& log)
    : log_(log),
      process_(process),
      only_(std::move(only)),
      later_(std::move(later)),
      own_(AnnouncementOfThisProcess(session, 0)) {
  own_.process = process_;
  own_.only = only_;
}

void Announcer::SetPlace(const std::string& transport_key, const std::string& place) {
  const std::scoped_lock lock(mutex_);
  own_.places[transport_key] = place;
}

void Announcer::SetEndpoints(std::vector<std::string> endpoints) {
  const std::scoped_lock lock(mutex_);
  own_.endpoints = std::move(endpoints);
}

ChannelAnnouncement& Announcer::Channel(const std::string& channel, const TypeInfo& type,
                                        const TransportKeys& transports) {
  const auto [place, is_new] = places_.try_emplace(channel, own_.channels.size());
  ChannelAnnouncement& entry = is_new ? own_.channels.emplace_back() : own_.channels[place->second];
  entry.channel = channel;
  entry.transports = transports;
  if (IsAnyType(type)) return entry;
  entry.type_name = type.name;
  entry.encoding = type.encoding;
  entry.fingerprint = type.fingerprint;
  return entry;
}

void Announcer::Publishes(const std::string& channel, const TypeInfo& type, const TransportKeys& transports) {
  const std::scoped_lock lock(mutex_);
  Channel(channel, type, transports).publishes = true;
}

void Announcer::Subscribes(const std::string& channel, const TypeInfo& type, const TransportKeys& transports,
                           bool lossless) {
  const std::scoped_lock lock(mutex_);
  ChannelAnnouncement& entry = Channel(channel, type, transports);
  entry.subscribes = true;
  entry.lossless = lossless;
}

bool Announcer::SetLossless(const std::string& channel, bool lossless) {
  const std::scoped_lock lock(mutex_);
  const auto place = places_.find(channel);
  if (place == places_.end()) return false;
  ChannelAnnouncement& entry = own_.channels[place->second];
  if (!entry.subscribes || entry.lossless == lossless) return false;
  entry.lossless = lossless;
  return true;
}

void Announcer::EndPublishing(const std::string& channel) { EndUse(channel, &ChannelAnnouncement::publishes); }

void Announcer::EndSubscribing(const std::string& channel) { EndUse(channel, &ChannelAnnouncement::subscribes); }

void Announcer::EndUse(const std::string& channel, bool ChannelUse::*use) {
  const std::scoped_lock lock(mutex_);
  const auto place = places_.find(channel);
  if (place == places_.end()) return;
  ChannelAnnouncement& entry = own_.channels[place->second];
  entry.*use = false;
  if (entry.publishes || entry.subscribes) return;
  if (&entry != &own_.channels.back()) {
    entry = std::move(own_.channels.back());
    places_[entry.channel] = place->second;
  }
  own_.channels.pop_back();
  places_.erase(place);
}

void Announcer::UseRegistry(std::unique_ptr<Discovery> registry) {
  const std::scoped_lock lock(mutex_);
  if (!closed_) registry_.swap(registry);
}

void Announcer::AppearOnHost() {
  const std::scoped_lock lock(mutex_);
  if (!registry_ || on_host_) return;
  registry_->Announce(own_);
  on_host_ = true;
}

void Announcer::UseBeacon(std::unique_ptr<Discovery> beacon) {
  const std::scoped_lock lock(mutex_);
  beacon_ = std::move(beacon);
}

void Announcer::Close() noexcept {
  std::unique_ptr<Discovery> registry;
  std::unique_ptr<Discovery> beacon;
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  registry = std::move(registry_);
  beacon = std::move(beacon_);
}

void Announcer::Tell(Discovery& discovery, const std::string& listeners) {
  try {
    discovery.Announce(own_);
  } catch (const std::exception& error) {
    log_.WriteLimited(LogLevel::kWarning, "announce " + listeners,
                      "Other sessions of " + listeners + " do not see the changes of this session. " + error.what());
  }
}

// A program that advertises thousands of channels in a row announces them a few times, not once each.
void Announcer::Announce() {
  const std::scoped_lock lock(mutex_);
  if (waits_ || (!registry_ && !beacon_)) return;
  const auto now = Clock::now();
  if (now >= next_) {
    TellAll();
    return;
  }
  waits_ = true;
  later_(next_ - now, [this] {
    const std::scoped_lock errand_lock(mutex_);
    waits_ = false;
    TellAll();
  });
}

void Announcer::TellAll() {
  const auto start = Clock::now();
  if (registry_ && on_host_) Tell(*registry_, "this host");
  if (beacon_) Tell(*beacon_, "this network");
  const auto end = Clock::now();
  next_ = end + std::max<Clock::duration>(kLeastPause, kPausePerWork * (end - start));
}

bool Announcer::IsExcludedHere(const Announcement& peer) const { return !ListNames(only_, peer.process); }

bool Announcer::IsWanted(const Announcement& peer) const {
  return !IsExcludedHere(peer) && ListNames(peer.only, process_);
}

std::vector<Announcement> Announcer::PeersOnHost(const Discovery::Which& which) const {
  const std::scoped_lock lock(mutex_);
  if (!registry_) return {};
  return registry_->List([&](const Announcement& peer) { return IsWanted(peer) && (!which || which(peer)); });
}

std::optional<ChannelAnnouncement> Announcer::OwnChannel(const std::string& channel) const {
  const std::scoped_lock lock(mutex_);
  const auto place = places_.find(channel);
  if (place == places_.end()) return std::nullopt;
  return own_.channels[place->second];
}

Announcement Announcer::own() const {
  const std::scoped_lock lock(mutex_);
  return own_;
}

PeerInfo InfoOf(const Announcement& peer) {
  PeerInfo info;
  info.id = peer.session;
  info.process = peer.process;
  info.host = peer.host;
  info.pid = peer.pid;
  return info;
}

}  // namespace hgros
