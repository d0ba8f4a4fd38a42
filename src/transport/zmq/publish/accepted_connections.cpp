#include "transport/zmq/publish/accepted_connections.hpp"

#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <unordered_set>
#include <utility>

#include "hgros/base/memory_room.hpp"
#include "transport/zmq/connection.hpp"

namespace hgros::zmq {
namespace {

constexpr std::size_t kMostOfAny = 1024;  // As many sessions as an endpoint serves.
constexpr auto kSayCutAgainAfter = std::chrono::hours(1);
constexpr std::uint64_t kGreetingBytes = 64;  // Of ZMTP 3: https://rfc.zeromq.org/spec/23
constexpr auto kLookAgainAfter = std::chrono::milliseconds(50);
constexpr int kStuckAfterLooks = 4;
constexpr auto kLastWords = std::chrono::seconds(1);

constexpr std::size_t kFewTopicBytes = 1024;  // As plain subscribers have.
constexpr std::size_t kMemoryPerTopicByte = 40;
constexpr std::size_t kMostPartOfFreeMemory = 8;

bool HasGreeted(int fd) { return BytesReceived(fd).value_or(kGreetingBytes) >= kGreetingBytes; }

// Whether the other side has not read for so long that the send buffer is nearly full.
bool IsFull(int fd) {
  int waiting = 0;
  int buffer = 0;
  socklen_t size = sizeof buffer;
  if (ioctl(fd, SIOCOUTQ, &waiting) != 0 || getsockopt(fd, SOL_SOCKET, SO_SNDBUF, &buffer, &size) != 0) return false;
  return waiting >= buffer / 4;  // The system counts its own data structures as well.
}

}  // namespace

std::size_t AcceptedConnections::MostTopicBytes() {
  const auto free = FreeMemory();
  if (!free) return kMostTopicBytesOfAll;
  return std::clamp<std::size_t>(*free / kMostPartOfFreeMemory / kMemoryPerTopicByte, 2 * kMostTopicBytes,
                                 kMostTopicBytesOfAll);
}

std::size_t AcceptedConnections::MostOfOneAddress() noexcept {
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0) return kMostOfAny;
  return static_cast<std::size_t>(std::clamp<rlim_t>(files.rlim_cur / 4, 1, kMostOfAny));
}

bool AcceptedConnections::HasAddress(int fd) const {
  const auto found = connections_.find(fd);
  return found != connections_.end() && !found->second.address.empty();
}

std::string AcceptedConnections::OriginOf(int fd) const {
  if (HasAddress(fd)) return connections_.at(fd).address;
  return bound_.starts_with("ipc:") ? "this host" : "a host whose address is not known any more";
}

void AcceptedConnections::Report(int fd, std::string_view limit, std::string_view what) {
  shared_.faults[static_cast<std::size_t>(PacketFault::kOverrun)].fetch_add(1, std::memory_order_relaxed);
  shared_.log.WriteLimited(LogLevel::kWarning, "zmq cut " + std::string(limit) + " " + bound_,
                           "A program on " + OriginOf(fd) + " that connects to " + bound_ + " " + std::string(what),
                           kSayCutAgainAfter);
}

void AcceptedConnections::Cut(int fd, std::string_view limit, std::string_view what) {
  HangUp(fd, bound_);
  Report(fd, limit, what);
}

bool AcceptedConnections::Add(int fd, std::string address, SteadyTime now) {
  Remove(fd);  // The earlier connection with this number.
  const std::size_t most = MostOfOneAddress();
  const auto count = std::ranges::count_if(
      connections_, [&](const auto& entry) { return !address.empty() && entry.second.address == address; });
  const bool too_many = static_cast<std::size_t>(count) >= most;
  Connection& added = connections_[fd];
  added.address = std::move(address);
  added.since = added.progress_at = added.reading_at = now;
  added.cut = too_many;
  if (too_many) {
    Cut(fd, "many",
        "has " + std::to_string(most) +
            " connections: further ones are closed, so that descriptors are left for others. Find the program, or "
            "raise the limit of open files (ulimit -n).");
    return false;
  }
  if (added.address.empty() || MayBeSilent(added)) {
    added.silent = !added.address.empty();
    added.unread.Watch(fd);
    return true;
  }
  HangUp(fd, bound_);
  shared_.log.WriteLimited(LogLevel::kWarning, "zmq silent " + bound_,
                           "More than " + std::to_string(kMostSilent) + " connections from " + added.address + " to " +
                               bound_ + " say nothing: further ones are closed. Find the program that makes them.",
                           kSayCutAgainAfter);
  return false;
}

// Asks the system only about as many as could be too many.
bool AcceptedConnections::MayBeSilent(const Connection& added) {
  const auto of_added = [&](const auto& entry) { return entry.second.silent && entry.second.address == added.address; };
  auto count = static_cast<std::size_t>(std::ranges::count_if(connections_, of_added));
  if (count < kMostSilent) return true;
  count = 0;
  for (auto& [fd, connection] : connections_) {
    if (!connection.silent) continue;
    connection.silent = !HasGreeted(fd);
    count += connection.silent && connection.address == added.address ? 1 : 0;
  }
  return count < kMostSilent;
}

void AcceptedConnections::Remove(int fd) {
  const auto found = connections_.find(fd);
  if (found == connections_.end()) return;
  ReleaseAll(found->second);
  if (found->second.speaker.proof) {
    ended_[fd] = found->second.speaker;
  } else {
    ended_.erase(fd);
  }
  connections_.erase(found);
}

void AcceptedConnections::Clear() {
  for (auto& [fd, connection] : connections_) ReleaseAll(connection);
  connections_.clear();
  ended_.clear();
}

bool AcceptedConnections::NoteSession(int fd, SessionId session) {
  const auto found = connections_.find(fd);
  if (found == connections_.end()) return true;
  ended_.erase(fd);
  Connection& connection = found->second;
  if (connection.cut) return false;
  if (connection.speaker.session.value != 0 && connection.speaker.session != session) {
    connection.cut = true;
    Cut(fd, "sessions", "names several sessions over one connection: it is closed. Find the program.");
    return false;
  }
  connection.speaker.session = session;
  NoteUse(fd, connection);
  connection.plain = false;
  return true;
}

void AcceptedConnections::NoteUse(int fd, Connection& connection) noexcept {
  if (std::exchange(connection.idle, false)) KeepWhenClosed(fd, bound_);
}

void AcceptedConnections::NoteProof(int fd, std::uint64_t proof) {
  const auto found = connections_.find(fd);
  if (found != connections_.end()) found->second.speaker.proof = proof;
}

bool AcceptedConnections::MaySpeakFor(int fd, SessionId session, std::uint64_t proof) const {
  const auto may = [&](const Speaker& speaker) { return speaker.session == session && speaker.proof == proof; };
  const auto found = connections_.find(fd);
  if (found != connections_.end() && may(found->second.speaker)) return true;
  // The system has given its number to a new connection, and its last messages are read now.
  if (found != connections_.end() && std::chrono::steady_clock::now() - found->second.since > kLastWords) return false;
  const auto ended = ended_.find(fd);
  return ended != ended_.end() && may(ended->second);
}

void AcceptedConnections::NotePlain(int fd) {
  const auto found = connections_.find(fd);
  if (found != connections_.end()) found->second.plain = true;
}

bool AcceptedConnections::CountTopic(int fd, std::string_view topic, bool subscribed) {
  const auto found = connections_.find(fd);  // If it has ended, ZeroMQ unsubscribes for it.
  if (found != connections_.end() && !found->second.cut) {
    Connection& connection = found->second;
    NoteUse(fd, connection);
    if (subscribed) ended_.erase(fd);
    if (subscribed) return Hold(fd, connection, topic);
    if (const auto known = connection.topics.find(topic); known != connection.topics.end()) {
      connection.topic_bytes -= topic.size() + kBesidesTopicBytes;
      connection.topics.erase(known);
      Release(topic);
    }
  } else if (subscribed) {
    return found == connections_.end();
  }
  // A connection may also unsubscribe from what it has not subscribed to.
  return !holders_.contains(topic);
}

bool AcceptedConnections::Hold(int fd, Connection& connection, std::string_view topic) {
  if (connection.topics.contains(topic)) return false;
  const std::size_t before = connection.topic_bytes;
  connection.topic_bytes += topic.size() + kBesidesTopicBytes;
  if (BytesOf(connection) > 2 * kMostTopicBytes) {
    CutTooLarge(fd, connection);
    return false;
  }
  if (before <= kMostTopicBytes && connection.topic_bytes > kMostTopicBytes) {
    Report(fd, "topics",
           "subscribes to too much over one connection, which has " + std::to_string(connection.topics.size()) +
               " topics now. At twice as much it is closed. Let it subscribe to the channels that it needs.");
  }
  connection.topics.emplace(topic);
  const auto held = holders_.find(topic);
  if (held == holders_.end()) {
    holders_.emplace(topic, 1);
    topic_bytes_ += topic.size() + kBesidesTopicBytes;
    if (topic_bytes_ > most_topic_bytes_) CutLargest();
  } else {
    ++held->second;
  }
  return !connection.cut;
}

bool AcceptedConnections::CountWishes(int fd, SessionId session, std::size_t bytes) {
  topic_bytes_ += bytes - std::exchange(wish_bytes_[session], bytes);
  const auto found = connections_.find(fd);
  if (found != connections_.end() && found->second.cut) return false;
  if (found != connections_.end() && BytesOf(found->second) > 2 * kMostTopicBytes) {
    CutTooLarge(fd, found->second);
  } else if (topic_bytes_ > most_topic_bytes_) {
    CutLargest();
  }
  return found == connections_.end() || !found->second.cut;
}

void AcceptedConnections::ForgetWishes(SessionId session) {
  const auto found = wish_bytes_.find(session);
  if (found == wish_bytes_.end()) return;
  topic_bytes_ -= found->second;
  wish_bytes_.erase(found);
}

std::size_t AcceptedConnections::BytesOf(const Connection& connection) const {
  const auto wishes = connection.speaker.proof ? wish_bytes_.find(connection.speaker.session) : wish_bytes_.end();
  return connection.topic_bytes + (wishes == wish_bytes_.end() ? 0 : wishes->second);
}

void AcceptedConnections::CutTooLarge(int fd, Connection& connection) {
  connection.cut = true;
  Cut(fd, "twice too many topics",
      "subscribes to twice as much as one connection may: after " + std::to_string(connection.topics.size()) +
          " topics it is closed. Let it subscribe to the channels that it needs.");
  ReleaseAll(connection);
}

void AcceptedConnections::CutLargest() {
  // One program may have many connections: those without a Hello end before a session's.
  std::pair<bool, std::size_t> most;
  int largest = -1;
  std::unordered_set<SessionId> here;
  for (const auto& [fd, connection] : connections_) {
    if (connection.cut) continue;
    if (connection.speaker.proof) here.insert(connection.speaker.session);
    const std::size_t bytes = BytesOf(connection);
    const std::pair one(!connection.speaker.proof && bytes > kFewTopicBytes, bytes);
    if (largest >= 0 && one <= most) continue;
    most = one;
    largest = fd;
  }
  SessionId away{};
  for (const auto& [session, bytes] : wish_bytes_) {
    if (here.contains(session) || std::pair(false, bytes) < most) continue;
    most = {false, bytes};
    away = session;
  }
  if (away.value != 0) {
    given_up_.push_back(away);
    ForgetWishes(away);
  } else if (largest >= 0) {
    Connection& connection = connections_.at(largest);
    connection.cut = true;
    Cut(largest, "topics of all",
        "subscribes to most of all connections, whose topics are too many together: it is closed. Let each subscribe "
        "to the channels that it needs.");
    ReleaseAll(connection);
  }
}

void AcceptedConnections::ReleaseAll(Connection& connection) {
  for (const std::string& topic : connection.topics) Release(topic);
  connection.topics.clear();
  connection.topic_bytes = 0;
}

void AcceptedConnections::Release(std::string_view topic) {
  const auto held = holders_.find(topic);
  if (held == holders_.end() || --held->second > 0) return;
  topic_bytes_ -= held->first.size() + kBesidesTopicBytes;
  holders_.erase(held);
}

void AcceptedConnections::CountSent(int fd, std::size_t bytes) {
  const auto found = connections_.find(fd);
  if (found == connections_.end() || found->second.cut || !found->second.unread.Add(bytes)) return;
  found->second.cut = true;
  Cut(fd, "unread",
      "does not read the answers to its messages: the connection is closed, because they would fill the memory. Find "
      "the program.");
  ReleaseAll(found->second);
}

void AcceptedConnections::CloseIdle(SteadyTime now) {
  for (auto& [fd, connection] : connections_) {
    if (!connection.idle || connection.address.empty() || now - connection.since < kIdleAfter) continue;
    connection.since = now;
    Cut(fd, "idle",
        "has not subscribed to anything for " + std::to_string(kIdleAfter.count()) +
            " s: the connection is closed. Let it connect when it subscribes.");
  }
}

// Before the kernel does: what it closes has an error (docs/decisions/0050).
bool AcceptedConnections::CloseDead(SteadyTime now) {
  bool left_alone = false;
  const bool asks_unread = shared_.options.security.has_value();  // Only then ZeroMQ leaves connections alone.
  for (auto& [fd, connection] : connections_) {
    const auto progress = connection.address.empty() ? std::nullopt : ProgressOf(fd, asks_unread);
    if (!progress) continue;
    const Progress before = std::exchange(connection.progress, *progress);
    if (!progress->waits || progress->acknowledged != before.acknowledged) connection.progress_at = now;
    const bool has_end = progress->ended && before.ended;
    const bool has_more = progress->unread && before.unread;
    if (!(has_end || has_more) || progress->read != before.read) connection.reading_at = now;
    left_alone = left_alone || now - connection.reading_at > kLeftAloneAfter;
    // If the other side is gone, it answers what comes again with a reset. Nothing has come from it that could wait
    // here.
    const bool heeds = progress->unanswered;
    if (std::exchange(connection.heeds_resets, heeds) != heeds) SetIgnoresResets(fd, bound_, !heeds);
    if (now - connection.progress_at <= 2 * shared_.options.peer_timeout) continue;
    connection.progress_at = now;
    HangUp(fd, bound_);
  }
  return left_alone;
}

void AcceptedConnections::CutStuckPlain(SteadyTime now) {
  if (now < next_look_) return;
  const bool first = now > next_look_ + kLookAgainAfter;  // For a while.
  next_look_ = now + kLookAgainAfter;
  std::size_t with_room = 0;
  for (auto& [fd, connection] : connections_) {
    if (!connection.plain) continue;
    connection.full_looks = IsFull(fd) ? (first ? 0 : connection.full_looks) + 1 : 0;
    with_room += connection.full_looks == 0 ? 1 : 0;
  }
  if (with_room == 0) return;
  for (auto& [fd, connection] : connections_) {
    if (!connection.plain || connection.full_looks < kStuckAfterLooks) continue;
    HangUp(fd, bound_);
    connection.full_looks = 0;
    shared_.log.WriteLimited(LogLevel::kWarning, "zmq stuck " + bound_,
                             "A plain subscriber at " + bound_ +
                                 " does not read fast enough: its connection is closed, so that others get their "
                                 "messages. Let it read faster, or subscribe to less.");
  }
}

}  // namespace hgros::zmq
