#pragma once

#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>

#include "transport/zmq/shared_state.hpp"

namespace hgros::zmq {

/// Limits of the connections that a publish endpoint has accepted. What exceeds one is closed, counted as
/// PacketFault::kOverrun and logged.
///
/// - One address may have MostOfOneAddress() tcp connections.
/// - A tcp connection that has neither subscribed to anything nor said Hello is closed after kUselessAfter.
/// - The topics that one connection subscribes to may have kMostTopicBytes. ZeroMQ takes up to 32 bytes for each of
/// them.
///
/// Thread safety: none; the endpoint's mutex guards it.
class AcceptedConnections {
 public:
  /// Enough for 16384 channels of a session, with names of 30 characters.
  static constexpr std::size_t kMostTopicBytes = 1u << 20;
  static constexpr std::size_t kBesidesTopicBytes = 16;  // Counted for each topic.
  static constexpr auto kUselessAfter = std::chrono::seconds(30);

  /// `bound` may be set later.
  AcceptedConnections(SharedState& shared, const std::string& bound) : shared_(shared), bound_(bound) {}

  /// A quarter of the descriptors that this process may have.
  [[nodiscard]] static std::size_t MostOfOneAddress() noexcept;

  /// `address` is empty if it is not an IP connection. False if the connection was closed.
  [[nodiscard]] bool Add(int fd, std::string address, SteadyTime now);
  void Remove(int fd) { connections_.erase(fd); }
  /// Where it comes from, for the log.
  [[nodiscard]] std::string OriginOf(int fd) const;
  /// It is that of a session.
  void NoteSession(int fd);
  /// False if the connection was closed, because it subscribes to too much.
  [[nodiscard]] bool CountTopic(int fd, std::string_view topic, bool subscribed);
  void CloseUseless(SteadyTime now);
  /// Closes the connection, counts this, and logs it once an hour. `what` begins with a verb.
  void Cut(int fd, std::string_view limit, std::string_view what);

 private:
  struct Connection {
    std::string address;
    SteadyTime since{};
    bool useful = false;
    bool cut = false;
    std::size_t topic_bytes = 0;
    std::set<std::string, std::less<>> topics;
  };

  SharedState& shared_;
  const std::string& bound_;
  std::unordered_map<int, Connection> connections_;  // By descriptor.
};

}  // namespace hgros::zmq
