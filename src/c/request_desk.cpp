#include "c/request_desk.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "c/raw.hpp"
#include "c/readable.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/services/handled_request.hpp"

namespace hgros::c {
namespace {

constexpr const char* kEnded = "The service has ended.";

int NewEvent() {
  const int event = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (event >= 0) return event;
  throw Error("The system has no descriptor for the service: " + std::generic_category().message(errno) + ".", {},
              "Raise the limit of open files (ulimit -n).");
}

}  // namespace

Payload PayloadOf(Answer answer) {
  if (answer.failure) throw std::runtime_error(*answer.failure);
  if (!answer.data) throw std::runtime_error("The handler has set no reply.");
  return *std::move(answer.data);
}

RequestDesk::RequestDesk(std::shared_ptr<Life> life) : life_(std::move(life)), event_(NewEvent()) {}

RequestDesk::~RequestDesk() { close(event_); }

Payload RequestDesk::Handle(const RawMessage& request) {
  auto waits = std::make_shared<const RawMessage>(request);
  std::unique_lock lock(mutex_);
  if (!ended_) {
    ++number_;
    request_ = std::move(waits);
    answer_.reset();
    due_ = HandledRequest::DueHere().value_or(std::chrono::steady_clock::time_point::max());
    SetReadable(true);
    answered_.wait_until(lock, due_, [this] { return ended_ || answer_; });
    if (std::exchange(request_, nullptr)) {  // Nobody has taken it in time.
      SetReadable(false);
    } else {
      answered_.wait(lock, [this] { return ended_ || answer_; });
    }
  }
  if (!answer_) throw NotHandled();
  Answer answer = *std::exchange(answer_, std::nullopt);
  lock.unlock();
  return PayloadOf(std::move(answer));
}

hgros_status RequestDesk::Take(std::int64_t timeout_ns, hgros_message*& request, hgros_reply*& reply) {
  const auto deadline = DeadlineIn(Timeout(timeout_ns));
  auto place = std::make_unique<hgros_reply>();
  for (;;) {
    if (life_->closed()) return Fail(HGROS_CLOSED, life_->why_closed());
    {
      const std::scoped_lock lock(mutex_);
      if (ended_) return Fail(HGROS_CLOSED, kEnded);
      if (request_ && due_ <= std::chrono::steady_clock::now()) {
        SetReadable(false);  // The caller has reported the timeout. The thread of the service drops the request.
      } else if (request_) {
        auto lease = NewLease(request_);  // May fail for want of memory: the request then still waits.
        request_.reset();
        SetReadable(false);
        place->desk = shared_from_this();
        place->number = number_;
        request = lease.release();
        reply = place.release();
        return HGROS_OK;
      }
    }
    if (timeout_ns == 0 || !AwaitReadable(event_, deadline)) return Fail(HGROS_TIMED_OUT, "No request waits.");
  }
}

bool RequestDesk::Reply(std::uint64_t number, Answer answer) {
  {
    const std::scoped_lock lock(mutex_);
    if (ended_ || number != number_) return false;
    answer_ = std::move(answer);
  }
  answered_.notify_all();
  return true;
}

void RequestDesk::Stop() noexcept {
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
    request_.reset();
    SetReadable(true);
  }
  answered_.notify_all();
}

void RequestDesk::SetReadable(bool readable) noexcept {
  if (readable == readable_) return;
  readable_ = readable;
  eventfd_t count = 0;
  (void)(readable ? eventfd_write(event_, 1) : eventfd_read(event_, &count));
}

}  // namespace hgros::c
