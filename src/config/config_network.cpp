#include <string_view>
#include <utility>

#include "config/config_draft.hpp"
#include "config/config_endpoint.hpp"
#include "hgros/base/names.hpp"
#include "hgros/yaml/quoted.hpp"

namespace hgros {
namespace {

using yaml::Section;
using yaml::Settle;
using yaml::Value;

constexpr std::int64_t kLongestMs = 3'600'000;
constexpr std::uint64_t kMostQueueBytes = std::uint64_t{1} << 40U;

// Two publisher endpoints cannot share a port, because only one of them could be bound.
void RequireOwnPort(const std::string& text, int port, const Value& ip, const ConfigDraft& draft) {
  for (const auto& [other_text, other] : draft.publishers) {
    if (other.tcp_port != port) continue;
    ip.Fail("is \"" + text + "\", but port " + std::to_string(port) + " belongs to \"" + other_text + "\" at " +
                other.position.ToString(),
            "Give each publisher endpoint its own port, or write both in the same way.");
  }
}

// Reads one {ip, channels}. Returns the endpoint and its position; empty if the endpoint is off.
std::optional<std::pair<std::string, FilePosition>> ReadWhiteList(const Value& value, EndpointSide side,
                                                                  ConfigDraft& draft) {
  const Section section(value, "a map with ip and channels", {"ip", "channels"});
  std::optional<Value> ip;
  std::optional<Endpoint> endpoint;
  value.faults().Attempt([&] {
    ip = section.Require("ip");
    endpoint = ReadEndpoint(*ip, side);
  });
  const std::optional<Value> list = section.Find("channels");
  std::set<std::string> channels;
  section.Read("channels", [&](const Value& names) { channels = ReadChannelNames(names); });
  if (!endpoint) return std::nullopt;

  auto& known = side == EndpointSide::kPublisher ? draft.publishers : draft.subscribers;
  if (!known.contains(endpoint->text)) {
    if (side == EndpointSide::kPublisher && endpoint->tcp_port) {
      RequireOwnPort(endpoint->text, *endpoint->tcp_port, *ip, draft);
    }
    known[endpoint->text] = {ip->position(), endpoint->tcp_port, {}, false};
  }
  ConfigDraft::Endpoint& entry = known[endpoint->text];
  entry.channels.merge(channels);
  entry.all_channels = entry.all_channels || !list;
  return std::pair(endpoint->text, ip->position());
}

void ReadPublishers(const Value& value, ConfigDraft& draft) {
  if (value.kind() == yaml::Node::Kind::kList) {
    for (const Value& item : value.List("")) {
      item.faults().Attempt([&] { ReadWhiteList(item, EndpointSide::kPublisher, draft); });
    }
  } else {
    ReadWhiteList(value, EndpointSide::kPublisher, draft);
  }
}

void ReadSubscribers(const Value& value, ConfigDraft& draft) {
  if (value.kind() == yaml::Node::Kind::kNull) return;
  std::map<std::string, FilePosition> in_this_list;
  const auto read_item = [&](const Value& item) {
    const auto read = ReadWhiteList(item, EndpointSide::kSubscriber, draft);
    if (!read) return;
    const auto [first, fresh] = in_this_list.insert(*read);
    if (fresh) return;
    throw ConfigError("The subscriber endpoint \"" + read->first + "\" appears twice in one list; first at " +
                          first->second.ToString() + ".",
                      read->second, "Keep one of them, with the channels of both.");
  };
  const std::vector<Value> items = value.List("a list of endpoints, each beginning with a dash");
  for (const Value& item : items) item.faults().Attempt([&] { read_item(item); });
}

}  // namespace

void CheckChannelName(const std::string& name, const FilePosition& position) {
  const std::string fault = ChannelNameFault(name);
  if (fault.empty()) return;
  throw ConfigError("The channel name " + yaml::Quoted(name) + " cannot be used: " + fault + ".", position,
                    "Use 1 to 200 visible characters, such as \"robot1/scan\".");
}

std::set<std::string> ReadChannelNames(const Value& list) {
  std::map<std::string, FilePosition> names;
  const auto read = [&](const Value& item) {
    const std::string& name = item.Text("a channel name");
    CheckChannelName(name, item.position());
    const auto [first, fresh] = names.emplace(name, item.position());
    if (fresh) return;
    item.Fail("is " + yaml::Quoted(name) + ", which the list already has at " + first->second.ToString(),
              "Keep one of them.");
  };
  const std::vector<Value> items = list.List("a list of names");
  for (const Value& item : items) item.faults().Attempt([&] { read(item); });
  std::set<std::string> out;
  for (const auto& [name, position] : names) out.insert(out.end(), name);
  return out;
}

void ReadNetwork(const Value& value, ConfigDraft& draft) {
  const Section section(
      value, "a map", {"publisher", "subscribers", "security", "peer_queue_bytes", "heartbeat_ms", "peer_timeout_ms"});
  section.Read("publisher", [&](const Value& publisher) { ReadPublishers(publisher, draft); });
  section.Read("subscribers", [&](const Value& subscribers) { ReadSubscribers(subscribers, draft); });
  section.Read("security", [&](const Value& security) { ReadSecurity(security, draft); });
  section.Read("peer_queue_bytes",
               [&](const Value& bytes) { Settle(draft.peer_queue_bytes, bytes.SizeBytes(1, kMostQueueBytes), bytes); });
  section.Read("heartbeat_ms", [&](const Value& heartbeat) {
    Settle(draft.heartbeat_ms, static_cast<int>(heartbeat.Integer(1, kLongestMs)), heartbeat);
  });
  section.Read("peer_timeout_ms", [&](const Value& timeout) {
    Settle(draft.peer_timeout_ms, static_cast<int>(timeout.Integer(1, kLongestMs)), timeout);
  });
}

}  // namespace hgros
