#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "transport/waker.hpp"

namespace hgros::zmq {

class LinkCredit;

/// The links of one endpoint whose publisher must get credit now. So nobody has to look at all links for that.
///
/// Thread safety: all functions. Invariants: a link is in it at most once. Add() never allocates, because it runs where
/// messages are destroyed.
class DueCredits {
 public:
  /// Wakes the thread that sends credit.
  explicit DueCredits(std::shared_ptr<Waker> waker) : waker_(std::move(waker)) {}

  /// The number of links that may be added grows, or shrinks, by one.
  void Join();
  void Leave() noexcept;
  /// `wake`: false on the thread that sends credit.
  void Add(std::weak_ptr<LinkCredit> link, bool wake) noexcept;
  [[nodiscard]] bool empty() const noexcept { return empty_.load(); }
  /// Removes one link and returns it; null if there is none.
  [[nodiscard]] std::shared_ptr<LinkCredit> Take() noexcept;

 private:
  const std::shared_ptr<Waker> waker_;
  std::mutex mutex_;
  std::vector<std::weak_ptr<LinkCredit>> links_;
  std::size_t members_ = 0;
  std::atomic<bool> empty_{true};
};

}  // namespace hgros::zmq
