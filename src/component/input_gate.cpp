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

}  // namespace

InputGate::InputGate(std::string node, const TypeInfo& type, AnyCallback callback,
                     std::shared_ptr<ComponentGuard> guard)
    : node_(std::move(node)), type_(type), callback_(std::move(callback)), guard_(std::move(guard)) {}

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
      if (state_ == State::kClosed) return;
      if (state_ == State::kPasses) {
        if (!skipped_.empty() && Skips(info)) return;
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
  const auto found = std::ranges::find_if(positions_, [&](const MessageInfo& one) {
    return one.id.publisher == info.id.publisher && one.id.incarnation == info.id.incarnation;
  });
  if (found == positions_.end()) {
    if (positions_.size() == kMostPublishers) positions_.erase(positions_.begin());
    positions_.push_back(info);
    return;
  }
  // Here and over a transport, a message has two sequence numbers.
  const std::uint64_t before = found->remote == info.remote ? found->id.sequence : 0;
  found->id.sequence = std::max(before, info.id.sequence);
  found->number = std::max(found->number, info.number);
  found->remote = info.remote;
}

bool InputGate::Skips(const MessageInfo& info) {
  const auto found = std::ranges::find_if(skipped_, [&](const MessageInfo& one) {
    return one.id.publisher == info.id.publisher && one.id.incarnation == info.id.incarnation;
  });
  if (found == skipped_.end()) return false;
  const bool handled =
      info.remote && found->remote ? info.id.sequence <= found->id.sequence : info.number <= found->number;
  if (!handled) skipped_.erase(found);
  return handled;
}

void InputGate::NotePosition(const MessageInfo& last) {
  const std::scoped_lock lock(mutex_);
  Note(last);
}

std::vector<MessageInfo> InputGate::Positions() const {
  const std::scoped_lock lock(mutex_);
  return positions_;
}

}  // namespace hgros
