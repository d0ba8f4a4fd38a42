#include "services/reply_line.hpp"

#include <string>
#include <utility>

#include "hgros/internal/codec/call_message.hpp"
#include "hgros/services/service_place.hpp"

namespace hgros {

namespace {

std::shared_ptr<const CallMessage> RefusalOf(const CallMessage& reply, PublishStatus status) {
  auto refusal = std::make_shared<CallMessage>(reply);
  refusal->body = nullptr;
  refusal->outcome = CallMessage::Outcome::kNotWritable;
  refusal->text = "The reply could not be written: " + std::string(ToString(status)) + ".";
  return refusal;
}

}  // namespace

PublishStatus SendCall(SessionOutlet& outlet, const std::shared_ptr<const CallMessage>& call, const TypeInfo& type) {
  PreparedMessage prepared;
  const PublishStatus status = outlet.Reserve(call.get(), type, prepared);
  if (status != PublishStatus::kOk) return status;
  MessageInfo info;
  info.cause = call->cause;
  return outlet.Commit(call, type, info, std::move(prepared)) ? PublishStatus::kOk : PublishStatus::kNoMemory;
}

PublishStatus ReplyLine::Pass(const std::shared_ptr<const CallMessage>& reply) {
  return SendCall(*outlet_, reply, type_);
}

// After Commit() has failed, the caller may have got the reply. Then it ignores the refusal: its call has ended.
bool ReplyLine::TrySend(std::shared_ptr<const CallMessage>& reply) {
  if (outlet_->subscriber_count() == 0) return false;
  PublishStatus status = Pass(reply);
  if (status != PublishStatus::kOk && status != PublishStatus::kFull) {
    reply = RefusalOf(*reply, status);
    status = Pass(reply);
  }
  return status == PublishStatus::kOk;
}

bool ReplyLine::Send(std::shared_ptr<const CallMessage> reply) {
  if (TrySend(reply)) return true;
  {
    const std::scoped_lock lock(mutex_);
    if (closed_) return false;
    if (waiting_.size() < kMaxWaiting) {
      waiting_.push_back(std::move(reply));
      reply.reset();
    }
  }
  if (reply) {
    log_->WriteLimited(LogLevel::kWarning, "reply " + service_,
                       "A reply of service \"" + service_ +
                           "\" was dropped: the caller does not take its replies, and " + std::to_string(kMaxWaiting) +
                           " are waiting already.");
    return false;
  }
  // A subscription or room may have come after the attempt and before the reply was queued.
  flush_soon_();
  return true;
}

std::size_t ReplyLine::Close() {
  std::deque<std::shared_ptr<const CallMessage>> dropped;  // Destroyed after the lock: destructors may be user code.
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  dropped.swap(waiting_);
  return dropped.size();
}

void ReplyLine::Flush() {
  std::unique_lock lock(mutex_);
  while (!waiting_.empty()) {
    std::shared_ptr<const CallMessage> next = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    const bool sent = TrySend(next);
    lock.lock();
    if (sent) continue;
    waiting_.push_front(std::move(next));
    return;
  }
}

}  // namespace hgros
