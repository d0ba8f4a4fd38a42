#include "services/call_table.hpp"

#include <exception>
#include <string>

#include "hgros/base/forced_unwind.hpp"
#include "hgros/base/system_limits.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

CallTable::~CallTable() {
  if (!in_forked_child()) Close();
}

bool CallTable::Begin(const std::shared_ptr<CallState>& call, std::chrono::nanoseconds timeout) {
  bool sooner = false;
  {
    const std::scoped_lock lock(mutex_);
    if (closed_ || calls_.size() + answering_.load(std::memory_order_relaxed) >= kMaxCalls) return false;
    if (timeout != std::chrono::nanoseconds::max() && !thread_.joinable()) {
      thread_ = StartThread<std::jthread>("the thread that ends calls in time",
                                          [this](const std::stop_token& stop) { Loop(stop); });
    }
    call->number = ++last_number_;
    call->message->call = call->number;
    calls_.emplace(call->number, call);
    if (timeout != std::chrono::nanoseconds::max()) {
      call->due = DeadlineIn(timeout);
      due_.emplace(*call->due, call->number);
      sooner = *call->due < wakes_at_;
      if (sooner) wakes_at_ = *call->due;
    }
  }
  if (sooner) changed_.notify_one();
  return true;
}

std::shared_ptr<CallState> CallTable::Remove(std::uint64_t number) {
  const auto found = calls_.find(number);
  if (found == calls_.end()) return nullptr;
  std::shared_ptr<CallState> call = std::move(found->second);
  calls_.erase(found);
  if (call->due) due_.erase({*call->due, number});
  return call;
}

bool CallTable::End(std::uint64_t number, CallEnd end) {
  std::shared_ptr<CallState> call;
  {
    const std::scoped_lock lock(mutex_);
    call = Remove(number);
  }
  if (!call) return false;
  call->Finish(std::move(end));
  return true;
}

std::shared_ptr<CallState> CallTable::Find(std::uint64_t number) const {
  const std::scoped_lock lock(mutex_);
  const auto found = calls_.find(number);
  return found == calls_.end() ? nullptr : found->second;
}

void CallTable::EndAll(const std::function<std::optional<CallEnd>(const CallState&)>& end_of) {
  std::vector<std::shared_ptr<CallState>> calls;
  {
    const std::scoped_lock lock(mutex_);
    calls.reserve(calls_.size());
    for (const auto& [number, call] : calls_) calls.push_back(call);
  }
  for (const auto& call : calls) {
    if (auto end = end_of(*call)) End(call->number, std::move(*end));
  }
}

void CallTable::Close() {
  {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
    answers_ = {};  // Remaining callbacks run on this thread: the graph may end before it has run its queue.
  }
  EndAll([](const CallState& call) {
    return Failed(CallFailure::Kind::kClosed,
                  "The session ended while its call of service \"" + call.service() + "\" was under way.");
  });
  std::jthread thread;
  {
    const std::scoped_lock lock(mutex_);
    thread = std::move(thread_);
  }
  if (thread.get_id() == std::this_thread::get_id()) {  // The captures of a callback end the session.
    thread.request_stop();
    thread.detach();
  }
}

bool CallTable::closed() const {
  const std::scoped_lock lock(mutex_);
  return closed_;
}

void CallTable::SetAnswers(Publisher<AnsweredCall> answers) {
  const std::scoped_lock lock(mutex_);
  answers_ = std::move(answers);
}

void CallTable::Answer(const std::shared_ptr<const AnsweredCall>& answered) {
  Publisher<AnsweredCall> answers;
  {
    const std::scoped_lock lock(mutex_);
    answers = answers_;
  }
  answering_.fetch_add(1, std::memory_order_relaxed);
  if (answers(answered) == PublishStatus::kOk) return;
  answering_.fetch_sub(1, std::memory_order_relaxed);
  RunCallback(*answered);
}

void CallTable::RunCallback(const AnsweredCall& answered) noexcept {
  const auto failed = [&](const char* what) {
    log_->WriteLimited(
        LogLevel::kError, "answer callback " + answered.service,
        "The callback of a call of service \"" + answered.service + "\" threw: " + what + ". The call has ended.");
  };
  try {
    answered.callback(answered.end);
  } catch (const std::exception& error) {
    failed(error.what());
  } catch (const ForcedUnwind&) {
    EndAfterForcedUnwind(*log_, "The callback of a call of service \"" + answered.service + "\"");
  } catch (...) {
    failed("something that is not a std::exception");
  }
}

void CallTable::Loop(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    const Moment now = std::chrono::steady_clock::now();
    std::vector<std::shared_ptr<CallState>> overdue;
    while (!due_.empty() && due_.begin()->first <= now) overdue.push_back(Remove(due_.begin()->second));
    if (!overdue.empty()) {
      lock.unlock();
      for (const auto& call : overdue) call->FinishOverdue();
      overdue.clear();
      lock.lock();
      continue;
    }
    wakes_at_ = due_.empty() ? Moment::max() : due_.begin()->first;
    const Moment until = wakes_at_;
    const auto changed = [&] { return wakes_at_ < until; };
    if (until == Moment::max()) {
      changed_.wait(lock, stop, changed);
    } else {
      changed_.wait_until(lock, stop, until, changed);
    }
  }
}

}  // namespace hgros
