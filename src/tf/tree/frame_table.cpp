#include "tf/tree/frame_table.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>

namespace hgros::tf {

FrameTable::Table::Table(std::size_t size) : capacity(size), by_id(new Place[size]), by_name(new Place[2 * size]) {}

// The place of the name, or the free place for it. At most half of the places are taken, so there is one.
FrameTable::Place& FrameTable::Table::PlaceFor(std::string_view name, std::size_t hash) const noexcept {
  const std::size_t mask = 2 * capacity - 1;
  for (std::size_t i = hash & mask;; i = (i + 1) & mask) {
    const Frame* frame = by_name[i].load(std::memory_order_acquire);
    if (frame == nullptr || (frame->name_hash == hash && frame->name == name)) return by_name[i];
  }
}

FrameTable::FrameTable(std::size_t most)
    : most_(std::min<std::size_t>(most, std::numeric_limits<std::uint32_t>::max())) {
  tables_.push_back(std::make_unique<Table>(64));
  table_ = tables_.back().get();
}

Frame* FrameTable::Find(std::string_view name) const noexcept {
  const std::size_t hash = std::hash<std::string_view>{}(name);
  return table_.load(std::memory_order_acquire)->PlaceFor(name, hash).load(std::memory_order_acquire);
}

Frame* FrameTable::Intern(std::string_view name) {
  if (Frame* found = Find(name)) return found;
  const std::size_t hash = std::hash<std::string_view>{}(name);
  const std::scoped_lock lock(mutex_);
  Table* table = tables_.back().get();
  if (Frame* found = table->PlaceFor(name, hash).load(std::memory_order_relaxed)) return found;

  const std::size_t count = frames_.size();
  if (count >= most_) return nullptr;
  if (count == table->capacity) {
    auto larger = std::make_unique<Table>(2 * count);
    for (Frame& frame : frames_) {
      larger->by_id[frame.id.value].store(&frame, std::memory_order_relaxed);
      larger->PlaceFor(frame.name, frame.name_hash).store(&frame, std::memory_order_relaxed);
    }
    table = larger.get();
    tables_.push_back(std::move(larger));
    table_.store(table, std::memory_order_release);
  }
  Frame& frame = frames_.emplace_back();
  frame.id.value = static_cast<std::uint32_t>(count);
  frame.name_hash = hash;
  frame.name = name;
  table->by_id[count].store(&frame, std::memory_order_release);
  table->PlaceFor(name, hash).store(&frame, std::memory_order_release);
  size_.store(count + 1, std::memory_order_release);
  return &frame;
}

}  // namespace hgros::tf
