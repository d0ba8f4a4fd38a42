#include "component/input_gate.hpp"

#include <algorithm>
#include <chrono>

#include "hgros/base/cause.hpp"

namespace hgros {
namespace {

constexpr std::size_t kMostWaiting = 1024;
constexpr std::chrono::milliseconds kDrainPatience{100};
constexpr std::chrono::milliseconds kCatchUp{100};  // After this, an input that keeps the newest drops older ones.
constexpr std::size_t kMostPublishers = 256;        // Whose positions are known.

auto Find(auto& positions, const MessageInfo& info) {
  return std::ranges::find_if(positions, [sender = SenderOf(info.id)](const InputGate::Position& one) {
    return SenderOf(one.last.id) == sender;
  });
}

}  // namespace

InputGate::InputGate(std::string node, const TypeInfo& type, Invoke invoke, Queue queue, AnyCallback callback,
                     std::shared_ptr<ComponentGuard> guard)
    : node_(std::move(node)),
      type_(type),
      invoke_(invoke),
      callback_(std::move(callback)),
      guard_(std::move(guard)),
      queue_(queue) {}

void InputGate::Join(const Subscription& subscription) {
  const Queue queue = subscription.stats().queue;
  const std::scoped_lock lock(mutex_);
  queue_ = queue;
  node_queue_ = NodeQueue(subscription);
  SuspendIfFull();
}

bool InputGate::takes_late() const {
  const std::scoped_lock lock(mutex_);
  return TakesLate();
}

std::size_t InputGate::most() const {
  const std::scoped_lock lock(mutex_);
  return Most();
}

std::size_t InputGate::Most() const noexcept {
  return queue_.lossless() ? std::min(queue_.depth(), kMostWaiting) : kMostWaiting;
}

bool InputGate::TrySuspend() {
  if (node_queue_ && !std::exchange(suspended_, true)) node_queue_.Suspend(true);
  return suspended_;
}

// No thread of a queue waits here.
void InputGate::SuspendIfFull() {
  const bool full = state_ == State::kHolds && full_ == Full::kWaits && waiting_.size() >= Most();
  if (full && TrySuspend()) room_.notify_all();
}

void InputGate::Continue() {
  if (std::exchange(suspended_, false)) node_queue_.Suspend(false);
}

void InputGate::Take(const AnyMessage& message, const MessageInfo& info) {
  guard_->Run(node_, [&] {
    std::function<void()> wake;
    std::optional<Waiting> passes;
    Dropped dropped;  // Ends outside the lock.
    bool direct = false;
    {
      std::unique_lock lock(mutex_);
      if (message == nullptr) {
        passes = TakePassing(dropped);
        if (state_ == State::kHolds && passing_.size() == Most() / 2) wake = wake_;
      } else {
        if (drains_ && *drains_ != std::this_thread::get_id() && !TrySuspend()) {
          room_.wait_for(lock, kDrainPatience, [this] { return !drains_; });
        }
        room_.wait(lock, [this] {
          return state_ != State::kHolds || waiting_.size() < Most() || full_ == Full::kDropsOldest || suspended_;
        });
        if (state_ == State::kClosed || Skips(info)) return;
        if (state_ == State::kHolds) {
          Keep({message, info}, dropped);
          wake = wake_;
        } else if (passing_.empty()) {
          Note(positions_, info);
          direct = true;
        } else {  // It was taken out of the queue before them.
          passing_.push_back({message, info});
          passes = TakePassing(dropped);
        }
      }
    }
    if (dropped.counts) dropped.counts.CountDropped();
    if (wake) wake();
    if (direct) callback_(message, info);
    if (passes) Call(*passes);
  });
}

void InputGate::Keep(Waiting message, Dropped& dropped) {
  if (waiting_.size() >= Most() && full_ == Full::kDropsOldest) {
    dropped.message = std::move(waiting_.front());
    waiting_.pop_front();
  }
  waiting_.push_back(std::move(message));
  SuspendIfFull();
}

std::optional<InputGate::Waiting> InputGate::TakePassing(Dropped& dropped) {
  if (passing_.empty()) return std::nullopt;
  Waiting next = std::move(passing_.front());
  passing_.pop_front();
  Note(positions_, next.info);
  const bool late = std::chrono::steady_clock::now() > catches_up_until_;
  if (queue_.lossless() || passing_.size() < queue_.depth() || !late) return next;
  dropped = {std::move(next), node_queue_};
  return std::nullopt;
}

void InputGate::Call(const Waiting& message) {
  const MessageInfo& info = message.info;
  const CauseScope cause({info.key, info.cause.began_ns, info.cause.origin});
  callback_(message.message, info);
}

void InputGate::Hold(std::function<void()> wake, Full full) {
  const std::scoped_lock lock(mutex_);
  if (state_ == State::kPasses) state_ = State::kHolds;
  waiting_.insert(waiting_.begin(), std::make_move_iterator(passing_.begin()), std::make_move_iterator(passing_.end()));
  passing_.clear();
  wake_ = std::move(wake);
  full_ = full;
  SuspendIfFull();
}

std::optional<InputGate::Waiting> InputGate::Next() {
  const std::scoped_lock lock(mutex_);
  if (waiting_.empty()) return std::nullopt;
  Waiting next = std::move(waiting_.front());
  waiting_.pop_front();
  if (waiting_.size() <= Most() / 2 && !drains_) Continue();
  room_.notify_all();
  return next;
}

bool InputGate::has_more() const {
  std::unique_lock lock(mutex_);
  const NodeQueue queue = node_queue_;
  lock.unlock();
  if (!queue.idle()) return true;
  lock.lock();
  return !waiting_.empty();
}

void InputGate::LetPass(Waiting message) {
  const MessageInfo info = message.info;
  Dropped dropped;  // Ends outside the lock.
  std::optional<Waiting> here;
  {
    const std::scoped_lock lock(mutex_);
    if (!node_queue_) {
      Note(positions_, info);
      here = std::move(message);
    } else {
      if (passing_.empty()) catches_up_until_ = std::chrono::steady_clock::now() + kCatchUp;
      passing_.push_back(std::move(message));
      if (passing_.size() > kMostWaiting && !queue_.lossless()) {
        dropped = {std::move(passing_.front()), node_queue_};
        passing_.pop_front();
        Note(positions_, dropped.message->info);
      }
    }
  }
  if (dropped.counts) dropped.counts.CountDropped();
  if (!here) return node_queue_.CallWithoutMessage(info);
  guard_->Run(node_, [&] { Call(*here); });
}

bool InputGate::has_room() const {
  const std::scoped_lock lock(mutex_);
  return passing_.size() < Most();
}

void InputGate::Pass(const std::function<void(Waiting)>& pass, bool skip_handled) {
  std::unique_lock lock(mutex_);
  drains_ = std::this_thread::get_id();
  while (!waiting_.empty()) {
    lock.unlock();
    while (auto next = Next()) pass(std::move(*next));
    lock.lock();
  }
  drains_.reset();
  Continue();
  if (skip_handled) {
    skipped_ = positions_;
    for (const Waiting& one : passing_) Note(skipped_, one.info);
  }
  if (state_ == State::kHolds) state_ = State::kPasses;
  room_.notify_all();
}

void InputGate::Close() {
  std::deque<Waiting> dropped;  // They end outside the lock.
  std::deque<Waiting> passing;
  const std::scoped_lock lock(mutex_);
  if (state_ != State::kHolds) return;
  state_ = State::kClosed;
  drains_.reset();
  dropped.swap(waiting_);
  passing.swap(passing_);
  Continue();
  room_.notify_all();
}

void InputGate::Note(std::vector<Position>& positions, const MessageInfo& info) {
  if (info.number == 0) return;
  const auto found = Find(positions, info);
  if (found == positions.end()) {
    if (positions.size() == kMostPublishers) positions.erase(positions.begin());
    positions.push_back({info});
    return;
  }
  // Here and over a transport, a message has two sequence numbers.
  MessageInfo& last = found->last;
  const std::uint64_t before = last.remote == info.remote ? last.id.sequence : 0;
  last.id.sequence = std::max(before, info.id.sequence);
  found->gaps.Note(last.number, info.number);
  last.number = std::max(last.number, info.number);
  last.remote = info.remote;
}

bool InputGate::Skips(const MessageInfo& info) const {
  const auto found = Find(skipped_, info);
  if (found == skipped_.end() || info.number == 0) return false;
  const MessageInfo& last = found->last;
  const bool passed = info.remote && last.remote ? info.id.sequence <= last.id.sequence : info.number <= last.number;
  return passed && !(TakesLate() && found->gaps.Has(info.number));
}

void InputGate::NotePosition(const MessageInfo& last) {
  const std::scoped_lock lock(mutex_);
  Note(positions_, last);
}

std::vector<InputGate::Position> InputGate::Positions() const {
  const std::scoped_lock lock(mutex_);
  return positions_;
}

}  // namespace hgros
