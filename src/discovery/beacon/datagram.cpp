#include "discovery/beacon/datagram.hpp"

#include <arpa/inet.h>

#include <cstdint>
#include <utility>

#include "discovery/registry/announcement_file.hpp"
#include "hgros/announcement.pb.h"
#include "hgros/base/error.hpp"
#include "hgros/base/readable_text.hpp"

namespace hgros::discovery {
namespace {

constexpr std::string_view kTcp = "tcp://";
constexpr std::string_view kDigits = "0123456789";
constexpr std::size_t kMaxPortDigits = 5;

struct Endpoint {
  std::string_view host;
  std::string_view port;
};

// The parts of "tcp://HOST:PORT" with an IPv4 address or "*" as host; nothing for any other text. Names are refused:
// ZeroMQ would look them up on the thread that serves all connections, which stop for as long as that takes.
std::optional<Endpoint> SplitTcp(std::string_view text) {
  if (text.size() > kMaxAnnouncedTextBytes || !text.starts_with(kTcp)) return std::nullopt;
  text.remove_prefix(kTcp.size());
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const Endpoint parts{text.substr(0, colon), text.substr(colon + 1)};
  if (parts.port.empty() || parts.port.size() > kMaxPortDigits ||
      parts.port.find_first_not_of(kDigits) != std::string_view::npos) {
    return std::nullopt;
  }
  const int port = std::stoi(std::string(parts.port));
  if (port == 0 || port > 0xffff) return std::nullopt;
  in_addr address{};
  if (parts.host != "*" && inet_pton(AF_INET, std::string(parts.host).c_str(), &address) != 1) return std::nullopt;
  return parts;
}

// Not an address of the own host (0.0.0.0/8, 127.0.0.0/8), of a group or of all: a forged datagram could lead a session
// to endpoints that are meant for its host only.
bool IsReachableFromElsewhere(const Endpoint& endpoint) {
  in_addr address{};
  if (endpoint.host == "*" || inet_pton(AF_INET, std::string(endpoint.host).c_str(), &address) != 1) return true;
  constexpr std::uint32_t kLoopback = 127;
  constexpr std::uint32_t kFirstGroup = 224;
  const std::uint32_t first = ntohl(address.s_addr) >> 24U;
  return first != 0 && first != kLoopback && first < kFirstGroup;
}

}  // namespace

std::string EncodeDatagram(const Announcement& own, std::string_view domain, bool ends) {
  wire::BeaconDatagram datagram;
  datagram.set_magic(kDatagramMagic);
  datagram.set_version(kDatagramVersion);
  datagram.set_domain(std::string(domain));
  datagram.set_session(own.session.value);
  datagram.set_incarnation(own.incarnation);
  datagram.set_process(Readable(own.process, kMaxAnnouncedTextBytes));
  datagram.set_host(Readable(own.host, kMaxAnnouncedTextBytes));
  datagram.set_pid(own.pid);
  datagram.set_ends(ends);
  for (std::string endpoint : own.endpoints) {
    // In ZeroMQ another spelling of all addresses.
    if (endpoint.starts_with("tcp://0.0.0.0:")) endpoint.replace(kTcp.size(), 7, "*");
    const auto parts = SplitTcp(endpoint);
    if (parts && IsReachableFromElsewhere(*parts)) datagram.add_endpoints(endpoint);
  }
  std::string bytes = datagram.SerializeAsString();
  if (own.session.value == 0 || datagram.endpoints_size() > static_cast<int>(kMaxEndpoints) ||
      bytes.size() > kMaxDatagramBytes) {
    throw Error("This session cannot be announced on the network: it has no id, or its datagram of " +
                    std::to_string(bytes.size()) + " bytes and " + std::to_string(datagram.endpoints_size()) +
                    " tcp endpoints is larger than the " + std::to_string(kMaxDatagramBytes) + " bytes and " +
                    std::to_string(kMaxEndpoints) + " endpoints that others read.",
                {}, "Announce fewer endpoints.");
  }
  return bytes;
}

std::optional<Heard> ParseDatagram(Bytes bytes, std::string_view domain, const std::string& sender) {
  if (bytes.empty() || bytes.size() > kMaxDatagramBytes) return std::nullopt;
  wire::BeaconDatagram datagram;
  if (!datagram.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return std::nullopt;
  if (datagram.magic() != kDatagramMagic || datagram.version() != kDatagramVersion || datagram.domain() != domain ||
      datagram.session() == 0 || datagram.endpoints_size() > static_cast<int>(kMaxEndpoints)) {
    return std::nullopt;
  }
  Heard heard;
  heard.ends = datagram.ends();
  heard.peer.session = {datagram.session()};
  heard.peer.incarnation = datagram.incarnation();
  heard.peer.process = Readable(datagram.process(), kMaxAnnouncedTextBytes);
  heard.peer.host = Readable(datagram.host(), kMaxAnnouncedTextBytes);
  heard.peer.pid = datagram.pid();
  heard.peer.sender = sender;
  for (const std::string& endpoint : datagram.endpoints()) {
    const auto parts = SplitTcp(endpoint);
    if (!parts || !IsReachableFromElsewhere(*parts)) continue;  // From a newer version, or invalid.
    const std::string host = parts->host == "*" ? sender : std::string(parts->host);
    heard.peer.endpoints.push_back(std::string(kTcp) + host + ":" + std::string(parts->port));
  }
  return heard;
}

}  // namespace hgros::discovery
