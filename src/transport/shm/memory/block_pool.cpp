#include "transport/shm/memory/block_pool.hpp"

#include <algorithm>
#include <bit>
#include <mutex>
#include <utility>

#include "transport/shm/memory/layout.hpp"

namespace hgros::shm {
namespace {

constexpr std::size_t kSmallestBlock = 256;
constexpr std::size_t kPage = 4096;
// Blocks share segments. A size class that is used a lot gets larger segments, because each segment costs every session
// a descriptor or a mapping. A block larger than the largest segment has its own.
constexpr std::size_t kFirstSegment = 256 * 1024;
constexpr std::size_t kLargestSegment = 4 * 1024 * 1024;
// Reading the limits of the control group costs as much as copying this much.
constexpr std::size_t kLargeBytes = 1u << 20;
// More memory than any machine has. Sizes below it can be rounded up without overflow.
constexpr std::uint64_t kMaxLimit = std::uint64_t{1} << 46;

}  // namespace

// Returns its block when it ends, on any thread.
struct BlockPool::BlockOwner {
  BlockOwner(std::shared_ptr<BlockPool> owner, PoolSegment& where, std::byte* first) noexcept
      : pool(std::move(owner)), segment(where), begin(first) {}
  ~BlockOwner() { pool->GiveBack(segment, begin); }
  BlockOwner(const BlockOwner&) = delete;
  BlockOwner& operator=(const BlockOwner&) = delete;

  const std::shared_ptr<BlockPool> pool;
  PoolSegment& segment;
  std::byte* const begin;
};

BlockPool::BlockPool(std::uint64_t limit_bytes, SystemRoom system_room)
    : limit_bytes_(std::min(limit_bytes, kMaxLimit)), system_room_(std::move(system_room)) {}

// Four classes per power of two above a page: at most a fifth of a block is wasted.
std::size_t BlockPool::BlockBytes(std::size_t size_bytes) noexcept {
  if (size_bytes <= kPage) return std::max(std::bit_ceil(size_bytes), kSmallestBlock);
  const std::size_t step = std::max(std::bit_floor(size_bytes) / 4, kPage);
  return (size_bytes + step - 1) / step * step;
}

std::optional<BlockPool::Loan> BlockPool::Allocate(std::size_t size_bytes, std::string* fault) {
  if (fork_.IsChild()) {
    if (fault != nullptr) *fault = "it belongs to the parent of this process";
    return std::nullopt;
  }
  if (size_bytes > limit_bytes_) {
    if (fault != nullptr) *fault = "it is larger than the limit of shared memory";
    return std::nullopt;
  }
  const std::size_t block_bytes = BlockBytes(size_bytes);
  Free block;
  {
    const std::unique_lock lock(mutex_);
    if (closed_) {
      if (fault != nullptr) *fault = "the session has ended";
      return std::nullopt;
    }
    std::vector<Free>& free = free_[block_bytes];
    if (free.empty() && !Grow(block_bytes, fault)) return std::nullopt;
    block = free.back();
    free.pop_back();
    ++block.segment->in_use;
    ++in_use_;
  }
  const auto offset = static_cast<std::uint64_t>(block.begin - block.segment->mapping->bytes().data());
  return Loan{.bytes = {block.begin, size_bytes},
              .owner = std::make_shared<const BlockOwner>(shared_from_this(), *block.segment, block.begin),
              .place = {block.segment->id, offset}};
}

bool BlockPool::HasRoomApart(std::size_t size_bytes, std::size_t copies) const {
  if (size_bytes < kLargeBytes) return true;
  const auto room = system_room_();
  return !room || *room >= copies * size_bytes;
}

bool BlockPool::Grow(std::size_t block_bytes, std::string* fault) {
  const auto room_left = [&]() -> std::optional<std::uint64_t> {
    const auto room = system_room_();
    if (!room) return std::nullopt;
    return *room - std::min<std::uint64_t>(*room, std::uint64_t{kCopiesBesideSegment} * block_bytes);
  };
  const auto left = room_left();
  const std::uint64_t limit = left ? std::min(limit_bytes_, segment_bytes_ + *left) : limit_bytes_;
  const std::size_t gone = gone_.size();
  std::size_t bytes = SegmentBytes(block_bytes);
  bool room = MakeRoom(bytes, limit);
  if (!room) {  // Perhaps there is room for one block.
    bytes = (block_bytes + kPage - 1) / kPage * kPage;
    room = MakeRoom(bytes, limit);
  }
  // Removed segments are only free when their receivers have released them, too.
  if (room && gone_.size() > gone) room = room_left().value_or(bytes) >= bytes;
  const std::size_t blocks = bytes / block_bytes;
  if (!room) {
    if (fault != nullptr) {
      *fault = left && segment_bytes_ + bytes <= limit_bytes_
                   ? "the memory limit of its control group leaves too little"
                   : "all " + std::to_string(limit_bytes_ >> 20) + " MB of shared memory are in use";
    }
    return false;
  }
  Segment made = MakeSegment("hgros-payload", bytes, Access::kOwnerOnly, Pages::kAtOnce);
  if (!made.mapping) {
    if (fault != nullptr) *fault = made.fault;
    return false;
  }
  auto segment = std::make_unique<PoolSegment>();
  segment->id = NextId();
  segment->block_bytes = block_bytes;
  segment->mapping = std::move(made.mapping);
  segment->handle = std::make_shared<const Handle>(std::move(made.handle));
  segment_bytes_ += bytes;
  std::byte* const begin = segment->mapping->bytes().data();
  std::vector<Free>& free = free_[block_bytes];
  for (std::size_t i = blocks; i-- > 0;) free.push_back({segment.get(), begin + i * block_bytes});
  segments_.emplace(begin, std::move(segment));
  return true;
}

// Doubles the memory of the size class.
std::size_t BlockPool::SegmentBytes(std::size_t block_bytes) const {
  std::size_t held = 0;
  for (const auto& [begin, segment] : segments_) {
    if (segment->block_bytes == block_bytes) held += segment->mapping->bytes().size();
  }
  const std::size_t blocks = std::max<std::size_t>(std::clamp(held, kFirstSegment, kLargestSegment) / block_bytes, 1);
  return (blocks * block_bytes + kPage - 1) / kPage * kPage;
}

// 0 and kOnSocket have a meaning of their own in descriptors.
std::uint32_t BlockPool::NextId() {
  const auto taken = [this](std::uint32_t id) {
    return id == 0 || id == kOnSocket ||
           std::ranges::any_of(segments_, [id](const auto& entry) { return entry.second->id == id; });
  };
  while (taken(++last_id_)) {
  }
  return last_id_;
}

bool BlockPool::MakeRoom(std::uint64_t bytes, std::uint64_t limit_bytes) {
  const auto room = [&] { return segment_bytes_ + bytes <= limit_bytes && segments_.size() < kMaxSegments; };
  for (auto entry = segments_.begin(); !room() && entry != segments_.end();) {
    PoolSegment& segment = *entry->second;
    if (segment.in_use > 0) {
      ++entry;
      continue;
    }
    std::erase_if(free_[segment.block_bytes], [&](const Free& block) { return block.segment == &segment; });
    segment_bytes_ -= segment.mapping->bytes().size();
    gone_.push_back(segment.id);
    entry = segments_.erase(entry);
  }
  return room();
}

void BlockPool::GiveBack(PoolSegment& segment, std::byte* begin) noexcept {
  if (fork_.IsChild()) return;
  const std::unique_lock lock(mutex_);
  --segment.in_use;
  --in_use_;
  free_[segment.block_bytes].push_back({&segment, begin});
}

void BlockPool::Close() {
  const std::unique_lock lock(mutex_);
  closed_ = true;
}

std::optional<Place> BlockPool::Find(Bytes bytes) const {
  if (bytes.empty()) return std::nullopt;
  const std::shared_lock lock(mutex_);
  auto next = segments_.upper_bound(bytes.data());
  if (next == segments_.begin()) return std::nullopt;
  const auto& [begin, segment] = *std::prev(next);
  const auto offset = static_cast<std::size_t>(bytes.data() - begin);
  const std::size_t size = segment->mapping->bytes().size();
  if (offset >= size || bytes.size() > size - offset) return std::nullopt;
  return Place{segment->id, offset};
}

std::shared_ptr<const Handle> BlockPool::HandleOf(std::uint32_t id) const {
  const std::shared_lock lock(mutex_);
  for (const auto& [begin, segment] : segments_) {
    if (segment->id == id) return segment->handle;
  }
  return nullptr;
}

std::vector<std::uint32_t> BlockPool::CollectRemovedSegments() {
  const std::unique_lock lock(mutex_);
  return std::exchange(gone_, {});
}

BlockPool::Usage BlockPool::usage() const {
  const std::shared_lock lock(mutex_);
  return {segment_bytes_, segments_.size(), in_use_};
}

}  // namespace hgros::shm
