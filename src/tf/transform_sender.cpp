#include "tf/transform_sender.hpp"

#include <algorithm>
#include <utility>

#include "hgros/clock/system_clocks.hpp"
#include "tf/transform_messages.hpp"

namespace hgros::tf {
namespace {

constexpr Duration kUntilThereIsRoom = std::chrono::milliseconds(20);

}  // namespace

TransformSender::TransformSender(Session& session, Duration batch)
    : session_(session), batch_(std::max(batch, Duration::zero())), clock_(std::make_shared<SteadyClock>()) {
  static_.keeps = true;
}

TransformSender::~TransformSender() {
  {
    const std::scoped_lock lock(mutex_);
    closing_ = true;
  }
  timers_.reset();
  Flush();
}

void TransformSender::OpenMoving() { Open(moving_, kTransformsChannel, {}); }
void TransformSender::OpenStatic() { Open(static_, kStaticTransformsChannel, {.latched = 1}); }

void TransformSender::Open(Lane& lane, std::string_view channel, PublishOptions options) {
  std::call_once(lane.opened, [&] { lane.publisher = session_.Advertise<Message>(channel, options); });
}

void TransformSender::SendMoving(std::span<const StampedEdge* const> edges) {
  if (edges.empty()) return;
  std::unique_lock lock(mutex_);
  for (const StampedEdge* edge : edges) {
    Append(moving_.waiting, edge->parent, edge->child, edge->stamp, edge->T_parent_child);
  }
  Touch(moving_, lock);
}

void TransformSender::SendStatic(std::span<const StampedEdge* const> edges, const std::shared_ptr<EdgeSetter>& setter) {
  if (edges.empty()) return;
  std::unique_lock lock(mutex_);
  const bool by_constructor = setter && setter->constructing;
  if (setter && setter->withholds) {
    for (const StampedEdge* edge : edges) setter->withheld.push_back({*edge, by_constructor});
    return;
  }
  for (const StampedEdge* edge : edges) PutStatic(*edge, setter, by_constructor);
  Touch(static_, lock);
}

void TransformSender::PutStatic(const StampedEdge& edge, const std::shared_ptr<EdgeSetter>& setter,
                                bool by_constructor) {
  auto& all = *static_.waiting.mutable_transforms();
  Append(static_.waiting, edge.parent, edge.child, WallNow(), edge.T_parent_child);
  const auto [place, is_new] = static_places_.try_emplace(edge.child, StaticPlace{all.size() - 1, {}, false});
  place->second.setter = setter;
  place->second.by_constructor = by_constructor;
  if (is_new) return;
  all.SwapElements(place->second.index, all.size() - 1);
  all.RemoveLast();
}

void TransformSender::SetConstructing(EdgeSetter& setter, bool constructing) {
  const std::scoped_lock lock(mutex_);
  setter.constructing = constructing;
}

std::vector<StampedEdge> TransformSender::Withhold(EdgeSetter& setter) {
  std::vector<StampedEdge> withdrawn;
  std::unique_lock lock(mutex_);
  setter.withholds = true;
  Message left;
  for (foxglove::FrameTransform& one : *static_.waiting.mutable_transforms()) {
    const auto place = static_places_.find(one.child_frame_id());
    if (place->second.setter.get() == &setter) {
      withdrawn.push_back({one.parent_frame_id(), one.child_frame_id(), {}, TransformOf(one)});
      setter.withheld.push_back({withdrawn.back(), place->second.by_constructor});
      static_places_.erase(place);
    } else {
      place->second.index = left.transforms_size();
      left.add_transforms()->Swap(&one);
    }
  }
  static_.waiting = std::move(left);
  if (!withdrawn.empty()) Touch(static_, lock);
  return withdrawn;
}

bool TransformSender::Withholds(const EdgeSetter& setter) const {
  const std::scoped_lock lock(mutex_);
  return setter.withholds;
}

std::vector<EdgeSetter::Withheld> TransformSender::Withheld(const EdgeSetter& setter) const {
  const std::scoped_lock lock(mutex_);
  return setter.withheld;
}

bool TransformSender::Release(const std::shared_ptr<EdgeSetter>& setter, std::size_t count,
                              std::span<const EdgeSetter::Withheld> edges) {
  std::unique_lock lock(mutex_);
  if (setter->withheld.size() != count) return false;
  setter->withholds = false;
  setter->withheld.clear();
  for (const EdgeSetter::Withheld& one : edges) PutStatic(one.edge, setter, one.by_constructor);
  if (!edges.empty()) Touch(static_, lock);
  return true;
}

void TransformSender::Touch(Lane& lane, std::unique_lock<std::mutex>& lock) {
  lane.changed = true;
  if (lane.armed || lane.sending) return;  // The timer, or the sending thread, checks again.
  const Time now = clock_->Now();
  if (now < lane.quiet_until) {
    Arm(lane, now, lock);
  } else {
    Send(lane, lock);
  }
}

void TransformSender::Arm(Lane& lane, Time now, std::unique_lock<std::mutex>& lock) {
  if (closing_) return;
  if (!timers_) timers_.emplace(clock_);
  lane.armed = true;
  const Timer spent = std::exchange(lane.timer, timers_->After(std::max(lane.quiet_until - now, Duration::zero()),
                                                               [this, &lane](const Tick&) { OnTimer(lane); }));
  lock.unlock();  // The old timer's callback may still be about to return, and its destructor waits for that.
}

void TransformSender::OnTimer(Lane& lane) {
  std::unique_lock lock(mutex_);
  lane.armed = false;
  if (lane.changed && !lane.sending) Send(lane, lock);
}

void TransformSender::Send(Lane& lane, std::unique_lock<std::mutex>& lock) {
  lane.sending = true;
  lane.changed = false;
  lane.quiet_until = clock_->Now() + batch_;
  const std::shared_ptr<const Message> message = MakeMessage(lane);
  const auto count = static_cast<std::uint64_t>(message->transforms_size());
  lock.unlock();
  const PublishStatus status = lane.publisher(message);
  lock.lock();
  lane.sending = false;
  if (status == PublishStatus::kOk) {
    ++sent_messages_;
    sent_transforms_ += count;
  } else if (lane.keeps && status == PublishStatus::kFull && !closing_) {
    lane.changed = true;
    lane.quiet_until = clock_->Now() + std::max(batch_, kUntilThereIsRoom);
  } else {
    unsent_transforms_ += count;
  }
  if (lane.changed && !lane.armed) Arm(lane, clock_->Now(), lock);
}

std::shared_ptr<const TransformSender::Message> TransformSender::MakeMessage(Lane& lane) const {
  auto message = lane.keeps ? std::make_unique<Message>(lane.waiting)
                            : std::make_unique<Message>(std::exchange(lane.waiting, Message()));
  const std::scoped_lock lock(sent_->mutex);
  sent_->messages.insert(message.get());
  return {message.release(), [sent = sent_](const Message* ended) {
            {
              const std::scoped_lock lock_sent(sent->mutex);
              sent->messages.erase(ended);
            }
            delete ended;
          }};
}

void TransformSender::Flush() {
  for (Lane* lane : {&moving_, &static_}) {
    std::unique_lock lock(mutex_);
    if (lane->changed && !lane->sending) Send(*lane, lock);
  }
}

bool TransformSender::IsOwn(const foxglove::FrameTransforms& message) const {
  const std::scoped_lock lock(sent_->mutex);
  return sent_->messages.contains(&message);
}

}  // namespace hgros::tf
