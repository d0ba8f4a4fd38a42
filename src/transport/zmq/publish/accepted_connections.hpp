#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hgros/base/ids.hpp"
#include "transport/zmq/connection.hpp"
#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/unread_bytes.hpp"

namespace hgros::zmq {

/// Limits of the connections that a publish endpoint has accepted. What exceeds one is closed, and logged once an hour.
/// What has an asterisk is counted as PacketFault::kOverrun.
///
/// - At most kMostSilent tcp connections of one address may exist that have not sent a whole greeting of ZMTP. ZeroMQ
///   itself closes each after ConnectionWatch::kHandshakeMs.
/// - One address may have MostOfOneAddress() tcp connections.*
/// - A tcp connection that has neither subscribed to anything nor said Hello is closed after kIdleAfter.*
/// - A connection whose topics have more than kMostTopicBytes is named*, and closed at twice as many*. ZeroMQ takes up
///   to 32 bytes for each of them.
/// - The same for the channels that its session asks for. Each of their bytes counts as an eighth of one.
/// - If these bytes of all connections, and of sessions that may come back, are more than MostTopicBytes(), the one
///   with most is closed.* A session's, after its Hello, is closed only if no other has more than a few.
/// - A connection that does not read the control messages that it gets (UnreadBytes) is closed.*
/// - A connection belongs to one session. Each that it names would get a Welcome, which it need not read.*
/// - A plain subscriber that does not read is closed before it uses up the bytes that all plain subscribers share.
///
/// Thread safety: none; the endpoint's mutex guards it.
class AcceptedConnections {
 public:
  static constexpr std::size_t kMostSilent = 64;
  /// Enough for 16384 channels of a session, with names of 30 characters.
  static constexpr std::size_t kMostTopicBytes = 1u << 20;
  static constexpr std::size_t kBesidesTopicBytes = 16;  // Counted for each topic.
  /// Each of them takes about 40 bytes of memory.
  static constexpr std::size_t kMostTopicBytesOfAll = 8 * kMostTopicBytes;
  static constexpr auto kIdleAfter = std::chrono::seconds(30);

  /// `bound` may be set later.
  AcceptedConnections(SharedState& shared, const std::string& bound) : shared_(shared), bound_(bound) {}

  /// kMostTopicBytesOfAll, or less if they would take more than an eighth of the free memory.
  [[nodiscard]] static std::size_t MostTopicBytes();
  /// A quarter of the descriptors that this process may have.
  [[nodiscard]] static std::size_t MostOfOneAddress() noexcept;

  /// `address` is empty if it is not an IP connection. False if the connection was closed.
  [[nodiscard]] bool Add(int fd, std::string address, SteadyTime now);
  void Remove(int fd);
  void Clear();
  /// The address of its program is known.
  [[nodiscard]] bool HasAddress(int fd) const;
  /// Where it comes from, for the log.
  [[nodiscard]] std::string OriginOf(int fd) const;
  /// It is that of a session. False if it is that of another one: then the connection was closed.
  [[nodiscard]] bool NoteSession(int fd, SessionId session);
  /// A Hello with this proof was accepted from it.
  void NoteProof(int fd, std::uint64_t proof);
  /// Whether a message over this connection may be from that session, whose Hellos have this proof. It may be read
  /// after its connection has ended.
  [[nodiscard]] bool MaySpeakFor(int fd, SessionId session, std::uint64_t proof) const;
  /// It is that of a plain subscriber.
  void NotePlain(int fd);
  /// The connection with this descriptor has subscribed to `topic`, or no longer; negative: ZeroMQ says so of one that
  /// has ended. False if that is to be ignored: the connection was closed, it holds the topic already, or another one
  /// still holds it.
  [[nodiscard]] bool CountTopic(int fd, std::string_view topic, bool subscribed);
  /// The channels that the session of this connection asks for have this size now, until ForgetWishes(), even if the
  /// connection ends. False if the connection was closed.
  [[nodiscard]] bool CountWishes(int fd, SessionId session, std::size_t bytes);
  void ForgetWishes(SessionId session);
  /// The sessions without a connection whose wishes are to be dropped: they are too large, and forgotten here.
  [[nodiscard]] std::vector<SessionId> CollectGivenUp() { return std::exchange(given_up_, {}); }
  /// A control message of this size was sent to it.
  void CountSent(int fd, std::size_t bytes);
  void CloseIdle(SteadyTime now);
  /// Closes those whose other side has got nothing for twice the peer timeout, and lets the kernel close those whose
  /// other side is gone. To be called once per heartbeat. True if ZeroMQ has left one alone: then only all
  /// connections can be closed together.
  [[nodiscard]] bool CloseDead(SteadyTime now);
  /// To be called for each plain message while more than half of the shared bytes are in use. Closes the connections
  /// whose send buffers have been full for a while, if there are others with room.
  void CutStuckPlain(SteadyTime now);
  /// Closes the connection, counts this, and logs it once an hour. `what` begins with a verb.
  void Cut(int fd, std::string_view limit, std::string_view what);

 private:
  struct Speaker {
    SessionId session = {};              // Zero: not that of a session, so far.
    std::optional<std::uint64_t> proof;  // Of the Hello that was accepted.
  };
  struct Connection {
    std::string address;
    SteadyTime since{};
    bool silent = false;  // It may not have sent a greeting.
    bool idle = true;
    bool plain = false;
    bool cut = false;
    Speaker speaker;
    UnreadBytes unread;
    Progress progress;
    SteadyTime progress_at{};
    SteadyTime reading_at{};
    bool heeds_resets = false;
    int full_looks = 0;  // How often in a row the send buffer was full.
    std::size_t topic_bytes = 0;
    std::set<std::string, std::less<>> topics;
  };
  struct Hash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const noexcept { return std::hash<std::string_view>()(text); }
  };

  void Report(int fd, std::string_view limit, std::string_view what);
  [[nodiscard]] bool MayBeSilent(const Connection& added);
  /// Something is sent over it from now on.
  void NoteUse(int fd, Connection& connection) noexcept;
  /// False if the connection was closed.
  [[nodiscard]] bool Hold(int fd, Connection& connection, std::string_view topic);
  void Release(std::string_view topic);
  void ReleaseAll(Connection& connection);
  [[nodiscard]] std::size_t BytesOf(const Connection& connection) const;
  void CutLargest();
  void CutTooLarge(int fd, Connection& connection);

  SharedState& shared_;
  const std::string& bound_;
  std::unordered_map<int, Connection> connections_;  // By descriptor.
  // The sessions of connections that have ended, until another one with their descriptor speaks.
  std::unordered_map<int, Speaker> ended_;
  std::size_t most_topic_bytes_ = MostTopicBytes();
  std::size_t topic_bytes_ = 0;  // Of all topics in `holders_`, and of all wishes.
  std::unordered_map<SessionId, std::size_t> wish_bytes_;
  std::vector<SessionId> given_up_;
  // How many connections hold a topic.
  std::unordered_map<std::string, std::size_t, Hash, std::equal_to<>> holders_;
  SteadyTime next_look_{};
};

}  // namespace hgros::zmq
