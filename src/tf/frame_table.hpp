#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

#include "tf/frame.hpp"

namespace hgros::tf {

/// The frames of a tree by id and by name.
/// Thread safety: full; reading takes no lock. A table that has become too small is kept for those who still read it.
class FrameTable {
 public:
  /// Of `most` frames at most.
  explicit FrameTable(std::size_t most);

  /// Null if there is none.
  [[nodiscard]] Frame* At(FrameId id) const noexcept {
    // The number first: the table read after it has at least as many.
    if (id.value >= size_.load(std::memory_order_acquire)) return nullptr;
    return table_.load(std::memory_order_acquire)->by_id[id.value].load(std::memory_order_acquire);
  }
  [[nodiscard]] Frame* Find(std::string_view name) const noexcept;
  /// Makes it if there is none; null if there are too many.
  [[nodiscard]] Frame* Intern(std::string_view name);
  [[nodiscard]] std::size_t most() const noexcept { return most_; }
  [[nodiscard]] std::size_t size() const noexcept { return size_.load(std::memory_order_acquire); }

 private:
  using Place = std::atomic<Frame*>;
  struct Table {
    explicit Table(std::size_t capacity);
    std::size_t capacity;
    std::unique_ptr<Place[]> by_id;
    std::unique_ptr<Place[]> by_name;  ///< Twice as many places; an open hash with steps of one.
    [[nodiscard]] Place& PlaceFor(std::string_view name, std::size_t hash) const noexcept;
  };

  const std::size_t most_;
  std::atomic<std::size_t> size_{0};
  std::atomic<Table*> table_{nullptr};
  std::mutex mutex_;  ///< Of those who add.
  std::deque<Frame> frames_;
  std::vector<std::unique_ptr<Table>> tables_;
};

}  // namespace hgros::tf
