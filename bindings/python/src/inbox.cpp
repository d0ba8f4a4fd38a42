#include "inbox.hpp"

#include <algorithm>
#include <utility>
#include <variant>

namespace hgros::python {
namespace {

// A turn that is dropped is missed, as are those that it missed itself.
void CountAsMissed(const Arrival& dropped, Arrival& next) {
  const auto* turn = std::get_if<Tick>(&dropped);
  auto* later = std::get_if<Tick>(&next);
  if (turn != nullptr && later != nullptr) later->missed += turn->missed + 1;
}

}  // namespace

void Inbox::SetQueue(const Queue& queue) {
  RefuseInChild();
  std::deque<Arrival> dropped;  // Released after the lock.
  std::unique_lock lock(mutex_);
  queue_ = queue;
  while (!queue.lossless() && arrivals_.size() > queue.depth()) {
    bytes_ -= BytesOf(arrivals_.front());
    dropped.push_back(std::move(arrivals_.front()));
    arrivals_.pop_front();
    ++dropped_;
  }
  const HandedOver node = node_;
  lock.unlock();  // The node may log it.
  for (std::size_t i = 0; i < dropped.size(); ++i) node.CountDropped();
}

void Inbox::SetNode(const HandedOver& node) {
  const std::scoped_lock lock(mutex_);
  node_ = node;
}

void Inbox::Finish(bool failed) {
  if (of_parent()) handled_.reset();  // The callback has forked, perhaps while another thread held the mutex.
  if (!handled_) return;
  std::unique_lock lock(mutex_);
  const HandedOver node = node_;
  lock.unlock();
  node.CountRun(handled_->info, handled_->start_ns, MonotonicNow(), failed);
  handled_.reset();
}

void Inbox::Skip() {
  handled_.reset();
  if (of_parent()) return;
  std::unique_lock lock(mutex_);
  const HandedOver node = node_;
  lock.unlock();
  node.CountRefused();
}

bool Inbox::HasRoomLocked() const noexcept {
  if (!queue_ || !queue_->lossless() || arrivals_.empty()) return true;
  return arrivals_.size() < std::min(queue_->depth(), kLosslessRoom) && bytes_ < kLosslessBytes;
}

void Inbox::Push(Arrival arrival) {
  std::optional<Arrival> oldest;  // Released after the lock.
  std::unique_lock lock(mutex_);
  room_.wait(lock, [this] { return closed_ || HasRoomLocked(); });
  if (closed_) return;
  if (queue_ && !queue_->lossless() && arrivals_.size() >= queue_->depth()) {
    bytes_ -= BytesOf(arrivals_.front());
    oldest = std::move(arrivals_.front());
    arrivals_.pop_front();
    ++dropped_;
    CountAsMissed(*oldest, arrivals_.empty() ? arrival : arrivals_.front());
  }
  bytes_ += BytesOf(arrival);
  arrivals_.push_back(std::move(arrival));
  if (!std::exchange(announced_, true)) ready_->Add(key_);
  if (!oldest) return;
  const HandedOver node = node_;
  lock.unlock();  // The node may log it.
  node.CountDropped();
}

std::vector<Arrival> Inbox::Take(std::size_t most) {
  RefuseInChild();
  std::vector<Arrival> taken;
  {
    const std::scoped_lock lock(mutex_);
    const std::size_t count = std::min(most, arrivals_.size());
    taken.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      bytes_ -= BytesOf(arrivals_.front());
      taken.push_back(std::move(arrivals_.front()));
      arrivals_.pop_front();
    }
    announced_ = !arrivals_.empty();
    if (announced_) ready_->Add(key_);
  }
  room_.notify_all();
  return taken;
}

std::optional<Arrival> Inbox::TakeOne(bool& more) {
  bool other = false;
  return TakeOneIf([](const Arrival&) { return true; }, more, other);
}

std::optional<Arrival> Inbox::TakeKnown(bool& more, bool& other) {
  const auto is_known = [this](const Arrival& arrival) {
    const auto* heard = std::get_if<Heard>(&arrival);
    return heard != nullptr && heard->message.schema == last_schema_;
  };
  return TakeOneIf(is_known, more, other);
}

template <class Fits>
std::optional<Arrival> Inbox::TakeOneIf(Fits fits, bool& more, bool& other) {
  RefuseInChild();
  std::optional<Arrival> taken;
  bool lossless = false;
  {
    const std::scoped_lock lock(mutex_);
    other = !arrivals_.empty() && !fits(arrivals_.front());
    if (!arrivals_.empty() && !other) {
      bytes_ -= BytesOf(arrivals_.front());
      taken = std::move(arrivals_.front());
      arrivals_.pop_front();
    }
    announced_ = more = !arrivals_.empty();
    lossless = queue_ && queue_->lossless();
  }
  if (lossless) room_.notify_all();
  return taken;
}

void Inbox::Clear() {
  std::deque<Arrival> left;  // Released after the lock.
  {
    const std::scoped_lock lock(mutex_);
    left.swap(arrivals_);
    bytes_ = 0;
    announced_ = false;
  }
  room_.notify_all();
}

void Inbox::Close() {
  if (of_parent()) return;
  std::deque<Arrival> left;  // Released after the lock.
  {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
    left.swap(arrivals_);
    bytes_ = 0;
  }
  room_.notify_all();
}

std::uint64_t Inbox::dropped() const {
  RefuseInChild();
  const std::scoped_lock lock(mutex_);
  return dropped_;
}

std::size_t Inbox::queued() const {
  RefuseInChild();
  const std::scoped_lock lock(mutex_);
  return arrivals_.size();
}

}  // namespace hgros::python
