#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/codec/block.hpp"
#include "hgros/transport/shm_wait.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

struct ShmOptions {
  SessionId session;    ///< None: a random one.
  std::string process;  ///< This program's name, for logs.
  /// Where other sessions of this host and user find this one: a name of at most 100 bytes in the abstract namespace of
  /// unix sockets. Empty: `hgros-` and the session's id.
  std::string place;
  std::vector<std::string> peers;  ///< Places of other sessions; see Transport::AddPeer().
  ShmWait wait = ShmWait::kSleep;
  std::chrono::microseconds spin{50};
  std::uint64_t limit_bytes = 256ULL << 20;  ///< Maximum shared memory for payloads.
  std::chrono::milliseconds heartbeat{1000};
  std::chrono::milliseconds peer_timeout{5000};   ///< A peer that is silent for longer is gone.
  std::uint64_t peer_queue_bytes = 64ULL << 20;   ///< Maximum that waits for one slow keep-last peer.
  std::uint64_t max_credit_bytes = 256ULL << 20;  ///< Maximum in flight to one subscriber of a channel.
  /// The largest message that is received. Publishers know it and do not send larger ones; both sides count them.
  std::uint64_t max_message_bytes = kMaxMessageBytes;
  std::chrono::milliseconds linger{500};  ///< How long the destructor waits for messages to be sent.
  /// Whether to receive that session's messages on the channel here, and not over another transport. Empty: always.
  /// Must be quick, and must not call the transport.
  std::function<bool(SessionId publisher, std::string_view channel)> takes;
};

/// The memory that a session's payloads use.
struct ShmUsage {
  std::uint64_t segment_bytes = 0;  ///< Allocated from the system.
  std::size_t segments = 0;
  std::size_t blocks_in_use = 0;  ///< Published and still in use, or on loan.
  std::uint64_t sent_apart = 0;   ///< Messages sent over the socket: there was no shared memory for them.
};

/// The transport for sessions of one user on one host: shared memory. It needs no daemon, and leaves nothing to clean
/// up. docs/shared-memory.md is the specification.
///
/// A payload is written once, for any number of sessions, into memory that they map for reading. If there is no memory
/// left, it goes over the unix socket between two sessions, in order with the others, and is counted. Two sessions need
/// one connection; either of them may make it.
///
/// Threading: thread-safe.
/// Fork: in a forked child Reserve() returns kClosed, Commit() does nothing, and wiring throws Error; destructors leave
/// the memory to the end of the process.
class ShmTransport : public Transport {
 public:
  /// A block in the memory that receivers will read: publishing it copies nothing. Empty if the limit is reached.
  [[nodiscard]] virtual std::optional<Block> Loan(std::size_t size_bytes) = 0;
  [[nodiscard]] virtual ShmUsage usage() const = 0;
};

/// Errors: throws Error if there is no shared memory, or another session has the place. `listener` and `log` outlive
/// the transport.
[[nodiscard]] std::unique_ptr<ShmTransport> MakeShmTransport(ShmOptions options, TransportListener& listener, Log& log);

}  // namespace hgros
