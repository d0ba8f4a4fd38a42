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

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/codec/block.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// How a session's threads wait for messages in shared memory.
enum class ShmWait {
  kSleep,  ///< Costs nothing while nothing comes; waking a thread costs some microseconds.
  kSpin,   ///< Looks for ShmOptions::spin before it sleeps.
  kBusy,   ///< Looks all the time: the lowest latency, and one CPU for it.
};

struct ShmOptions {
  SessionId session;    ///< None: a random one.
  std::string process;  ///< This program's name, for people.
  /// Where other sessions of this host and user find us: a name in the abstract name space of unix sockets, of at most
  /// 100 bytes. Empty: `hgros-` and the session's id.
  std::string place;
  std::vector<std::string> peers;  ///< Places of other sessions; see ShmTransport::AddPeer().
  ShmWait wait = ShmWait::kSleep;
  std::chrono::microseconds spin{50};
  std::uint64_t limit_bytes = 256ULL << 20;  ///< Shared memory for payloads at most.
  std::chrono::milliseconds heartbeat{1000};
  std::chrono::milliseconds peer_timeout{5000};   ///< A peer that stands still for longer is gone.
  std::uint64_t peer_queue_bytes = 64ULL << 20;   ///< Waiting for one slow keep-last peer at most.
  std::uint64_t max_credit_bytes = 256ULL << 20;  ///< In flight to one subscriber of a channel at most.
  /// The largest message that is taken. Publishers are told, and keep larger ones from this session: both count them.
  std::uint64_t max_message_bytes = 1ULL << 30;
  std::chrono::milliseconds linger{500};  ///< Of the destructor's Close().
  /// Whether that session's messages on the channel are to be received here, and not by another carrier; empty: always.
  /// Must be quick, and must not call the transport.
  std::function<bool(SessionId publisher, std::string_view channel)> takes;
};

/// What a session's payloads take.
struct ShmUsage {
  std::uint64_t segment_bytes = 0;  ///< Held from the system.
  std::size_t segments = 0;
  std::size_t blocks_in_use = 0;  ///< Published and still read by somebody, or on loan.
  std::uint64_t sent_apart = 0;   ///< Messages for which there was no shared memory.
};

/// Messages between sessions of one user on one host, through shared memory: no daemon, nothing to clean up.
/// docs/shared-memory.md is the specification.
///
/// A payload is written once, for any number of sessions, into memory that they map for reading; what does not fit
/// there goes over the unix socket between two sessions, in its order, and is counted. Two sessions need one
/// connection, made by either of them.
///
/// Threading: thread-safe.
/// Fork: in a forked child Reserve() returns kClosed, Commit() does nothing, wiring throws Error; destructors leave the
/// memory to the end of the process.
class HGROS_EXPORT ShmTransport : public Transport {
 public:
  /// Connects to the session at `place`, again and again until RemovePeer(). One that is connected already, because it
  /// came to us, is not connected twice.
  virtual void AddPeer(const std::string& place) = 0;
  /// Connects no more; what is connected stays until either side ends.
  virtual void RemovePeer(const std::string& place) = 0;
  /// Sessions that were left to another carrier are asked about again, and what they publish is asked for.
  virtual void AskAgain() = 0;
  /// Where others find this session.
  [[nodiscard]] virtual const std::string& place() const noexcept = 0;

  /// A block in the memory that receivers will read: what is published from it is not copied. Nothing if the limit is
  /// reached.
  [[nodiscard]] virtual std::optional<Block> Loan(std::size_t size_bytes) = 0;
  [[nodiscard]] virtual ShmUsage usage() const = 0;

  /// Reads on the calling thread, which InboundSink::Accept() and Run() after kRunHere are called on. Returns at once
  /// if another thread does so.
  virtual void Receive(const Visit& visit) noexcept = 0;
  /// Whether the calling thread is in Receive().
  [[nodiscard]] static bool IsVisitor() noexcept;
};

/// Errors: throws Error if there is no shared memory here or somebody else is at the place. `listener` and `log`
/// outlive the transport.
[[nodiscard]] HGROS_EXPORT std::unique_ptr<ShmTransport> MakeShmTransport(ShmOptions options,
                                                                          TransportListener& listener, Log& log);

}  // namespace hgros
