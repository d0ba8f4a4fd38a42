#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

#include "tf/tree/frame.hpp"

namespace hgros::tf {

/// The frames of a tree by id and by name.
/// Thread safety: all functions; reading takes no lock. A table that became too small is kept for its readers.
class FrameTable {
 public:
  /// For at most `most` frames.
  explicit FrameTable(std::size_t most);

  /// Null if there is no such frame.
  [[nodiscard]] Frame* At(FrameId id) const noexcept {
    // Reads the number first: the table that is read after it has at least this number.
    if (id.value >= size_.load(std::memory_order_acquire)) return nullptr;
    return table_.load(std::memory_order_acquire)->by_id[id.value].load(std::memory_order_acquire);
  }
  [[nodiscard]] Frame* Find(std::string_view name) const noexcept;
  /// Creates the frame if it does not exist; null if there are too many.
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
  std::mutex mutex_;  ///< Taken to add a frame.
  std::deque<Frame> frames_;
  std::vector<std::unique_ptr<Table>> tables_;
};

}  // namespace hgros::tf
