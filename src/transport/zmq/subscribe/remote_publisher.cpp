#include "transport/zmq/subscribe/remote_publisher.hpp"

#include <utility>

namespace hgros::zmq {

void RemotePublisher::AddOffer(const wire::ChannelType& offered) {
  auto use = ReadUse(offered);
  if (!use || (offers.size() >= kMaxChannels && !offers.contains(offered.channel()))) return;
  use->publishes = true;
  offers.insert_or_assign(offered.channel(), std::move(*use));
}

void RemotePublisher::UpdateOffers(const wire::Offers& changed) {
  for (const std::string& channel : changed.gone()) offers.erase(channel);
  for (const auto& offered : changed.came()) AddOffer(offered);
}

void RemotePublisher::AddOffers(std::vector<SessionChannels>& known) const {
  if (!alive) return;
  SessionChannels& session = known.emplace_back(SessionChannels{facts.info, {}});
  for (const auto& [channel, use] : offers) session.channels.push_back(use);
}

}  // namespace hgros::zmq
