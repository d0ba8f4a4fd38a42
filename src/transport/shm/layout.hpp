#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace hgros::shm {

/// What stands in the shared pages, to the byte. Two sessions of another layout do not share memory.
///
/// Each page has one writer, except the bell: a lane is written by the publishing session and read by the receiving
/// one, a slip the other way round. Whoever reads a page written by somebody else copies a value once and checks the
/// copy.
inline constexpr std::uint32_t kLayoutVersion = 1;

inline constexpr std::uint32_t kBellMagic = 0x4c454248;
inline constexpr std::uint32_t kLaneMagic = 0x454e4c48;
inline constexpr std::uint32_t kSlipMagic = 0x504c5348;

inline constexpr std::size_t kCacheLine = 64;

/// Sessions that one session can share memory with at a time.
inline constexpr std::uint32_t kMaxPeers = 1024;
/// Messages on the way or held between two sessions, one direction. A power of two.
inline constexpr std::uint32_t kSlots = 512;
/// Channels between two sessions, one direction.
inline constexpr std::uint32_t kCells = 1024;

/// Segments of one session at a time; a receiver takes as many again that it was not yet told the end of.
inline constexpr std::uint32_t kMaxSegments = 4096;

using Shared32 = std::atomic<std::uint32_t>;
using Shared64 = std::atomic<std::uint64_t>;
static_assert(Shared32::is_always_lock_free && Shared64::is_always_lock_free);
static_assert(sizeof(Shared32) == 4 && sizeof(Shared64) == 8);

/// A session's bell: who rings it, and whether anybody sleeps. Its owner and all its peers write it.
struct BellPage {
  std::uint32_t magic;
  std::uint32_t version;
  alignas(kCacheLine) Shared32 asleep;  ///< Odd: a thread of the owner sleeps on this word, or is about to.
  alignas(kCacheLine) Shared64 ready[kMaxPeers / 64];  ///< Bit n: look at the peer that has number n at the owner.
};

/// One message on its way, as the publishing session says.
struct Descriptor {
  std::uint64_t link;     ///< The number that the receiver gave the subscription.
  std::uint64_t number;   ///< Of the message on its link, from 1 without gaps.
  std::uint32_t slot;     ///< To be returned when the payload is no longer read; < kSlots.
  std::uint32_t segment;  ///< kOnSocket: the payload comes over the control connection.
  std::uint64_t offset_bytes;
  std::uint64_t size_bytes;
  std::uint64_t publisher;
  std::uint64_t incarnation;
  std::uint64_t sequence;
  std::int64_t publish_time_ns;
  std::int64_t publish_monotonic_ns;
  std::uint32_t latched;
  std::uint32_t reserved[11];
};
static_assert(sizeof(Descriptor) == 2 * kCacheLine);

inline constexpr std::uint32_t kOnSocket = 0xffffffff;

inline constexpr std::uint32_t kForCredit = 1;
inline constexpr std::uint32_t kForSlots = 2;

/// The publishing session's page for one receiving session: a ring of descriptors. Descriptor i stands at i % kSlots;
/// there are never more than kSlots unread ones, because each needs a slot of its own.
struct LanePage {
  std::uint32_t magic;
  std::uint32_t version;
  alignas(kCacheLine) Shared64 written;  ///< Descriptors so far.
  alignas(kCacheLine) Shared32 hungry;   ///< What the publisher waits for, kForCredit | kForSlots: ring its bell.
  Shared32 heartbeat;                    ///< Changes while the publishing session lives and runs.
  alignas(kCacheLine) Descriptor descriptors[kSlots];
};

/// How much of one link was consumed, in total.
struct CreditCell {
  Shared64 messages;
  Shared64 bytes;
};

/// The receiving session's page for one publishing session: what it gives back. Slot number i of all returned so far
/// stands at i % kSlots.
struct SlipPage {
  std::uint32_t magic;
  std::uint32_t version;
  alignas(kCacheLine) Shared64 returned;  ///< Slots so far.
  Shared32 heartbeat;                     ///< Changes while the receiving session lives and runs.
  alignas(kCacheLine) Shared32 slots[kSlots];
  alignas(kCacheLine) CreditCell cells[kCells];  ///< By the receiver's choice, told when it subscribes.
};

// docs/shared-memory.md has these numbers too.
static_assert(sizeof(BellPage) == 256 && offsetof(BellPage, asleep) == 64 && offsetof(BellPage, ready) == 128);
static_assert(offsetof(Descriptor, number) == 8 && offsetof(Descriptor, slot) == 16);
static_assert(offsetof(Descriptor, segment) == 20 && offsetof(Descriptor, offset_bytes) == 24);
static_assert(offsetof(Descriptor, size_bytes) == 32 && offsetof(Descriptor, publisher) == 40);
static_assert(offsetof(Descriptor, incarnation) == 48 && offsetof(Descriptor, sequence) == 56);
static_assert(offsetof(Descriptor, publish_time_ns) == 64 && offsetof(Descriptor, publish_monotonic_ns) == 72);
static_assert(offsetof(Descriptor, latched) == 80 && offsetof(Descriptor, reserved) == 84);
static_assert(sizeof(LanePage) == 65728 && offsetof(LanePage, written) == 64 && offsetof(LanePage, hungry) == 128);
static_assert(offsetof(LanePage, heartbeat) == 132 && offsetof(LanePage, descriptors) == 192);
static_assert(sizeof(SlipPage) == 18560 && offsetof(SlipPage, returned) == 64 && offsetof(SlipPage, heartbeat) == 72);
static_assert(offsetof(SlipPage, slots) == 128 && offsetof(SlipPage, cells) == 2176 && sizeof(CreditCell) == 16);

}  // namespace hgros::shm
