#include "viewer/app/displays/channel_list.hpp"

#include <algorithm>

#include "viewer/data/channels/type_conflict.hpp"

namespace hgros::viewer {

void ChannelList::Refresh(const Session& session) {
  known_ = session.Channels();
  std::erase_if(known_, [](const KnownChannel& known) { return known.name.starts_with("hgros/"); });
  published_.clear();
  for (const KnownChannel& known : known_) {
    if (!known.publishers.empty()) published_.push_back({known.name, known.type_name, TypeConflict(known)});
  }
}

std::string ChannelList::PublishedType(const std::string& channel, const DisplayType& display) const {
  const auto known = std::ranges::find(known_, channel, &KnownChannel::name);
  if (known == known_.end() || known->publishers.empty()) return {};
  for (const ChannelUser& user : known->publishers) {
    if (std::ranges::find(display.schemas, user.type_name) != display.schemas.end()) return user.type_name;
  }
  return known->type_name;
}

}  // namespace hgros::viewer
