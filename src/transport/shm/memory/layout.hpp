#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace hgros::shm {

/// The shared pages, to the byte. Sessions with different layouts do not share memory.
///
/// Each page except the bell has one writer: the publishing session writes the lane, the receiving session writes the
/// slip. A session that reads a peer's page copies each value once and checks the copy.
inline constexpr std::uint32_t kLayoutVersion = 2;

inline constexpr std::uint32_t kBellMagic = 0x4c454248;
inline constexpr std::uint32_t kLaneMagic = 0x454e4c48;
inline constexpr std::uint32_t kSlipMagic = 0x504c5348;

inline constexpr std::size_t kCacheLine = 64;

/// Sessions that one session can share memory with at a time.
inline constexpr std::uint32_t kMaxPeers = 1024;
/// Messages in flight or held between two sessions, in one direction. A power of two.
inline constexpr std::uint32_t kSlots = 512;
/// Channels between two sessions, in one direction.
inline constexpr std::uint32_t kCells = 16384;

/// Segments of one session at a time. A receiver accepts twice as many: it may hear late that some were removed.
inline constexpr std::uint32_t kMaxSegments = 4096;

using Shared32 = std::atomic<std::uint32_t>;
using Shared64 = std::atomic<std::uint64_t>;
static_assert(Shared32::is_always_lock_free && Shared64::is_always_lock_free);
static_assert(sizeof(Shared32) == 4 && sizeof(Shared64) == 8);

/// A session's bell: which peers have rung, and whether a thread sleeps. Its owner and all its peers write it.
struct BellPage {
  std::uint32_t magic;
  std::uint32_t version;
  alignas(kCacheLine) Shared32 asleep;  ///< Odd: a thread of the owner sleeps on this word, or is about to.
  alignas(kCacheLine) Shared64 ready[kMaxPeers / 64];  ///< Bit n: the peer with number n at the owner has rung.
};

/// One message in flight, written by the publishing session.
struct Descriptor {
  std::uint64_t link;     ///< The number that the receiver has given to the subscription.
  std::uint64_t number;   ///< The message's number on its link, from 1 without gaps.
  std::uint32_t slot;     ///< Returned when the payload is no longer read; < kSlots.
  std::uint32_t segment;  ///< 0: empty payload. kOnSocket: the payload comes over the socket.
  std::uint64_t offset_bytes;
  std::uint64_t size_bytes;
  std::uint64_t publisher;
  std::uint64_t incarnation;
  std::uint64_t sequence;
  std::int64_t publish_time_ns;
  std::int64_t publish_monotonic_ns;
  std::uint32_t latched;
  std::uint32_t chain_origin;  ///< This and the next three: see CauseHead. Older publishers leave zeros.
  std::uint64_t cause;
  std::uint64_t chain_age_ns;
  std::int64_t unsent;
  std::uint64_t reserved[2];
};
static_assert(sizeof(Descriptor) == 2 * kCacheLine);

inline constexpr std::uint32_t kOnSocket = 0xffffffff;

inline constexpr std::uint32_t kForCredit = 1;
inline constexpr std::uint32_t kForSlots = 2;

/// The publishing session's page for one receiving session: a ring of descriptors. Descriptor i is at i % kSlots. There
/// are never more than kSlots unread ones, because each needs its own slot.
struct LanePage {
  std::uint32_t magic;
  std::uint32_t version;
  alignas(kCacheLine) Shared64 written;  ///< Descriptors so far.
  alignas(kCacheLine) Shared32 hungry;   ///< The publisher waits for these: kForCredit | kForSlots.
  Shared32 heartbeat;                    ///< Changes while the publishing session lives and runs.
  alignas(kCacheLine) Descriptor descriptors[kSlots];
};

/// Totals that were consumed on one link.
struct CreditCell {
  Shared64 messages;
  Shared64 bytes;
};

/// The receiving session's page for one publishing session: returned slots and credit. Returned slot i is at i %
/// kSlots.
struct SlipPage {
  std::uint32_t magic;
  std::uint32_t version;
  alignas(kCacheLine) Shared64 returned;  ///< Slots so far.
  Shared32 heartbeat;                     ///< Changes while the receiving session lives and runs.
  alignas(kCacheLine) Shared32 slots[kSlots];
  alignas(kCacheLine) CreditCell cells[kCells];  ///< The receiver chooses a link's cell when it subscribes.
};

// docs/shared-memory.md has the same numbers.
static_assert(sizeof(BellPage) == 256 && offsetof(BellPage, asleep) == 64 && offsetof(BellPage, ready) == 128);
static_assert(offsetof(Descriptor, number) == 8 && offsetof(Descriptor, slot) == 16);
static_assert(offsetof(Descriptor, segment) == 20 && offsetof(Descriptor, offset_bytes) == 24);
static_assert(offsetof(Descriptor, size_bytes) == 32 && offsetof(Descriptor, publisher) == 40);
static_assert(offsetof(Descriptor, incarnation) == 48 && offsetof(Descriptor, sequence) == 56);
static_assert(offsetof(Descriptor, publish_time_ns) == 64 && offsetof(Descriptor, publish_monotonic_ns) == 72);
static_assert(offsetof(Descriptor, latched) == 80 && offsetof(Descriptor, chain_origin) == 84);
static_assert(offsetof(Descriptor, cause) == 88 && offsetof(Descriptor, chain_age_ns) == 96);
static_assert(offsetof(Descriptor, unsent) == 104 && offsetof(Descriptor, reserved) == 112);
static_assert(sizeof(LanePage) == 65728 && offsetof(LanePage, written) == 64 && offsetof(LanePage, hungry) == 128);
static_assert(offsetof(LanePage, heartbeat) == 132 && offsetof(LanePage, descriptors) == 192);
static_assert(sizeof(SlipPage) == 264320 && offsetof(SlipPage, returned) == 64 && offsetof(SlipPage, heartbeat) == 72);
static_assert(offsetof(SlipPage, slots) == 128 && offsetof(SlipPage, cells) == 2176 && sizeof(CreditCell) == 16);

}  // namespace hgros::shm
