#include "transport/zmq/subscribe/due_credits.hpp"

#include <algorithm>

namespace hgros::zmq {

// Links that have ended stay in the list until it is emptied.
void DueCredits::Join() {
  const std::scoped_lock lock(mutex_);
  const std::size_t needed = links_.size() + members_ + 1;
  if (links_.capacity() < needed) links_.reserve(std::max(needed, 2 * links_.capacity()));
  ++members_;
}

void DueCredits::Leave() noexcept {
  const std::scoped_lock lock(mutex_);
  --members_;
}

void DueCredits::Add(std::weak_ptr<LinkCredit> link, bool wake) noexcept {
  {
    const std::scoped_lock lock(mutex_);
    links_.push_back(std::move(link));
    empty_.store(false);
  }
  if (wake) waker_->Wake();
}

std::shared_ptr<LinkCredit> DueCredits::Take() noexcept {
  const std::scoped_lock lock(mutex_);
  std::shared_ptr<LinkCredit> link;
  while (!link && !links_.empty()) {
    link = links_.back().lock();
    links_.pop_back();
  }
  empty_.store(links_.empty());
  return link;
}

}  // namespace hgros::zmq
