#include "hgros/bridge/channel_directory.hpp"

#include <utility>

namespace hgros {
namespace {

ChannelUser UserOf(const PeerInfo& session, const ChannelUse& use) {
  ChannelUser user;
  user.session = session.id;
  user.process = session.process;
  user.host = session.host;
  user.pid = session.pid;
  user.type_name = use.type_name;
  user.encoding = use.encoding;
  user.fingerprint = use.fingerprint;
  user.lossless = use.lossless;
  return user;
}

void TakeType(KnownChannel& channel, const std::vector<ChannelUser>& users) {
  for (const ChannelUser& user : users) {
    if (!channel.type_name.empty()) return;
    channel.type_name = user.type_name;
    channel.encoding = user.encoding;
    channel.fingerprint = user.fingerprint;
  }
}

}  // namespace

void ChannelDirectory::Add(const std::vector<SessionChannels>& source) {
  std::set<std::uint64_t> said;
  for (const auto& [session, channels] : source) {
    if (known_.contains(session.id.value)) continue;
    said.insert(session.id.value);
    for (const ChannelUse& use : channels) {
      Use& entry = uses_[use.channel][session.id.value];
      const ChannelUse before = std::exchange(entry.use, use);
      entry.session = session;
      entry.use.publishes = use.publishes || before.publishes;
      entry.use.subscribes = use.subscribes || before.subscribes;
      entry.use.lossless = use.lossless || before.lossless;
      if (!use.type_name.empty()) continue;
      entry.use.type_name = before.type_name;
      entry.use.encoding = before.encoding;
      entry.use.fingerprint = before.fingerprint;
    }
  }
  known_.merge(said);
}

std::vector<KnownChannel> ChannelDirectory::Channels() const {
  std::vector<KnownChannel> channels;
  for (const auto& [name, users] : uses_) {
    KnownChannel channel;
    channel.name = name;
    for (const auto& [session, entry] : users) {
      if (entry.use.publishes) channel.publishers.push_back(UserOf(entry.session, entry.use));
      if (entry.use.subscribes) channel.subscribers.push_back(UserOf(entry.session, entry.use));
    }
    TakeType(channel, channel.publishers);
    TakeType(channel, channel.subscribers);
    if (!channel.publishers.empty() || !channel.subscribers.empty()) channels.push_back(std::move(channel));
  }
  return channels;
}

}  // namespace hgros
