#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "hgros/base/bytes.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/base/publish_status.hpp"
#include "hgros/codec/block.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "hgros/transport/demand.hpp"
#include "hgros/transport/transport_stats.hpp"

namespace hgros {

/// One message of this session on its way out.
struct OutboundMessage {
  PacketHead head;
  Payload data;
};

/// A transport's requests and events for the publishing side of one channel. Implemented by the session.
class OutboundSource {
 public:
  virtual ~OutboundSource() = default;
  /// The latched messages, oldest first, for a subscriber that has just come. It counts in subscriber_count() before
  /// this is called. Messages committed from then on reach it after these. Called on a thread of the transport: no user
  /// code.
  virtual std::vector<OutboundMessage> Latched(SessionId subscriber) noexcept = 0;
  /// A lossless subscriber was lost. It may still be alive, and has not confirmed `unfinished` (oldest first). True: it
  /// gets them from Latched() when it comes back, over any transport. False: it misses them. Called under a lock that
  /// Commit() takes as well, so that no message falls in between; it must not call the transport.
  virtual bool OnCut(SessionId /*subscriber*/, const Demand& /*demand*/,
                     std::vector<OutboundMessage>&& /*unfinished*/) noexcept {
    return false;
  }
  /// A lossless subscriber that had no credit has some again, or has gone.
  virtual void OnRoom() noexcept = 0;
  /// Whether subscribers may be lossless. If not, those that ask for it are keep-last: they get no promise, and nobody
  /// waits for them. Read once, by Advertise().
  [[nodiscard]] virtual bool may_promise() const noexcept { return true; }
  /// The number of remote subscribers has changed.
  virtual void OnSubscribers(std::size_t count) noexcept = 0;
  /// A session has ended its subscription by itself. OnSubscribers() comes afterwards, perhaps when the session has
  /// subscribed again.
  virtual void OnUnsubscribed(SessionId /*subscriber*/) noexcept {}
};

/// The publishing end of one channel on one transport. Destroying it withdraws the channel.
///
/// Contract:
///  1. Reserve() takes credit for one message from every lossless subscriber, or from none (kFull).
///  2. A kOk from Reserve() is followed by exactly one Commit() or Cancel().
///  3. Commit() hands the message to every subscriber. Lossless ones have credit for it. Keep-last ones without credit
///     find it in a ring of the depth they asked for, from which the oldest message is dropped and counted. Plain ones
///     get it if they keep up. It never blocks. Messages committed one after the other arrive in that order. Messages
///     of one publisher are committed in the order of their sequence numbers: one that comes after a later one is
///     treated as a repeat.
///  4. A subscriber that dies gives its credit back (OnRoom). Messages that it had not confirmed count as missed,
///     unless the source keeps them (OnCut).
///  5. A lossless subscriber that was only cut off for a while gets the missed messages, in order, exactly once.
///  6. Messages that are released in Reserve() and Commit() end while the transport holds no lock, and with the
///     caller's EndsLater if it has one.
/// Thread-safe.
class OutboundChannel {
 public:
  virtual ~OutboundChannel() = default;
  /// Number of remote subscribers; all plain ones count as one. Cheap: one relaxed load. 0: nothing needs to be
  /// encoded.
  [[nodiscard]] virtual std::size_t subscriber_count() const noexcept = 0;
  /// The sessions that subscribe, in the order in which they came.
  [[nodiscard]] virtual std::vector<SessionId> Subscribers() const { return {}; }
  virtual PublishStatus Reserve() noexcept = 0;
  /// False: there was no memory to hand the message to all subscribers; those who miss it are counted.
  virtual bool Commit(const PacketHead& head, const Payload& data) noexcept = 0;
  virtual void Cancel() noexcept = 0;
  /// Memory of this transport. A message that is written into it is committed without a copy. Empty if the transport
  /// has no such memory, or none left.
  [[nodiscard]] virtual std::optional<Block> Loan(std::size_t /*size_bytes*/) { return std::nullopt; }
  /// Whether these bytes are in memory of this transport, so that they are committed without a copy.
  [[nodiscard]] virtual bool Holds(Bytes /*bytes*/) const { return false; }
  /// False if handing over a message of this size would exceed a limit that the system enforces by killing a process.
  /// For a message that is in ordinary memory, or, if not `written` yet, will be. It is true now: another thread may
  /// take the memory before Commit(), which then returns false.
  [[nodiscard]] virtual bool HasMemoryFor(std::size_t /*size_bytes*/, bool /*written*/) const { return true; }
  [[nodiscard]] virtual OutboundStats stats() const = 0;
  /// Number of messages that wait for lossless subscribers, or that these have not consumed.
  [[nodiscard]] virtual std::size_t Unfinished() const { return 0; }
};

}  // namespace hgros
