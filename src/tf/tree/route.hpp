#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "tf/tree/frame.hpp"

namespace hgros::tf {

/// Edges from a frame upwards, each identified by its child.
class EdgeList {
 public:
  void Add(const Frame* edge) {
    if (size_ < kInline) {
      first_[size_] = edge;
    } else {
      if (size_ == kInline) more_.assign(first_.begin(), first_.end());
      more_.push_back(edge);
    }
    ++size_;
  }
  void Clear() {
    size_ = 0;
    more_.clear();
  }
  void RemoveLast() {
    --size_;
    if (size_ > kInline) more_.pop_back();
    if (size_ == kInline) more_.clear();  // first_ still has those.
  }
  [[nodiscard]] const Frame* Last() const { return more_.empty() ? first_[size_ - 1] : more_.back(); }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::span<const Frame* const> edges() const {
    return more_.empty() ? std::span(first_.data(), size_) : std::span(more_);
  }

 private:
  static constexpr std::size_t kInline = 32;
  std::size_t size_ = 0;
  std::array<const Frame*, kInline> first_;
  std::vector<const Frame*> more_;  ///< All of them once there are too many for first_.
};

/// The path between two frames: from each one up to their nearest common ancestor.
struct Route {
  EdgeList from_source;
  EdgeList from_target;
  const Frame* source_root = nullptr;
  const Frame* target_root = nullptr;

  /// False if the two are in separate trees.
  [[nodiscard]] bool Find(const Frame& target, const Frame& source);
};

}  // namespace hgros::tf
