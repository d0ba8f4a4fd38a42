#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hgros/base/bytes.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "transport/outbound_core.hpp"
#include "transport/peer_channel.hpp"
#include "transport/shm/memory/bell.hpp"
#include "transport/shm/memory/block_pool.hpp"
#include "transport/shm/memory/lane_writer.hpp"

namespace hgros::shm {

struct Pair;
struct OutLink;

/// One message of this session in flight.
struct ShmMessage final : Outgoing {
  MessageId id;
  std::int64_t publish_time_ns = 0;
  std::int64_t publish_monotonic_ns = 0;
  std::uint32_t latched = 0;
  CauseHead cause;
  Payload data;
  /// The payload's place in shared memory. None: there was no room, and it goes over the socket. An empty payload has
  /// segment 0, which does not exist.
  std::optional<Place> place;
};

/// One channel that we publish on.
/// Thread safety: ShmPublisher guards `links`.
struct OutChannel final : OutboundCore {
  using OutboundCore::OutboundCore;
  std::vector<OutLink*> links;  ///< One for each peer that is served.
};

/// The link of one channel to one peer.
/// Thread safety: ShmPublisher guards it.
struct OutLink {
  OutLink(Pair& to, std::shared_ptr<OutChannel> channel, std::uint64_t number, std::uint32_t slip_cell,
          const Demand& granted)
      : pair(to), core(std::move(channel)), link(number), cell(slip_cell), flow(granted) {}
  Pair& pair;
  const std::shared_ptr<OutChannel> core;
  const std::uint64_t link;
  const std::uint32_t cell;
  PeerChannel flow;
  std::uint64_t too_large = 0;        ///< Messages that are larger than the peer accepts.
  std::uint64_t too_large_bytes = 0;  ///< Size of the last one.
  std::uint64_t told_too_large = 0;   ///< How many of them the peer has been told about.
  std::uint64_t counted_bytes = 0;    ///< Part of flow.waiting_bytes() in the sums of the pair and the channel.
};

/// The way to one peer.
/// Thread safety: ShmPublisher guards it.
struct OutSide {
  std::shared_ptr<const PeerBell> bell;
  std::unique_ptr<LaneWriter> lane;
  std::unordered_map<const OutChannel*, std::shared_ptr<OutLink>> links;
  /// A segment that the peer knows, or has refused.
  struct ToldSegment {
    bool refused = false;
    std::chrono::steady_clock::time_point next_try{};
    std::chrono::milliseconds pause{0};
  };
  std::unordered_map<std::uint32_t, ToldSegment> told_segments;
  std::uint64_t max_message_bytes = 0;  ///< The largest message that the peer accepts.
  std::uint64_t waiting_bytes = 0;
};

}  // namespace hgros::shm
