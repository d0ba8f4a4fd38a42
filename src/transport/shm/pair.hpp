#pragma once

#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "hgros/base/bytes.hpp"
#include "transport/agreement.hpp"
#include "transport/inbound_core.hpp"
#include "transport/leavings.hpp"
#include "transport/outbound_core.hpp"
#include "transport/peer_channel.hpp"
#include "transport/shm/bell.hpp"
#include "transport/shm/block_pool.hpp"
#include "transport/shm/lane_reader.hpp"
#include "transport/shm/lane_writer.hpp"
#include "transport/shm/pair_socket.hpp"
#include "transport/shm/receipt.hpp"

namespace hgros::shm {

/// What a frame may have beside its payload.
inline constexpr std::size_t kFrameOverheadBytes = 1u << 20;

using SteadyTime = std::chrono::steady_clock::time_point;

struct Pair;

/// Peers that have something to look at, to be rung when no mutex is held.
using Bells = std::vector<std::shared_ptr<const PeerBell>>;

/// One message of this session on its way to others; its payload lies in shared memory, or could not.
struct ShmMessage final : Outgoing {
  MessageId id;
  std::int64_t publish_time_ns = 0;
  std::int64_t publish_monotonic_ns = 0;
  std::uint32_t latched = 0;
  Payload data;
  std::optional<Place> place;  ///< Nothing: it goes over the socket. An empty payload lies in segment 0, which is none.
};

struct OutLink;

/// One channel that we publish on.
/// Thread safety: what is new here is guarded by the core's mutex.
struct OutChannel final : OutboundCore {
  using OutboundCore::OutboundCore;
  std::vector<OutLink*> links;  ///< While it is offered.
};

/// What we publish to one peer on one channel.
struct OutLink {
  OutLink(Pair& to, std::shared_ptr<OutChannel> channel, std::uint64_t number, std::uint32_t slip_cell,
          const Demand& granted)
      : pair(to), core(std::move(channel)), link(number), cell(slip_cell), flow(granted) {}
  Pair& pair;
  const std::shared_ptr<OutChannel> core;
  const std::uint64_t link;
  const std::uint32_t cell;
  PeerChannel flow;
  std::uint64_t too_large = 0;        ///< Messages that the peer does not take.
  std::uint64_t too_large_bytes = 0;  ///< The last one's.
  std::uint64_t told_too_large = 0;
  std::uint64_t counted_bytes = 0;  ///< Of flow.waiting_bytes(), in the pair's and the channel's sums.
};

/// What a peer asks of us. It stands whether we offer the channel or not.
struct PeerWish {
  wire::Wish asked;
  std::unique_ptr<OutLink> link;
};

/// What one peer publishes to us on one channel.
struct InLink {
  std::shared_ptr<InboundCore> core;
  std::uint64_t link = 0;
  std::shared_ptr<Receipt> receipt;
  bool granted = false;              ///< And counted as a publisher.
  std::uint64_t asked_messages = 1;  ///< The widest window that was asked for: it was granted no more.
  std::uint64_t asked_bytes = 1;
  std::uint64_t apart_bytes = 0;  ///< Of payloads that came before their messages.
  std::uint64_t too_large = 0;    ///< Messages that the publisher has kept back. The core's own thread.
  std::string type_name;
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;
  std::shared_ptr<const MessageSchema> schema;  ///< That type, if it is not the core's.
  bool checked = false;                         ///< Its type: the reading thread has found nothing wrong.
  std::optional<std::uint64_t> ends_after;      ///< The publisher has withdrawn the channel behind so many messages.
};

/// One session that we share memory with, or are about to.
///
/// Thread safety: `out` and all below it are guarded by the core's mutex; `in` and all below it by in_mutex, which is
/// taken after the core's. What stands above is set before the pair is known to other threads than the core's own.
/// Invariants: the reading thread moves `in`; the core's own thread does the rest.
struct Pair : std::enable_shared_from_this<Pair> {
  Pair(std::uint32_t bell_number, std::shared_ptr<const Handle> connection, bool connected_by_us,
       std::size_t max_frame_bytes)
      : number(bell_number), by_us(connected_by_us), socket(std::move(connection), max_frame_bytes) {}

  const std::uint32_t number;  ///< The bit of our bell that stands for this peer.
  const bool by_us;
  std::string place;  ///< Where we connected to.

  // The core's own thread.
  SessionFacts facts;
  pid_t process = 0;        ///< Of the peer, as the kernel says.
  Handle process_end;       ///< See WatchProcess(): a child that holds the socket does not hide the end.
  SteadyTime last_heard{};  ///< Before the greeting: when the connection was made.
  SteadyTime last_read{};   ///< From the socket.
  std::uint32_t seen_heartbeat = 0;
  std::unordered_set<std::string> told_mismatch;
  bool greeted = false;  ///< Its pages are open.
  bool came = false;     ///< The listener was told.

  PairSocket socket;  ///< Receiving: the core's own thread. Sending: guarded by the core's mutex.
  /// Greeted, and not ended.
  std::atomic<bool> alive{false};
  /// The peer says no more; what it has written is still read, and then the rest is done for `end_reason`.
  std::atomic<bool> ending{false};
  std::string end_reason;              ///< Set before `ending`.
  std::atomic<bool> finishing{false};  ///< All was read.
  bool finished = false;               ///< And what that leaves to do is done. The core's own thread.
  bool eof = false;                    ///< The peer holds nothing of ours any more. The core's own thread.
  /// Something waits for slots or credit.
  std::atomic<bool> hungry{false};

  std::shared_ptr<const PeerBell> bell;
  std::unique_ptr<LaneWriter> out;
  std::unordered_map<std::string, PeerWish> wishes;      ///< By channel.
  std::unordered_map<std::string, std::uint64_t> ended;  ///< The last link of each channel that we have withdrawn.
  std::unordered_set<std::uint32_t> told_segments;
  std::uint64_t max_message_bytes = 0;  ///< The largest message that the peer takes.
  bool asks = false;                    ///< It may be asked for channels that no other carrier has taken.
  std::uint64_t waiting_bytes = 0;

  std::mutex in_mutex;
  std::shared_ptr<Slip> slip;
  std::unique_ptr<LaneReader> in;
  std::unordered_map<std::uint64_t, std::shared_ptr<InLink>> in_links;  ///< By link.
  std::unordered_map<std::string, std::uint64_t> in_channels;           ///< Our wish for each channel: its link.
  std::unordered_map<std::uint32_t, std::shared_ptr<Mapping>> segments;
  /// Payloads by link and number; of each link no more than its credit.
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::string> apart;
  std::uint64_t last_link = 0;
  /// Earlier pairs with the same session: what they have left is read before anything of this one.
  std::vector<std::shared_ptr<Pair>> after;
  bool blocked = false;  ///< The next message needs something that has not come over the socket yet.
};

}  // namespace hgros::shm
