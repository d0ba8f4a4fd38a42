#include "session/endpoint_lists.hpp"

#include <algorithm>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"

namespace hgros {

ChannelList ListOf(const EndpointConfig& endpoint) {
  if (endpoint.all_channels) return std::nullopt;
  return endpoint.channels;
}

bool SetAllowed(EndpointConfig& endpoint, std::string_view channel, bool allowed) {
  if (endpoint.all_channels && allowed) return false;
  if (endpoint.all_channels) {
    throw Error("The endpoint " + endpoint.endpoint + " lets every channel pass, so \"" + std::string(channel) +
                    "\" cannot be excluded.",
                {}, "Give the endpoint a list of channels in its configuration.");
  }
  auto& list = endpoint.channels;
  const auto place = std::lower_bound(list.begin(), list.end(), channel);
  const bool listed = place != list.end() && *place == channel;
  if (allowed && !listed) list.emplace(place, channel);
  if (!allowed && listed) list.erase(place);
  return true;
}

std::string_view OutermostPlace(const Config& config, bool has_domain) noexcept {
  return has_domain && config.discovery.local ? "host" : "process";
}

std::string DescribeConfined(std::string_view channel, const std::vector<EndpointConfig>& endpoints, Way way,
                             std::string_view place) {
  std::vector<std::string> listed;
  for (const EndpointConfig& endpoint : endpoints) {
    if (endpoint.all_channels || std::binary_search(endpoint.channels.begin(), endpoint.channels.end(), channel)) {
      return {};
    }
    listed.insert(listed.end(), endpoint.channels.begin(), endpoint.channels.end());
  }
  if (endpoints.empty()) return {};
  const std::string nearest = NearestName(channel, listed);
  const std::string where(place);
  return "Channel \"" + std::string(channel) +
         (way == Way::kOut ? "\" is published, but does not leave this " + where + ": no publisher"
                           : "\" is subscribed to, but nothing enters this " + where + ": no subscriber") +
         " endpoint has it in its list of channels." +
         (nearest.empty() ? std::string() : " Did you mean \"" + nearest + "\"?");
}

}  // namespace hgros
