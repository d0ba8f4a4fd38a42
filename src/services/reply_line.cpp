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

std::string MiBText(std::size_t bytes) { return std::to_string(bytes >> 20U) + " MiB"; }

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
      means_(std::move(means)) {
  const std::scoped_lock lock(room_->mutex);
  room_->lines.push_back(this);
}

ReplyLine::~ReplyLine() {
  {
    const std::scoped_lock lock(room_->mutex);
    std::erase(room_->lines, this);
  }
  (void)Close();
}

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
  if (status != PublishStatus::kOk) subscribed_at_ = std::chrono::steady_clock::now();
  return status == PublishStatus::kOk;
}

bool ReplyLine::Send(std::shared_ptr<const CallMessage> reply, std::optional<Moment> due) {
  if (TrySend(reply)) return true;
  Waiting waiting{std::move(reply), due};
  waiting.bytes = BytesOf(*waiting.reply);
  Lack lack = TryQueue(waiting);
  while (lack == Lack::kRoomOfAll && TakeRoom(waiting)) lack = TryQueue(waiting);
  if (lack == Lack::kLine) return false;
  if (lack != Lack::kNothing) {
    const std::string why = lack == Lack::kRoomOfAll
                                ? MiBText(room_->service_bytes) + " of replies wait for all callers already"
                                : MiBText(room_->caller_bytes) + ", or " + std::to_string(kMaxWaiting) +
                                      " replies, wait for the caller already";
    SayDropped(why, BlameOf(0).away);
    Waiting refusal{RefusalOf(*waiting.reply, "The reply was dropped: " + why + "."), due};
    waiting = {};
    (void)TryQueue(refusal);
  }
  // A subscription or room may have come after the attempt and before the reply was queued.
  means_.flush_soon();
  return lack == Lack::kNothing;
}

ReplyLine::Lack ReplyLine::TryQueue(Waiting& reply) {
  std::optional<Moment> look;
  {
    const std::scoped_lock lock(mutex_);
    if (closed_) return Lack::kLine;
    if (const Lack lack = LackFor(reply); lack != Lack::kNothing) return lack;
    look = NextLook(EndOf(reply), std::chrono::steady_clock::now());
    Count(reply);
    waiting_.push_back(std::move(reply));
  }
  if (look) means_.flush_at(*look);
  return Lack::kNothing;
}

// The first reply may be of any size, unless other callers have used up the room of the service.
ReplyLine::Lack ReplyLine::LackFor(const Waiting& reply) const {
  if (reply.bytes == 0) return waiting_.size() < kMaxWaiting + kMaxRefusals ? Lack::kNothing : Lack::kRoomOfCaller;
  if (waiting_.size() >= kMaxWaiting || (bytes_ > 0 && bytes_ + reply.bytes > room_->caller_bytes)) {
    return Lack::kRoomOfCaller;
  }
  const std::size_t all = room_->reply_bytes.load(std::memory_order_relaxed) + (bytes_ > 0 ? reply.bytes : 0);
  return all <= room_->service_bytes ? Lack::kNothing : Lack::kRoomOfAll;
}

bool ReplyLine::TakeRoom(const Waiting& reply) {
  std::vector<Waiting> given_up;  // Destroyed after the lock: destructors may be user code.
  std::function<void()> flush;
  {
    const std::scoped_lock lock(room_->mutex);
    Blame most = BlameOf(reply.bytes);
    ReplyLine* holder = nullptr;
    for (ReplyLine* const line : room_->lines) {
      if (line == this) continue;
      if (const Blame blame = line->BlameOf(0); blame.bytes > 0 && blame > most) {
        most = blame;
        holder = line;
      }
    }
    if (holder == nullptr) return false;
    given_up = holder->GiveUp(reply.bytes);
    flush = holder->means_.flush_soon;  // It says what was dropped.
  }
  flush();
  return true;
}

std::vector<ReplyLine::Waiting> ReplyLine::GiveUp(std::size_t bytes) {
  const std::string why = MiBText(room_->service_bytes) + " of replies waited for all callers";
  std::vector<Waiting> given_up;
  const std::scoped_lock lock(mutex_);
  std::size_t got = 0;
  for (auto one = waiting_.begin(); one != waiting_.end() && got < bytes; ++one) {
    if (one->bytes == 0) continue;
    got += one->bytes;
    given_up.push_back(Refuse(*one, why));
  }
  given_up_ += given_up.size();
  return given_up;
}

ReplyLine::Waiting ReplyLine::Refuse(Waiting& reply, const std::string& why) {
  Waiting refusal{RefusalOf(*reply.reply, "The reply was dropped: " + why + "."), reply.due, 0, reply.since};
  Discount(reply);
  return std::exchange(reply, std::move(refusal));
}

ReplyLine::Blame ReplyLine::BlameOf(std::size_t more) {
  const std::scoped_lock lock(mutex_);
  return {AwayFor(std::chrono::steady_clock::now()) >= room_->fresh, bytes_ + more};
}

std::chrono::nanoseconds ReplyLine::AwayFor(Moment now) const {
  if (waiting_.empty() || outlet_->subscriber_count() > 0) return {};
  return now - std::max(subscribed_at_.load(), waiting_.front().since);
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
std::optional<ReplyLine::Moment> ReplyLine::NextLook(Moment due, Moment now) {
  if (due == Moment::max() || looks_at_) return std::nullopt;
  looks_at_ = std::clamp(due, now + kLeastPause, now + kMostPause);
  return looks_at_;
}

ReplyLine::Moment ReplyLine::EndOf(const Waiting& reply) const {
  const Moment due = reply.due.value_or(Moment::max());
  if (reply.bytes == 0) return due;
  const Moment seen = outlet_->subscriber_count() > 0 ? std::chrono::steady_clock::now() : subscribed_at_.load();
  return std::min(due, std::max(seen, reply.since) + room_->away);
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

std::vector<ReplyLine::Waiting> ReplyLine::TakeUnsubscribed(Moment now) {
  const std::string why =
      "the caller did not subscribe to it within " + std::to_string(room_->away.count() / 1000) + " s";
  std::vector<Waiting> taken;
  for (Waiting& one : waiting_) {
    if (one.bytes > 0 && EndOf(one) <= now) taken.push_back(Refuse(one, why));
  }
  return taken;
}

void ReplyLine::SayDropped(const std::string& when, bool waited) {
  {
    const std::scoped_lock lock(mutex_);
    const Moment now = std::chrono::steady_clock::now();
    if (said_at_ && now - *said_at_ < kMostPause) return;  // Many may be dropped, and finding out why takes long.
    said_at_ = now;
  }
  const bool subscribed = outlet_->subscriber_count() > 0;
  log_->WriteLimited(LogLevel::kWarning, "reply " + service_,
                     "A reply of service \"" + service_ + "\" to session " + caller_ + " was dropped: " + when + ". " +
                         (subscribed || waited ? means_.why(subscribed) : "Its subscription has not arrived yet."));
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
  std::vector<Waiting> unsubscribed;
  std::optional<Moment> look;
  Waiting next;  // Destroyed after the lock, as the overdue ones: destructors may be user code.
  std::unique_lock lock(mutex_);
  if (const Moment now = std::chrono::steady_clock::now(); looks_at_ && *looks_at_ <= now) {
    overdue = TakeOverdue(now);
    unsubscribed = TakeUnsubscribed(now);
    looks_at_.reset();
    Moment first = Moment::max();
    for (const Waiting& one : waiting_) first = std::min(first, EndOf(one));
    look = NextLook(first, now);
  }
  const std::size_t given_up = std::exchange(given_up_, 0);
  const bool away = AwayFor(std::chrono::steady_clock::now()) >= room_->fresh;
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
  if (!overdue.empty()) SayDropped("it still waited when its call had timed out", true);
  if (!unsubscribed.empty()) SayDropped("the caller did not subscribe to it in time", true);
  if (given_up > 0) SayDropped(MiBText(room_->service_bytes) + " of replies waited for all callers", away);
  return overdue.size() + unsubscribed.size() + given_up;
}

}  // namespace hgros
