#pragma once

#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "transport/agreement.hpp"
#include "transport/shm/out_link.hpp"
#include "transport/shm/pair/pair_socket.hpp"
#include "transport/shm/pair_inbox.hpp"

namespace hgros::shm {

using SteadyTime = std::chrono::steady_clock::time_point;

/// A peer's wish for one channel. It stays, even while we do not offer the channel.
struct PeerWish {
  wire::Wish asked;
  std::shared_ptr<OutChannel> linked;  ///< The channel that serves it; null if none does.
};

/// One session that we share memory with, or are about to.
///
/// Thread safety: each part belongs to the class that is named at it. The others are set before the pair is in the
/// table.
struct Pair : std::enable_shared_from_this<Pair> {
  Pair(std::shared_ptr<const Handle> connection, bool connected_by_us, std::size_t max_frame_bytes,
       std::shared_ptr<Slip> slip)
      : by_us(connected_by_us), socket(std::move(connection), max_frame_bytes), in(std::move(slip)) {}

  std::uint32_t number = 0;  ///< The bit of our bell that stands for this peer.
  const bool by_us;          ///< We have connected to it.
  std::string place;         ///< The place that we have connected to.

  // For the socket thread.
  SessionFacts facts;
  pid_t process = 0;        ///< The peer's process, as reported by the kernel.
  Handle process_end;       ///< See WatchProcess(): a child that holds the socket does not hide the end.
  SteadyTime last_heard{};  ///< Before the greeting: when the connection was made.
  SteadyTime last_read{};   ///< When the socket was last read from.
  std::uint32_t seen_heartbeat = 0;
  std::uint64_t seen_sent_bytes = 0;
  std::unordered_set<std::string> reported_mismatches;
  bool greeted = false;    ///< Its pages are open.
  bool announced = false;  ///< The listener knows the peer.
  bool finished = false;   ///< It has ended, and everything that it had written was read.
  bool eof = false;        ///< The peer no longer holds messages of ours.

  PairSocket socket;
  std::atomic<bool> alive{false};   ///< Greeted, and not ended.
  std::atomic<bool> ending{false};  ///< The peer sends nothing more; what it has written is still read.
  std::string end_reason;           ///< Set before `ending`.
  std::atomic<bool> hungry{false};  ///< A message waits for slots or credit of this peer.

  OutSide out;  ///< ShmPublisher.
  PairInbox in;

  // OfferedChannels.
  std::unordered_map<std::string, PeerWish> wishes;      ///< By channel.
  std::unordered_map<std::string, std::uint64_t> ended;  ///< The last link of each channel that we have withdrawn.

  // WantedChannels.
  bool asks = false;  ///< Wishes may be sent to it.
};

/// "session talker:4711", for logs and errors.
[[nodiscard]] inline std::string NameOf(const Pair& pair) { return "session " + pair.facts.info.name(); }

/// Tells the listener that two sides of a channel do not fit; once per pair and channel. Socket thread.
inline void ReportMismatch(TransportListener& listener, Pair& pair, const std::string& channel,
                           const std::string& what) {
  constexpr std::size_t kMaxReported = 1024;
  auto& reported = pair.reported_mismatches;
  if (reported.size() >= kMaxReported || !reported.insert(channel).second) return;
  listener.OnTypeMismatch(channel, pair.facts.info, what);
}

}  // namespace hgros::shm
