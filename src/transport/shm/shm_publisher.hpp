#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "hgros/internal/codec/packet.hpp"
#include "transport/actions.hpp"
#include "transport/leavings.hpp"
#include "transport/shm/message_packer.hpp"
#include "transport/shm/pair/pair_table.hpp"
#include "transport/shm/pair/socket_thread.hpp"
#include "transport/shm/shm_session.hpp"

namespace hgros::shm {

/// Writes this session's messages into the lanes of its peers.
///
/// Thread safety: all functions. The mutex guards Pair::out of all pairs and OutChannel::links: one for all, because a
/// lossless message is promised to all its subscribers or to none. Under it sockets, the block pool and the socket
/// thread's list are locked, and whatever OutboundSource::OnCut() locks.
/// Invariants: a link is in its channel's list exactly while it is in its pair's map. Messages that a link waits for
/// are counted in the sums of pair and channel. Bells are rung, and messages and actions end, when no mutex is held.
class ShmPublisher {
 public:
  ShmPublisher(ShmSession& session, PairTable& pairs, SocketThread& sockets)
      : session_(session), pairs_(pairs), sockets_(sockets), packer_(session) {}

  // Messages: shm_publisher.cpp.
  [[nodiscard]] PublishStatus Reserve(OutChannel& channel);
  void Cancel(const std::shared_ptr<OutChannel>& core);
  void Commit(const std::shared_ptr<OutChannel>& core, const PacketHead& head, const Payload& data);
  [[nodiscard]] std::size_t Unfinished(const OutChannel& channel);
  [[nodiscard]] std::optional<Block> Loan(std::size_t size_bytes) { return packer_.Loan(size_bytes); }
  [[nodiscard]] BlockPool& pool() const noexcept { return packer_.pool(); }
  /// Sends the messages that have waited for slots or credit of this peer.
  void SendWaiting(Pair& pair);

  // Links: shm_publisher_links.cpp.
  /// Why a link ends. This decides what happens to messages that a lossless subscriber has not confirmed.
  enum class LinkEnd {
    kAsked,      ///< The subscriber wants no more.
    kForGood,    ///< The subscriber does not get the rest: it is counted as missed, and this is logged.
    kWithdrawn,  ///< This session no longer offers the channel: the rest is counted as missed.
    kPairLost,   ///< The subscriber may still be alive: its channel may keep the rest for it.
  };
  /// The link exists and waits for BeginLink().
  void AddLink(const std::shared_ptr<OutChannel>& core, Pair& pair, const wire::Wish& asked, const Demand& granted,
               Actions& actions);
  /// Sends the latched messages and then what was published since. Socket thread.
  void BeginLink(const std::shared_ptr<OutChannel>& core, Pair& pair, std::uint64_t number);
  /// `answer` is sent before anything that the new demand lets through.
  void ChangeDemand(const OutChannel& core, Pair& pair, const Demand& granted, const wire::PairMessage& answer,
                    Actions& actions);
  void RemoveLink(const OutChannel& core, Pair& pair, LinkEnd why, Actions& actions);
  /// Tells the peer after how many messages the link ends, and removes it.
  void WithdrawLink(const OutChannel& core, Pair& pair, Actions& actions);

  // Pairs: shm_publisher_links.cpp.
  /// Opens the peer's page. False, and `fault` is set, if it is none.
  [[nodiscard]] bool OpenPair(Pair& pair, const Handle& slip, std::shared_ptr<const PeerBell> bell,
                              std::uint64_t max_message_bytes, std::string& fault);
  /// The peer cannot map that segment. Its messages go over the socket; later it is offered again, ever less often.
  void ResendApart(Pair& pair, std::uint32_t segment);
  /// Once per heartbeat. `removed`: segments of the pool. Returns the peer's heartbeat.
  std::uint32_t Beat(Pair& pair, const std::vector<std::uint32_t>& removed);
  void RemoveAllLinks(Pair& pair, LinkEnd why, Actions& actions);
  /// Returns what the lane holds: messages of the user, which must be destroyed when no mutex is held.
  [[nodiscard]] std::unique_ptr<LaneWriter> ReleaseLane(Pair& pair);

  /// Stops publishing. Waits until everything was sent, for at most `linger_ms`. False if it was called before.
  bool Close(int linger_ms) noexcept;
  /// Wakes Close(): something may have been sent.
  void NotifyClose();
  [[nodiscard]] std::uint64_t sent_apart() const noexcept { return sent_apart_.load(std::memory_order_relaxed); }

 private:
  using Bells = std::vector<std::shared_ptr<const PeerBell>>;

  // All of these: under the mutex.
  [[nodiscard]] bool RefuseIfTooLarge(OutLink& link, const ShmMessage& message, Actions& actions);
  static void ReportTooLarge(OutLink& link);
  void Drain(OutLink& link, Leavings& leavings, Bells& bells);
  [[nodiscard]] bool Send(OutLink& link, Leavings& leavings);
  // False if the payload goes over the socket: the message is no longer needed.
  [[nodiscard]] bool Write(OutLink& link, const PendingMessage& queued);
  [[nodiscard]] bool MayUse(Pair& pair, std::uint32_t segment);
  void ReadCredit(OutLink& link, Leavings& leavings);
  void Collect(Pair& pair, Leavings& leavings);
  [[nodiscard]] bool FindRoom(const OutChannel& channel, Leavings& leavings);
  void EndLink(std::shared_ptr<OutLink> link, LinkEnd why, Actions& actions);
  [[nodiscard]] bool AllSent();

  ShmSession& session_;
  PairTable& pairs_;
  SocketThread& sockets_;
  MessagePacker packer_;
  std::atomic<bool> closing_{false};
  std::atomic<std::uint64_t> sent_apart_{0};
  std::mutex mutex_;

  std::mutex sent_mutex_;
  std::condition_variable sent_;
  std::uint64_t rounds_ = 0;  // Number of times that something may have been sent.
};

}  // namespace hgros::shm
