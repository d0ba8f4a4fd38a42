#include "transport/shm/memory/lane_reader.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace hgros::shm {

std::shared_ptr<Slip> Slip::Make(std::shared_ptr<const Handle> socket, std::shared_ptr<const ForkGuard> fork,
                                 std::string& fault) {
  Segment segment = MakeSegment("hgros-slip", sizeof(SlipPage), Access::kOwnerOnly, Pages::kOnTouch);
  if (!segment.mapping) {
    fault = segment.fault;
    return nullptr;
  }
  return std::shared_ptr<Slip>(new Slip(std::move(segment), std::move(socket), std::move(fork)));
}

Slip::Slip(Segment segment, std::shared_ptr<const Handle> socket, std::shared_ptr<const ForkGuard> fork)
    : mapping_(std::move(segment.mapping)),
      handle_(std::make_shared<const Handle>(std::move(segment.handle))),
      socket_(std::move(socket)),
      fork_(std::move(fork)) {
  page().magic = kSlipMagic;
  page().version = kLayoutVersion;
}

// This shows the publisher that its memory is no longer read here.
Slip::~Slip() {
  if (!fork_->IsChild()) shutdown(socket_->fd(), SHUT_WR);
}

void Slip::SetPublisher(std::shared_ptr<Mapping> lane, std::shared_ptr<const PeerBell> bell) {
  lane_ = std::move(lane);
  bell_ = std::move(bell);
}

void Slip::Return(std::uint32_t slot) noexcept {
  if (fork_->IsChild()) return;
  {
    const std::scoped_lock lock(mutex_);
    const std::uint64_t returned = page().returned.load(std::memory_order_relaxed);
    page().slots[returned % kSlots].store(slot, std::memory_order_relaxed);
    page().returned.store(returned + 1);
  }
  held_.fetch_sub(1, std::memory_order_relaxed);
  TellIfHungry(kForSlots);
}

std::optional<std::uint32_t> Slip::AllocateCell() {
  const std::scoped_lock lock(mutex_);
  std::uint32_t cell = used_cells_;
  if (!free_cells_.empty()) {
    cell = free_cells_.back();
    free_cells_.pop_back();
  } else if (used_cells_ == kCells) {
    return std::nullopt;
  } else {
    ++used_cells_;
    // FreeCell() must not allocate.
    if (free_cells_.capacity() < used_cells_) free_cells_.reserve(std::min(2 * used_cells_, kCells));
  }
  page().cells[cell].messages.store(0);
  page().cells[cell].bytes.store(0);
  return cell;
}

void Slip::FreeCell(std::uint32_t cell) noexcept {
  if (fork_->IsChild()) return;
  const std::scoped_lock lock(mutex_);
  free_cells_.push_back(cell);
}

Slip::Counted Slip::Count(std::uint32_t cell, std::uint64_t bytes) noexcept {
  if (fork_->IsChild()) return {};
  CreditCell& counts = page().cells[cell];
  // Bytes first: a reader that sees the message counted also sees its bytes.
  const std::uint64_t total_bytes = counts.bytes.fetch_add(bytes) + bytes;
  return {counts.messages.fetch_add(1) + 1, total_bytes};
}

void Slip::TellIfHungry(std::uint32_t what) const noexcept {
  if (!fork_->IsChild() && lane_ && (lane_->as<LanePage>().hungry.load() & what) != 0) bell_->Ring();
}

std::unique_ptr<LaneReader> LaneReader::Open(const Handle& lane, std::string& fault) {
  auto mapping = MapForeign(lane, sizeof(LanePage), false, fault);
  if (!mapping) return nullptr;
  const auto& page = mapping->as<LanePage>();
  if (page.magic != kLaneMagic || page.version != kLayoutVersion) {
    fault = "it is not a lane of this layout";
    return nullptr;
  }
  return std::unique_ptr<LaneReader>(new LaneReader(std::move(mapping)));
}

LaneReader::Read LaneReader::Peek(Descriptor& descriptor) noexcept {
  const auto& page = mapping_->as<LanePage>();
  const std::uint64_t written = page.written.load(std::memory_order_acquire);
  if (written == read_) return Read::kNothing;
  if (written - read_ > kSlots) return Read::kLie;
  std::memcpy(&descriptor, &page.descriptors[read_ % kSlots], sizeof descriptor);
  // The peer may change the page at any time. So the copy is checked, and the compiler must not read the page again.
  std::atomic_signal_fence(std::memory_order_seq_cst);
  return Read::kDescriptor;
}

}  // namespace hgros::shm
