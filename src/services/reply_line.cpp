#include "services/reply_line.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "hgros/base/memory_room.hpp"
#include "hgros/internal/codec/call_message.hpp"
#include "hgros/services/service_place.hpp"

namespace hgros {

namespace {

// How often a line looks for replies whose calls have timed out.
constexpr auto kLeastPause = std::chrono::milliseconds(20);
constexpr auto kMostPause = std::chrono::seconds(1);
// Refusals may wait in this number even if replies leave no room.
constexpr std::size_t kMaxRefusals = 4096;

std::shared_ptr<const CallMessage> RefusalOf(const CallMessage& reply, std::string text) {
  auto refusal = std::make_shared<CallMessage>(reply);
  refusal->body = nullptr;
  refusal->outcome = CallMessage::Outcome::kNotWritable;
  refusal->text = std::move(text);
  return refusal;
}

}  // namespace

std::shared_ptr<ServiceRoom> ServiceRoom::OfFreeMemory() {
  auto room = std::make_shared<ServiceRoom>();
  const std::uint64_t free = FreeMemory().value_or(std::numeric_limits<std::uint64_t>::max());
  room->caller_bytes = static_cast<std::size_t>(std::min<std::uint64_t>(room->caller_bytes, free / 8));
  room->service_bytes = 2 * room->caller_bytes;
  return room;
}

std::size_t BytesOf(const CallMessage& call) {
  const bool measured = call.body && call.type != nullptr && call.type->memory_bytes != nullptr;
  return sizeof(CallMessage) + call.text.size() + (measured ? call.type->memory_bytes(call.body.get()) : 0);
}

PublishStatus SendCall(SessionOutlet& outlet, const std::shared_ptr<const CallMessage>& call, const TypeInfo& type) {
  PreparedMessage prepared;
  const PublishStatus status = outlet.Reserve(call.get(), type, prepared);
  if (status != PublishStatus::kOk) return status;
  MessageInfo info;
  info.cause = call->cause;
  return outlet.Commit(call, type, info, std::move(prepared)) ? PublishStatus::kOk : PublishStatus::kNoMemory;
}

ReplyLine::ReplyLine(std::shared_ptr<SessionOutlet> outlet, const TypeInfo& type, std::shared_ptr<Log> log,
                     std::string service, std::string caller, std::shared_ptr<ServiceRoom> room, Means means)
    : outlet_(std::move(outlet)),
      type_(type),
      log_(std::move(log)),
      service_(std::move(service)),
      caller_(std::move(caller)),
      room_(std::move(room)),
      means_(std::move(means)) {}

PublishStatus ReplyLine::Pass(const std::shared_ptr<const CallMessage>& reply) {
  return SendCall(*outlet_, reply, type_);
}

// After Commit() has failed, the caller may have got the reply. Then it ignores the refusal: its call has ended.
bool ReplyLine::TrySend(std::shared_ptr<const CallMessage>& reply) {
  if (outlet_->subscriber_count() == 0) return false;
  PublishStatus status = Pass(reply);
  if (status != PublishStatus::kOk && status != PublishStatus::kFull) {
    reply = RefusalOf(*reply, "The reply could not be written: " + std::string(ToString(status)) + ".");
    status = Pass(reply);
  }
  return status == PublishStatus::kOk;
}

bool ReplyLine::Send(std::shared_ptr<const CallMessage> reply, std::optional<Moment> due) {
  if (TrySend(reply)) return true;
  Waiting waiting{std::move(reply), due, 0};
  waiting.bytes = BytesOf(*waiting.reply);
  const bool queued = TryQueue(waiting);
  if (!queued) {
    {
      const std::scoped_lock lock(mutex_);
      if (closed_) return false;
    }
    const std::string why = std::to_string(room_->caller_bytes >> 20U) + " MiB, or " + std::to_string(kMaxWaiting) +
                            " replies, wait for the caller already";
    SayDropped(why);
    Waiting refusal{RefusalOf(*waiting.reply, "The reply was dropped: " + why + "."), due, 0};
    waiting = {};
    (void)TryQueue(refusal);
  }
  // A subscription or room may have come after the attempt and before the reply was queued.
  means_.flush_soon();
  return queued;
}

bool ReplyLine::TryQueue(Waiting& reply) {
  std::optional<Moment> look;
  {
    const std::scoped_lock lock(mutex_);
    if (closed_ || !HasRoomFor(reply)) return false;
    look = NextLook(reply.due, std::chrono::steady_clock::now());
    Count(reply);
    waiting_.push_back(std::move(reply));
  }
  if (look) means_.flush_at(*look);
  return true;
}

// The first reply may be of any size, unless other callers have used up the room of the service.
bool ReplyLine::HasRoomFor(const Waiting& reply) const {
  if (reply.bytes == 0) return waiting_.size() < kMaxWaiting + kMaxRefusals;
  const std::size_t all = room_->reply_bytes.load(std::memory_order_relaxed);
  if (bytes_ == 0) return all <= room_->service_bytes;
  return waiting_.size() < kMaxWaiting && bytes_ + reply.bytes <= room_->caller_bytes &&
         all + reply.bytes <= room_->service_bytes;
}

void ReplyLine::Count(const Waiting& reply) {
  bytes_ += reply.bytes;
  room_->reply_bytes.fetch_add(reply.bytes, std::memory_order_relaxed);
}

void ReplyLine::Discount(const Waiting& reply) {
  bytes_ -= reply.bytes;
  room_->reply_bytes.fetch_sub(reply.bytes, std::memory_order_relaxed);
}

// One look is asked for at a time. Later replies may be due earlier, so it comes soon.
std::optional<ReplyLine::Moment> ReplyLine::NextLook(std::optional<Moment> due, Moment now) {
  if (!due || looks_at_) return std::nullopt;
  looks_at_ = std::clamp(*due, now + kLeastPause, now + kMostPause);
  return looks_at_;
}

std::deque<ReplyLine::Waiting> ReplyLine::TakeOverdue(Moment now) {
  std::deque<Waiting> overdue;
  std::deque<Waiting> left;
  for (Waiting& one : waiting_) {
    const bool late = one.due && *one.due <= now;
    if (late) Discount(one);
    (late ? overdue : left).push_back(std::move(one));
  }
  waiting_ = std::move(left);
  return overdue;
}

void ReplyLine::SayDropped(const std::string& when) {
  {
    const std::scoped_lock lock(mutex_);
    const Moment now = std::chrono::steady_clock::now();
    if (said_at_ && now - *said_at_ < kMostPause) return;  // Many may be dropped, and finding out why takes long.
    said_at_ = now;
  }
  log_->WriteLimited(LogLevel::kWarning, "reply " + service_,
                     "A reply of service \"" + service_ + "\" to session " + caller_ + " was dropped: " + when + ". " +
                         means_.why(outlet_->subscriber_count() > 0));
}

bool ReplyLine::Withdraw(std::uint64_t call) {
  Waiting dropped;  // Destroyed after the lock: destructors may be user code.
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find_if(waiting_, [&](const Waiting& one) { return one.reply->call == call; });
  if (found == waiting_.end()) return false;
  Discount(*found);
  dropped = std::move(*found);
  waiting_.erase(found);
  return true;
}

std::size_t ReplyLine::Close() {
  std::deque<Waiting> dropped;  // Destroyed after the lock: destructors may be user code.
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  dropped.swap(waiting_);
  for (const Waiting& one : dropped) Discount(one);
  return dropped.size();
}

std::size_t ReplyLine::Flush() {
  std::deque<Waiting> overdue;
  std::optional<Moment> look;
  Waiting next;  // Destroyed after the lock, as the overdue ones: destructors may be user code.
  std::unique_lock lock(mutex_);
  if (const Moment now = std::chrono::steady_clock::now(); looks_at_ && *looks_at_ <= now) {
    overdue = TakeOverdue(now);
    looks_at_.reset();
    std::optional<Moment> first;
    for (const Waiting& one : waiting_) {
      if (one.due) first = std::min(first.value_or(*one.due), *one.due);
    }
    look = NextLook(first, now);
  }
  while (!waiting_.empty()) {
    next = std::move(waiting_.front());
    waiting_.pop_front();
    Discount(next);
    lock.unlock();
    const bool sent = TrySend(next.reply);
    if (sent) next = {};
    lock.lock();
    if (sent) continue;
    if (!closed_) {
      Count(next);
      waiting_.push_front(std::move(next));
    }
    break;
  }
  lock.unlock();
  if (look) means_.flush_at(*look);
  if (!overdue.empty()) SayDropped("it still waited when its call had timed out");
  return overdue.size();
}

}  // namespace hgros
