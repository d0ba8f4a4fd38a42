#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace hgros {

/// A queue that reuses its memory. A std::deque of large elements allocates and frees a node for each one.
///
/// Thread safety: none.
/// Invariants: removed elements leave nothing behind; after a long queue the memory is freed.
template <class T>
class Fifo {
 public:
  [[nodiscard]] bool empty() const noexcept { return first_ == items_.size(); }
  [[nodiscard]] std::size_t size() const noexcept { return items_.size() - first_; }
  [[nodiscard]] const T& front() const { return items_[first_]; }
  void Put(T&& item) { items_.push_back(std::move(item)); }
  [[nodiscard]] T Take() {
    T item = std::move(items_[first_]);
    items_[first_] = T{};
    if (++first_ == items_.size()) {
      Empty();
    } else if (first_ >= kSlack && first_ * 2 >= items_.size()) {
      items_.erase(items_.begin(), items_.begin() + static_cast<std::ptrdiff_t>(first_));
      first_ = 0;
    }
    return item;
  }

 private:
  static constexpr std::size_t kSlack = 32;

  void Empty() {
    items_.clear();
    first_ = 0;
    if (items_.capacity() > kSlack) items_ = {};
  }

  std::vector<T> items_;
  std::size_t first_ = 0;
};

}  // namespace hgros
