#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hgros/pair.pb.h"
#include "transport/inbound_core.hpp"
#include "transport/shm/memory/lane_reader.hpp"
#include "transport/shm/pair/pair_socket.hpp"
#include "transport/shm/receipt.hpp"

namespace hgros::shm {

/// The link of one channel from one peer.
/// Thread safety: the pair's inbox guards it, except where another owner is named.
struct InLink {
  std::shared_ptr<InboundCore> core;
  std::uint64_t link = 0;
  std::shared_ptr<Receipt> receipt;
  bool granted = false;              ///< The link was granted and is counted as a publisher.
  std::uint64_t asked_messages = 1;  ///< The widest window we have asked for; no more than that is granted.
  std::uint64_t asked_bytes = 1;
  std::uint64_t apart_bytes = 0;  ///< Bytes of payloads that have come before their messages.
  std::uint64_t too_large = 0;    ///< Messages that the publisher has held back. Socket thread only.
  std::string type_name;
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;
  std::shared_ptr<const MessageSchema> schema;  ///< The publisher's type, if it differs from the core's.
  bool checked = false;                         ///< The reading thread has checked the type. Reading thread only.
  std::optional<std::uint64_t> ends_after;      ///< The publisher withdraws the channel after this many messages.
};

/// Everything that one peer sends us: the lane with its messages, its links and segments, and payloads that came over
/// the socket.
///
/// Thread safety: all functions; Next() on one thread at a time.
/// Invariants: everything that the peer writes is copied once and then checked. A message is taken out of the lane
/// only when its segment or payload is there. Each slot that was taken out is returned once. The payloads kept for a
/// link never exceed the credit we have asked for.
class PairInbox {
 public:
  explicit PairInbox(std::shared_ptr<Slip> slip) noexcept : slip_(std::move(slip)) {}

  /// The page that the peer must map.
  [[nodiscard]] std::shared_ptr<const Handle> slip_handle() const;
  /// Called once, before anything is read. `from` is the peer's session.
  void Open(std::unique_ptr<LaneReader> lane, std::shared_ptr<const PeerBell> bell, SessionId from);
  /// Stops reading, even if there is more.
  void StopReading();
  /// Forgets everything. Returns the links, so that the caller can count their publishers.
  [[nodiscard]] std::vector<std::shared_ptr<InLink>> Clear();
  /// Messages of `earlier`, an inbox of the same session, are read before those of this one, and its end is told.
  void ReadAfter(std::shared_ptr<const PairInbox> earlier);

  /// Sends a heartbeat to the peer.
  void Beat() noexcept;

  /// Null if the slip has no cell left.
  [[nodiscard]] std::shared_ptr<InLink> AddLink(const std::shared_ptr<InboundCore>& core);
  /// Null if the channel is not asked for.
  [[nodiscard]] std::shared_ptr<InLink> LinkOf(const std::string& channel) const;
  [[nodiscard]] std::shared_ptr<InLink> LinkAt(std::uint64_t number) const;
  /// Returns what was removed, or null.
  std::shared_ptr<InLink> RemoveLink(const std::string& channel);
  /// Sets the window that we ask for. Call it before the peer is asked.
  void RaiseLimits(InLink& link, const Demand& demand);
  /// The peer serves the link. True the first time. `schema`: may be null.
  bool Grant(InLink& link, const wire::Granted& granted, std::shared_ptr<const MessageSchema> schema);
  /// The link ends after `messages`. True if they have all been read.
  [[nodiscard]] bool EndAfter(std::uint64_t link, std::uint64_t messages);

  /// False if the peer cannot add this segment.
  [[nodiscard]] bool AddSegment(std::uint32_t segment, std::shared_ptr<Mapping> mapping);
  void RemoveSegment(std::uint32_t segment);
  /// The payload of a message to come. False if no message may have it.
  [[nodiscard]] bool AddPayload(PairSocket::Apart&& payload);
  /// Whether the next message waits for something that comes over the socket.
  [[nodiscard]] bool blocked() const;
  /// Clears that mark and returns whether it was set. Called when something has come over the socket.
  [[nodiscard]] bool Unblock();

  enum class Step {
    kMessage,
    kSkipped,  ///< A message of a link that no longer exists.
    kLost,     ///< There was no memory for the payload of a message of `link`.
    kNothing,  ///< Nothing to read now.
    kNotYet,   ///< An earlier inbox comes first.
    kLie,      ///< The peer has written what cannot be.
  };
  struct Arrival {
    std::shared_ptr<InLink> link;
    InboundMessage message;
    bool ends = false;          ///< It is the link's last message, which may be lost.
    const char* lie = nullptr;  ///< The impossible value, in words.
  };
  /// Takes the next message out of the lane.
  [[nodiscard]] Step Next(Arrival& arrival, std::uint64_t max_message_bytes);
  [[nodiscard]] bool HasMore() const {
    const std::scoped_lock lock(mutex_);
    Descriptor next;
    return lane_ && lane_->Peek(next) != LaneReader::Read::kNothing;
  }
  /// All was read. True the first time.
  bool MarkAllRead() noexcept { return !all_read_.exchange(true); }
  /// All was read, and subscriptions know that its links have ended.
  void MarkEnded() noexcept { ended_ = true; }
  [[nodiscard]] bool ended() const noexcept { return ended_.load(); }

 private:
  [[nodiscard]] static Payload PayloadOf(const std::shared_ptr<Slip>& slip, const Descriptor& descriptor,
                                         std::shared_ptr<Mapping> segment);

  mutable std::mutex mutex_;
  std::shared_ptr<Slip> slip_;
  std::unique_ptr<LaneReader> lane_;
  SessionId from_;
  std::unordered_map<std::uint64_t, std::shared_ptr<InLink>> links_;  // By number.
  std::unordered_map<std::string, std::uint64_t> channels_;           // Link numbers by channel.
  std::unordered_map<std::uint32_t, std::shared_ptr<Mapping>> segments_;
  std::map<std::pair<std::uint64_t, std::uint64_t>, Payload> apart_;  // Payloads by link and message number.
  std::uint64_t last_link_ = 0;
  std::vector<std::shared_ptr<const PairInbox>> earlier_;
  bool blocked_ = false;
  std::atomic<bool> all_read_{false};
  std::atomic<bool> ended_{false};
};

}  // namespace hgros::shm
