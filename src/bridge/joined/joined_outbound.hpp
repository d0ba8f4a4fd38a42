#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "bridge/joined/cut_subscribers.hpp"
#include "hgros/base/log.hpp"
#include "hgros/transport/call_gate.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// One advertised channel over all transports of a session. A message is promised by all of them or by none, and
/// passed to all. Each subscriber decides over which transport it receives. If a transport loses a lossless
/// subscriber, its unconfirmed messages are kept, and those that are published until it is back.
///
/// Thread safety: all functions. Invariants: a transport that was added stays until the end.
class JoinedOutbound : public std::enable_shared_from_this<JoinedOutbound> {
 public:
  /// Stops waiting for a subscriber. `name`: its session's, for the log.
  using Abandon = std::function<void(const std::string& name)>;
  /// A transport has lost the subscriber: `give_up` must be called later, after the time in which it could have come
  /// back. Called under that transport's lock.
  using Await = std::function<void(SessionId subscriber, Abandon give_up)>;

  /// `most_transports`: how many can be added. `log` outlives it.
  JoinedOutbound(std::string channel, const TypeInfo& type, OutboundSource& source, std::size_t most_transports,
                 Await await, Log& log);
  ~JoinedOutbound();
  JoinedOutbound(const JoinedOutbound&) = delete;
  JoinedOutbound& operator=(const JoinedOutbound&) = delete;

  void Add(Transport& transport);
  [[nodiscard]] const std::string& channel() const noexcept { return channel_; }

  [[nodiscard]] std::size_t subscriber_count() const noexcept;
  /// The sessions that subscribe now, each once; without those that were lost and may come back.
  [[nodiscard]] std::vector<SessionId> Subscribers() const;
  PublishStatus Reserve() noexcept;
  /// See OutboundChannel. A lack of memory is logged.
  bool Commit(const PacketHead& head, const Payload& data) noexcept;
  void Cancel() noexcept;
  /// Memory of a transport that has subscribers. Takes long if the transport must get it from the system.
  [[nodiscard]] std::optional<Block> Loan(std::size_t size_bytes);
  /// The same for a message of which `written` is its large part, in memory already. No loan is needed if this is in
  /// memory of a transport. False if there is no loan, and not enough ordinary memory.
  [[nodiscard]] bool FindMemory(std::size_t size_bytes, Bytes written, std::optional<Block>& loan);
  [[nodiscard]] OutboundStats stats() const;
  /// Number of messages that are on their way to lossless subscribers.
  [[nodiscard]] std::size_t Unfinished() const;
  /// Stops waiting for the subscriber, and logs what it misses. With a number, only if this is its latest cut.
  void GiveUp(SessionId subscriber, const std::string& name, std::optional<std::uint64_t> cut = std::nullopt);
  /// Leaves the transports and waits for active calls into the source, which may end afterwards. No other function but
  /// Add() and GiveUp() may run meanwhile or later; these two do nothing then.
  void Close();

 private:
  class Part;
  [[nodiscard]] std::span<const std::unique_ptr<Part>> Parts() const noexcept {
    return std::span(parts_).first(count_.load(std::memory_order_acquire));
  }
  void SayNoMemory() noexcept;
  void Keep(SessionId subscriber, const Demand& demand, std::vector<OutboundMessage>&& unfinished);
  // The messages that a subscriber gets first.
  [[nodiscard]] std::vector<OutboundMessage> First(SessionId subscriber);
  void TellSubscribers();
  // Called for each end of a subscriber over a transport. True if it has ended over all that it had at the first one.
  [[nodiscard]] bool HasEnded(SessionId subscriber, std::size_t part);
  // Whether `holds` is true for the channel of a transport that has subscribers.
  template <typename Holds>
  [[nodiscard]] bool AnyListened(const Holds& holds) const;

  const std::string channel_;
  const TypeInfo& type_;
  OutboundSource& source_;
  const Await await_;
  Log& log_;
  CutSubscribers cut_;
  std::mutex committing_;             // A cut subscriber does not come back between a message's transports and cut_.
  std::int64_t last_ns_ = 0;          // When a message was committed last; guarded by committing_.
  std::atomic<bool> refused_{false};  // There was no room for subscribers that are cut off.
  std::atomic<std::uint64_t> missed_{0};
  std::mutex adding_;
  bool no_more_parts_ = false;                // Guarded by adding_.
  std::vector<std::unique_ptr<Part>> parts_;  // Never resized: it is read while a part is added.
  std::atomic<std::size_t> count_{0};
  CallGate gate_;  // For calls of the bridge into the source.
  // The sum is computed and reported under one lock, so that the last reported value is right.
  std::mutex telling_;
  std::vector<std::size_t> subscribers_;               // By part.
  std::map<SessionId, std::set<std::size_t>> ending_;  // The parts over which it has not ended; guarded by telling_.
};

}  // namespace hgros
