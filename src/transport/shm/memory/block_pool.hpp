#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <shared_mutex>
#include <span>
#include <string>
#include <vector>

#include "hgros/base/bytes.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/base/memory_room.hpp"
#include "transport/shm/memory/memory.hpp"

namespace hgros::shm {

/// A place of bytes in a session's shared memory.
struct Place {
  std::uint32_t segment = 0;
  std::uint64_t offset_bytes = 0;
};

/// This session's memory for payloads. Segments are made on demand up to a limit, each is cut into blocks of one size,
/// and blocks are reused. A block is free when the last owner of its bytes ends.
///
/// Thread safety: all functions. Blocks may outlive the pool's owner.
/// Invariants: a segment belongs to one size class; there are never more than kMaxSegments. Before the limit refuses a
/// block, unused segments of other classes go back to the kernel. No segment is made for which the process's memory
/// control group has no room: the kernel would kill a process of the group instead of refusing.
class BlockPool : public std::enable_shared_from_this<BlockPool> {
 public:
  /// How many more bytes the system has for this process; none: not known.
  using SystemRoom = std::function<std::optional<std::uint64_t>()>;
  explicit BlockPool(
      std::uint64_t limit_bytes, SystemRoom system_room = [] { return MemoryGroupRoom(); });

  /// Bytes to write, and their owner.
  struct Loan {
    std::span<std::byte> bytes;
    std::shared_ptr<const void> owner;
    Place place;
  };
  /// None if the limit is reached, the system has no more memory, the pool is closed, or this is a forked child, which
  /// does not own the memory. `fault` says which.
  [[nodiscard]] std::optional<Loan> Allocate(std::size_t size_bytes, std::string* fault = nullptr);

  /// Copies of a payload in ordinary memory for which there must be room before it is sent. A receiver takes it from
  /// the socket and parses it.
  static constexpr std::size_t kCopiesReceived = 2;
  /// The publisher has yet to write it.
  static constexpr std::size_t kCopiesWritten = kCopiesReceived + 1;
  /// It gets a block of a new segment. One to spare, because the segment is kept when the block is free.
  static constexpr std::size_t kCopiesBesideSegment = kCopiesWritten + 1;
  /// Whether publisher and receivers can take this much ordinary memory. Not asked for payloads that cost less to copy
  /// than the question.
  [[nodiscard]] bool HasRoomApart(std::size_t size_bytes, std::size_t copies) const;
  /// No more blocks are allocated after this: receivers may still read blocks that are free here.
  void Close();

  /// The place of `bytes`, if they are in a block of this pool.
  [[nodiscard]] std::optional<Place> Find(Bytes bytes) const;
  /// The segment's descriptor, to pass it on. The returned owner keeps it open. Null if there is no such segment.
  [[nodiscard]] std::shared_ptr<const Handle> HandleOf(std::uint32_t segment) const;
  /// The segments that were given back to the kernel since the last call.
  [[nodiscard]] std::vector<std::uint32_t> CollectRemovedSegments();

  struct Usage {
    std::uint64_t segment_bytes = 0;
    std::size_t segments = 0;
    std::size_t blocks_in_use = 0;
  };
  [[nodiscard]] Usage usage() const;

  /// The size of the block that `size_bytes` are allocated in.
  [[nodiscard]] static std::size_t BlockBytes(std::size_t size_bytes) noexcept;

 private:
  struct PoolSegment {
    std::uint32_t id = 0;
    std::size_t block_bytes = 0;
    std::shared_ptr<Mapping> mapping;
    std::shared_ptr<const Handle> handle;
    std::size_t in_use = 0;
  };
  struct Free {
    PoolSegment* segment = nullptr;
    std::byte* begin = nullptr;
  };
  struct BlockOwner;

  [[nodiscard]] bool Grow(std::size_t block_bytes, std::string* fault);
  [[nodiscard]] std::size_t SegmentBytes(std::size_t block_bytes) const;
  [[nodiscard]] std::uint32_t NextId();
  [[nodiscard]] bool MakeRoom(std::uint64_t bytes, std::uint64_t limit_bytes);
  void GiveBack(PoolSegment& segment, std::byte* begin) noexcept;

  const std::uint64_t limit_bytes_;
  const SystemRoom system_room_;
  const ForkGuard fork_;
  mutable std::shared_mutex mutex_;
  std::map<const std::byte*, std::unique_ptr<PoolSegment>> segments_;  // By their first address.
  std::map<std::size_t, std::vector<Free>> free_;                      // By block size; the last one was used last.
  std::vector<std::uint32_t> gone_;
  std::uint64_t segment_bytes_ = 0;
  std::size_t in_use_ = 0;
  std::uint32_t last_id_ = 0;
  bool closed_ = false;
};

}  // namespace hgros::shm
