#include "bridge/ruled_out_channels.hpp"

#include "hgros/base/session_name.hpp"

namespace hgros {
namespace {

constexpr auto kTimeToBeReached = std::chrono::seconds(3);

}  // namespace

TransportRules RuledOutChannels::RulesOf(const Announcement& peer) {
  TransportRules rules;
  for (const ChannelAnnouncement& channel : peer.channels) {
    const TransportSet rule = means_.transports.SetOf(channel.transports);
    if (rule != means_.transports.all()) rules.emplace(channel.channel, rule);
  }
  if (!rules.empty()) ruled_ = true;
  return rules;
}

// One errand at a time: after a burst of changes, it waits until the last one has had its time.
void RuledOutChannels::LookLater() {
  if (!ruled_) return;
  changed_ = std::chrono::steady_clock::now();
  if (!looks_.exchange(true)) LookIn(kTimeToBeReached);
}

void RuledOutChannels::LookIn(std::chrono::nanoseconds delay) {
  means_.later(delay, [this] {
    const auto left = changed_.load() + kTimeToBeReached - std::chrono::steady_clock::now();
    if (left > std::chrono::nanoseconds(0)) {
      LookIn(left);
      return;
    }
    looks_ = false;
    Look();
  });
}

void RuledOutChannels::Look() {
  const std::scoped_lock lock(said_mutex_);
  for (const Announcement& peer : means_.announcer.PeersOnHost()) {
    for (const ChannelAnnouncement& there : peer.channels) {
      const auto here = means_.announcer.OwnChannel(there.channel);
      if (!here) continue;
      const bool shared = (here->publishes && there.subscribes) || (here->subscribes && there.publishes);
      const TransportSet allowed = means_.peers.Allowed(peer.session, there.channel);
      if (!shared || allowed == means_.transports.all()) continue;
      if (!means_.peers.ReachedBy(peer.session).In(allowed).empty()) continue;
      if (said_.emplace(there.channel, peer.session.value).second) Report(there, peer, allowed);
    }
  }
}

void RuledOutChannels::Report(const ChannelAnnouncement& there, const Announcement& peer, TransportSet allowed) const {
  const auto zmq = means_.transports.Find(kZmqKey);
  means_.log.WriteLimited(LogLevel::kWarning, "ruled out",
                          "Nothing passes on channel \"" + there.channel + "\" between this session and " +
                              SessionName(peer.process, peer.pid) + ": " +
                              (allowed.empty() ? "the `transports` here and there have nothing in common."
                                               : "its `transports` allow " + means_.transports.NamesOf(allowed) +
                                                     " only, which does not reach that session.") +
                              " Change channels: " + there.channel + ": transports" +
                              (zmq && allowed.Has(*zmq) ? ", or give the publishing side an endpoint." : "."));
}

}  // namespace hgros
