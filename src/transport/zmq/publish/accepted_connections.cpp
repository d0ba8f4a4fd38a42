#include "transport/zmq/publish/accepted_connections.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "transport/zmq/endpoint.hpp"

namespace hgros::zmq {
namespace {

constexpr std::size_t kMostOfAny = 1024;  // As many sessions as an endpoint serves.
constexpr auto kSayCutAgainAfter = std::chrono::hours(1);

}  // namespace

std::size_t AcceptedConnections::MostOfOneAddress() noexcept {
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0) return kMostOfAny;
  return static_cast<std::size_t>(std::clamp<rlim_t>(files.rlim_cur / 4, 1, kMostOfAny));
}

std::string AcceptedConnections::OriginOf(int fd) const {
  const auto found = connections_.find(fd);
  return found == connections_.end() || found->second.address.empty() ? "this host" : found->second.address;
}

void AcceptedConnections::Cut(int fd, std::string_view limit, std::string_view what) {
  HangUp(fd, bound_);
  shared_.faults[static_cast<std::size_t>(PacketFault::kOverrun)].fetch_add(1, std::memory_order_relaxed);
  shared_.log.WriteLimited(LogLevel::kWarning, "zmq cut " + std::string(limit) + " " + bound_,
                           "A program on " + OriginOf(fd) + " that connects to " + bound_ + " " + std::string(what),
                           kSayCutAgainAfter);
}

bool AcceptedConnections::Add(int fd, std::string address, SteadyTime now) {
  const std::size_t most = MostOfOneAddress();
  const auto count = std::ranges::count_if(
      connections_, [&](const auto& entry) { return !address.empty() && entry.second.address == address; });
  const bool too_many = static_cast<std::size_t>(count) >= most;
  connections_[fd] = {.address = std::move(address), .since = now, .cut = too_many, .topics = {}};
  if (!too_many) return true;
  Cut(fd, "many",
      "has " + std::to_string(most) +
          " connections: further ones are closed, so that descriptors are left for others. Find the program, or raise "
          "the limit of open files (ulimit -n).");
  return false;
}

void AcceptedConnections::NoteSession(int fd) {
  const auto found = connections_.find(fd);
  if (found != connections_.end()) found->second.useful = true;
}

bool AcceptedConnections::CountTopic(int fd, std::string_view topic, bool subscribed) {
  const auto found = connections_.find(fd);
  if (found == connections_.end()) return true;  // It has ended. ZeroMQ unsubscribes for it.
  Connection& connection = found->second;
  if (connection.cut) return false;
  connection.useful = true;
  const auto known = connection.topics.find(topic);
  if (subscribed == (known != connection.topics.end())) return true;
  const std::size_t bytes = topic.size() + kBesidesTopicBytes;
  if (!subscribed) {
    connection.topics.erase(known);
    connection.topic_bytes -= bytes;
    return true;
  }
  if (connection.topic_bytes + bytes <= kMostTopicBytes) {
    connection.topics.emplace(topic);
    connection.topic_bytes += bytes;
    return true;
  }
  connection.cut = true;
  Cut(fd, "topics",
      "subscribes to too much over one connection: after " + std::to_string(connection.topics.size()) +
          " topics it is closed. Let it subscribe to the channels that it needs.");
  connection.topics.clear();
  return false;
}

void AcceptedConnections::CloseUseless(SteadyTime now) {
  for (auto& [fd, connection] : connections_) {
    if (connection.useful || connection.address.empty() || now - connection.since < kUselessAfter) continue;
    connection.since = now;
    Cut(fd, "useless",
        "has not subscribed to anything for " + std::to_string(kUselessAfter.count()) +
            " s: the connection is closed. Let it connect when it subscribes.");
  }
}

}  // namespace hgros::zmq
