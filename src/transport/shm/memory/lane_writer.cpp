#include "transport/shm/memory/lane_writer.hpp"

#include <algorithm>
#include <new>
#include <utility>

namespace hgros::shm {

std::unique_ptr<LaneWriter> LaneWriter::Make(std::string& fault) {
  Segment lane = MakeSegment("hgros-lane", sizeof(LanePage), Access::kOwnerOnly, Pages::kOnTouch);
  if (!lane.mapping) {
    fault = lane.fault;
    return nullptr;
  }
  return std::unique_ptr<LaneWriter>(new LaneWriter(std::move(lane)));
}

LaneWriter::LaneWriter(Segment lane)
    : lane_(std::move(lane.mapping)), handle_(std::make_shared<const Handle>(std::move(lane.handle))) {
  // New memory is zero.
  page().magic = kLaneMagic;
  page().version = kLayoutVersion;
  free_.reserve(kSlots);
  for (std::uint32_t slot = kSlots; slot-- > 0;) free_.push_back(slot);
}

bool LaneWriter::Open(const Handle& slip, std::string& fault) {
  auto mapping = MapForeign(slip, sizeof(SlipPage), false, fault);
  if (!mapping) return false;
  const auto& page = mapping->as<SlipPage>();
  if (page.magic != kSlipMagic || page.version != kLayoutVersion) {
    fault = "it is not a slip of this layout";
    return false;
  }
  slip_ = std::move(mapping);
  return true;
}

void LaneWriter::Write(Descriptor descriptor, std::shared_ptr<const void> owner) noexcept {
  descriptor.slot = free_.back();
  free_.pop_back();
  used_[descriptor.slot] = true;
  owners_[descriptor.slot] = std::move(owner);
  page().descriptors[written_ % kSlots] = descriptor;
  page().written.store(++written_, std::memory_order_release);
}

std::vector<LaneWriter::Held> LaneWriter::TakeHeldIn(std::uint32_t segment) {
  std::vector<Held> held;
  std::array<bool, kSlots> seen{};
  // From the last one on: an earlier descriptor of a slot has been returned.
  for (std::uint64_t number = written_; number > 0 && number + kSlots > written_; --number) {
    const Descriptor& one = page().descriptors[(number - 1) % kSlots];
    if (std::exchange(seen[one.slot], true) || !used_[one.slot] || one.segment != segment) continue;
    if (std::exchange(taken_[one.slot], number) == number) continue;
    held.push_back({one, owners_[one.slot]});
  }
  std::ranges::reverse(held);
  return held;
}

bool LaneWriter::Collect(std::vector<std::shared_ptr<const void>>& ended) {
  if (!slip_) return true;
  const auto& slip = slip_->as<SlipPage>();
  const std::uint64_t returned = slip.returned.load();
  if (returned - collected_ > kSlots) return false;
  for (; collected_ != returned; ++collected_) {
    const std::uint32_t slot = slip.slots[collected_ % kSlots].load(std::memory_order_relaxed);
    if (slot >= kSlots || !used_[slot]) return false;
    used_[slot] = false;
    ended.push_back(std::move(owners_[slot]));
    free_.push_back(slot);
  }
  return true;
}

void LaneWriter::SetHungry(std::uint32_t hungry) noexcept {
  if (hungry == hungry_) return;
  hungry_ = hungry;
  page().hungry.store(hungry);
}

LaneWriter::Consumed LaneWriter::ConsumedOf(std::uint32_t cell) const noexcept {
  if (!slip_ || cell >= kCells) return {};
  const CreditCell& counts = slip_->as<SlipPage>().cells[cell];
  // Messages first: if a message is seen as counted, its bytes are seen as well.
  const std::uint64_t messages = counts.messages.load();
  return {messages, counts.bytes.load()};
}

std::uint32_t LaneWriter::peer_heartbeat() const noexcept {
  return slip_ ? slip_->as<SlipPage>().heartbeat.load(std::memory_order_relaxed) : 0;
}

}  // namespace hgros::shm
