#include "component/input_gate.hpp"

#include <algorithm>
#include <chrono>

#include "hgros/base/cause.hpp"
#include "hgros/graph/running_node.hpp"

namespace hgros {
namespace {

constexpr std::size_t kMostWaiting = 1024;
constexpr std::size_t kFewWaiting = kMostWaiting / 2;  // Then the subscription brings more.
constexpr std::chrono::milliseconds kDrainPatience{100};
constexpr std::size_t kMostPublishers = 256;  // Whose positions are known.

auto Find(auto& positions, const MessageInfo& info) {
  return std::ranges::find_if(positions, [sender = SenderOf(info.id)](const InputGate::Position& one) {
    return SenderOf(one.last.id) == sender;
  });
}

}  // namespace

InputGate::InputGate(std::string node, const TypeInfo& type, bool takes_late, AnyCallback callback,
                     std::shared_ptr<ComponentGuard> guard)
    : node_(std::move(node)),
      type_(type),
      takes_late_(takes_late),
      callback_(std::move(callback)),
      guard_(std::move(guard)) {}

bool InputGate::TrySuspend() {
  if (suspend_) return true;
  suspend_ = SuspenderOfRunningNode();
  if (suspend_) suspend_(true);
  return suspend_ != nullptr;
}

void InputGate::Continue() {
  if (suspend_) std::exchange(suspend_, nullptr)(false);
}

void InputGate::Take(const AnyMessage& message, const MessageInfo& info) {
  guard_->Run([&] {
    std::function<void()> wake;
    Waiting dropped;  // Ends outside the lock.
    {
      std::unique_lock lock(mutex_);
      if (drains_ && *drains_ != std::this_thread::get_id() && !TrySuspend()) {
        room_.wait_for(lock, kDrainPatience, [this] { return !drains_; });
      }
      room_.wait(lock, [this] {
        return state_ != State::kHolds || waiting_.size() < kMostWaiting || full_ == Full::kDropsOldest || suspend_;
      });
      if (state_ == State::kClosed || Skips(info)) return;
      if (state_ == State::kPasses) {
        Note(info);
      } else {
        if (waiting_.size() >= kMostWaiting && full_ == Full::kDropsOldest) {
          dropped = std::move(waiting_.front());
          waiting_.pop_front();
        }
        waiting_.push_back({message, info});
        if (waiting_.size() >= kMostWaiting && full_ == Full::kWaits) (void)TrySuspend();
        wake = wake_;
      }
    }
    if (wake) {
      wake();
    } else {
      callback_(message, info);
    }
  });
}

void InputGate::Hold(std::function<void()> wake, Full full) {
  const std::scoped_lock lock(mutex_);
  if (state_ == State::kPasses) state_ = State::kHolds;
  wake_ = std::move(wake);
  full_ = full;
}

std::optional<InputGate::Waiting> InputGate::Next() {
  const std::scoped_lock lock(mutex_);
  if (waiting_.empty()) return std::nullopt;
  Waiting next = std::move(waiting_.front());
  waiting_.pop_front();
  if (waiting_.size() <= kFewWaiting && !drains_) Continue();
  room_.notify_all();
  return next;
}

void InputGate::Pass(const std::function<void(Waiting)>& handle, bool skip_handled) {
  std::unique_lock lock(mutex_);
  drains_ = std::this_thread::get_id();
  while (!waiting_.empty()) {
    lock.unlock();
    while (auto next = Next()) handle(std::move(*next));
    lock.lock();
  }
  drains_.reset();
  Continue();
  if (skip_handled) skipped_ = positions_;
  if (state_ == State::kHolds) state_ = State::kPasses;
  room_.notify_all();
}

void InputGate::Close() {
  std::deque<Waiting> dropped;  // Ends outside the lock.
  const std::scoped_lock lock(mutex_);
  if (state_ != State::kHolds) return;
  state_ = State::kClosed;
  drains_.reset();
  dropped.swap(waiting_);
  Continue();
  room_.notify_all();
}

void InputGate::Handle(const Waiting& waiting) {
  {
    const std::scoped_lock lock(mutex_);
    Note(waiting.info);
  }
  const CauseScope cause({waiting.info.key, waiting.info.cause.began_ns, waiting.info.cause.origin});
  guard_->Run([&] { callback_(waiting.message, waiting.info); });
}

void InputGate::Note(const MessageInfo& info) {
  if (info.number == 0) return;
  const auto found = Find(positions_, info);
  if (found == positions_.end()) {
    if (positions_.size() == kMostPublishers) positions_.erase(positions_.begin());
    positions_.push_back({info});
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
  return passed && !(takes_late_ && found->gaps.Has(info.number));
}

void InputGate::NotePosition(const MessageInfo& last) {
  const std::scoped_lock lock(mutex_);
  Note(last);
}

std::vector<InputGate::Position> InputGate::Positions() const {
  const std::scoped_lock lock(mutex_);
  return positions_;
}

}  // namespace hgros
