#include "discovery/registry/announcement_file.hpp"

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <utility>

#include "hgros/announcement.pb.h"
#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/base/readable_text.hpp"

namespace hgros::discovery {
namespace {

bool Allows(const TransportKeys& transports, std::string_view key) {
  return !transports || std::ranges::find(*transports, key) != transports->end();
}

TransportKeys TransportsOf(const wire::AnnouncedChannel& channel) {
  if (channel.transports_size() > 0) {
    return std::vector<std::string>(channel.transports().begin(), channel.transports().end());
  }
  if (!channel.not_by_shared_memory() && !channel.not_by_endpoints()) return std::nullopt;
  std::vector<std::string> keys;
  if (!channel.not_by_shared_memory()) keys.emplace_back(kSharedMemoryKey);
  if (!channel.not_by_endpoints()) keys.emplace_back(kZmqKey);
  return keys;
}

void Write(const Announcement& from, wire::AnnouncementFile& to) {
  to.set_version(kFileVersion);
  to.set_session(from.session.value);
  to.set_incarnation(from.incarnation);
  to.set_process(Readable(from.process, kMaxAnnouncedTextBytes));
  to.set_host(Readable(from.host, kMaxAnnouncedTextBytes));
  to.set_pid(from.pid);
  to.set_pid_start_time(from.pid_start_time);
  to.set_boot_id(from.boot_id);
  to.set_network(from.network);
  for (const auto& [key, place] : from.places) {
    if (key == kSharedMemoryKey) {
      to.set_shared_memory(place);
      continue;
    }
    wire::AnnouncedPlace& one = *to.add_places();
    one.set_key(key);
    one.set_place(place);
  }
  for (const std::string& endpoint : from.endpoints) to.add_endpoints(endpoint);
  for (const ChannelAnnouncement& channel : from.channels) {
    wire::AnnouncedChannel& one = *to.add_channels();
    one.set_channel(channel.channel);
    one.set_type_name(channel.type_name);
    one.set_encoding(static_cast<std::uint32_t>(channel.encoding));
    one.set_fingerprint(channel.fingerprint);
    one.set_publishes(channel.publishes);
    one.set_subscribes(channel.subscribes);
    one.set_lossless(channel.lossless);
    one.set_not_by_shared_memory(!Allows(channel.transports, kSharedMemoryKey));
    one.set_not_by_endpoints(!Allows(channel.transports, kZmqKey));
    for (const std::string& key : channel.transports.value_or(std::vector<std::string>())) one.add_transports(key);
  }
  for (const std::string& process : from.only) to.add_only(Readable(process, kMaxAnnouncedTextBytes));
}

bool IsPrintable(std::string_view text, std::size_t max_bytes) { return text.size() <= max_bytes && IsReadable(text); }

// The fault in the content of a file; empty if there is none.
std::string Fault(const wire::AnnouncementFile& file) {
  if (file.version() != kFileVersion) {
    return "it has version " + std::to_string(file.version()) + " and this program knows version " +
           std::to_string(kFileVersion);
  }
  if (file.session() == 0) return "it names no session";
  if (!IsPrintable(file.boot_id(), kMaxAnnouncedTextBytes)) return "its boot id is invalid";
  if (!IsPrintable(file.shared_memory(), kMaxPathBytes)) return "its place of shared memory is invalid";
  if (file.places_size() > static_cast<int>(kMaxPlaces)) {
    return "it has more than " + std::to_string(kMaxPlaces) + " places of transports";
  }
  for (const wire::AnnouncedPlace& one : file.places()) {
    if (one.key().empty() || !IsPrintable(one.key(), kMaxAnnouncedTextBytes) ||
        !IsPrintable(one.place(), kMaxPathBytes)) {
      return "one of its places of transports is invalid";
    }
  }
  if (file.endpoints_size() > static_cast<int>(kMaxEndpoints)) {
    return "it has more than " + std::to_string(kMaxEndpoints) + " endpoints";
  }
  for (const std::string& endpoint : file.endpoints()) {
    if (endpoint.empty() || !IsPrintable(endpoint, kMaxAnnouncedTextBytes)) return "one of its endpoints is invalid";
  }
  if (file.only_size() > static_cast<int>(kMaxOnly)) {
    return "it names more than " + std::to_string(kMaxOnly) + " processes that it connects with";
  }
  for (const wire::AnnouncedChannel& channel : file.channels()) {
    if (const std::string fault = ChannelNameFault(channel.channel()); !fault.empty()) {
      return "one of its channel names cannot be used: " + fault;
    }
    if (!IsPrintable(channel.type_name(), kMaxTypeNameBytes)) {
      return "the type name of channel " + channel.channel() + " is invalid";
    }
    if (channel.transports_size() > static_cast<int>(kMaxPlaces)) {
      return "channel " + channel.channel() + " names more than " + std::to_string(kMaxPlaces) + " transports";
    }
    for (const std::string& key : channel.transports()) {
      if (!IsPrintable(key, kMaxAnnouncedTextBytes))
        return "a transport of channel " + channel.channel() + " is invalid";
    }
    if (channel.encoding() > static_cast<std::uint32_t>(Encoding::kPlain)) {
      return "the encoding of channel " + channel.channel() + " is unknown";
    }
  }
  return {};
}

Announcement Read(const wire::AnnouncementFile& from) {
  Announcement to;
  to.session = {from.session()};
  to.incarnation = from.incarnation();
  to.process = Readable(from.process(), kMaxAnnouncedTextBytes);
  to.host = Readable(from.host(), kMaxAnnouncedTextBytes);
  to.pid = from.pid();
  to.pid_start_time = from.pid_start_time();
  to.boot_id = from.boot_id();
  to.network = from.network();
  for (const wire::AnnouncedPlace& one : from.places()) to.places[one.key()] = one.place();
  if (!from.shared_memory().empty()) to.places[std::string(kSharedMemoryKey)] = from.shared_memory();
  to.endpoints.assign(from.endpoints().begin(), from.endpoints().end());
  to.channels.reserve(static_cast<std::size_t>(from.channels_size()));
  for (const wire::AnnouncedChannel& channel : from.channels()) {
    to.channels.push_back({ChannelUse{.channel = channel.channel(),
                                      .type_name = channel.type_name(),
                                      .encoding = static_cast<Encoding>(channel.encoding()),
                                      .fingerprint = channel.fingerprint(),
                                      .publishes = channel.publishes(),
                                      .subscribes = channel.subscribes(),
                                      .lossless = channel.lossless()},
                           TransportsOf(channel)});
  }
  for (const std::string& process : from.only()) to.only.push_back(Readable(process, kMaxAnnouncedTextBytes));
  return to;
}

}  // namespace

std::string EncodeFile(const Announcement& announcement) {
  wire::AnnouncementFile file;
  Write(announcement, file);
  std::string bytes = file.SerializeAsString();
  std::string fault = Fault(file);
  if (fault.empty() && bytes.size() > kMaxFileBytes) {
    fault = "it has " + std::to_string(bytes.size()) + " bytes, more than " + std::to_string(kMaxFileBytes);
  }
  if (!fault.empty()) {
    throw Error("A session cannot be announced like this: " + fault + ".", {},
                "Announce a session with an id, at most 16 endpoints, and fewer channels with shorter names.");
  }
  return bytes;
}

ParsedFile ParseFile(Bytes bytes) {
  if (bytes.size() > kMaxFileBytes) return {{}, "it has more than " + std::to_string(kMaxFileBytes) + " bytes"};
  wire::AnnouncementFile file;
  if (bytes.empty() || !file.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return {{}, "it is not an announcement"};
  }
  if (std::string fault = Fault(file); !fault.empty()) return {{}, std::move(fault)};
  return {Read(file), {}};
}

}  // namespace hgros::discovery
