#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "hgros/base/fork_guard.hpp"
#include "hgros/base/log.hpp"
#include "hgros/transport/shm_transport.hpp"
#include "transport/agreement.hpp"

namespace hgros::shm {

/// Room in a frame for everything except the payload.
inline constexpr std::size_t kFrameOverheadBytes = 1u << 20;

/// This session, as the parts of its transport see it: options, facts, where to report, and counters.
/// Thread safety: everything is constant or atomic.
struct ShmSession {
  ShmSession(ShmOptions completed, TransportListener& told, Log& written)
      : options(std::move(completed)), self(OwnFacts(options.session, options.process)), listener(told), log(written) {}

  void CountFault(PacketFault fault, std::uint64_t count = 1) noexcept {
    faults[static_cast<std::size_t>(fault)].fetch_add(count, std::memory_order_relaxed);
  }

  const ShmOptions options;
  const SessionFacts self;
  TransportListener& listener;
  Log& log;
  const std::shared_ptr<const ForkGuard> fork = std::make_shared<const ForkGuard>();
  std::array<std::atomic<std::uint64_t>, kPacketFaultCount> faults{};
  std::atomic<std::uint64_t> repeats{0};
};

}  // namespace hgros::shm
