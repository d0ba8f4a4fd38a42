#include <algorithm>
#include <cstdio>

#include "hgros/base/error.hpp"
#include "viewer/app/viewer.hpp"
#include "viewer/scene/type_mismatch.hpp"

namespace hgros::viewer {

std::string Viewer::CarriedBy(const std::string& channel, const DisplayType& type) const {
  const auto known = std::ranges::find(known_, channel, &KnownChannel::name);
  if (known == known_.end() || known->publishers.empty()) return {};
  for (const ChannelUser& user : known->publishers) {
    if (std::ranges::find(type.schemas, user.type_name) != type.schemas.end()) return user.type_name;
  }
  return known->type_name;
}

Scene::Entry& Viewer::Open(const DisplayType& type, const std::string& channel) {
  try {
    return scene_.Add(type, {session_, channel, [this] { WakeFromData(); }});
  } catch (const TypeMismatch&) {
    std::string carried = CarriedBy(channel, type);
    const auto other = std::ranges::find(scene_.entries(), channel, &Scene::Entry::channel);
    if (carried.empty() && other != scene_.entries().end()) carried = other->type->schemas.front();
    const std::string why = WhyNotShown(type, channel, carried);
    throw Error(!why.empty() ? why
                             : "This viewer has taken \"" + channel +
                                   "\" for another type before, and keeps to that: start it anew to show it as " +
                                   type.name + ".");
  }
}

void Viewer::AddByHand(const DisplayType& type, const std::string& channel) {
  std::string refusal = WhyNotShown(type, channel, CarriedBy(channel, type));
  try {
    if (refusal.empty()) Add(type, channel, {});
  } catch (const Error& error) {
    refusal = error.what();
  }
  display_panel_.Refuse(std::move(refusal));
  frames_wanted_ = std::max(frames_wanted_, 1);
}

void Viewer::SayMismatches() {
  for (Scene::Entry& entry : scene_.entries()) {
    std::string mismatch = WhyNotShown(*entry.type, entry.channel, CarriedBy(entry.channel, *entry.type));
    if (mismatch == entry.mismatch) continue;
    entry.mismatch = std::move(mismatch);
    if (!entry.mismatch.empty()) std::fprintf(stderr, "hgros-viewer: %s\n", entry.mismatch.c_str());
  }
}

}  // namespace hgros::viewer
