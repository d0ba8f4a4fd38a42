#include "ready_list.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pybind11/pybind11.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/session/session.hpp"
#include "session_handle.hpp"
#include "waits.hpp"

namespace hgros::python {
namespace {

using Clock = std::chrono::steady_clock;

// A signal that comes just before the main thread begins to receive does not end that. Python handles it this late.
constexpr auto kLateSignal = std::chrono::milliseconds(500);

// Of the main thread: how often Prepare() was called, and what was set before.
int prepared = 0;
int before_prepared = -1;

// Returns the descriptor that was set before; -1: none.
int SetWakeupDescriptor(int descriptor) {
  static const pybind11::object& set =  // Never released: Python may be gone by then.
      *new pybind11::object(pybind11::module_::import("signal").attr("set_wakeup_fd"));
  return set(descriptor, pybind11::arg("warn_on_full_buffer") = false).cast<int>();
}

// Into this pipe Python's handler of signals writes, whichever thread it runs on, while the main thread waits.
class SignalPipe {
 public:
  // One for each process: a forked child would read what is meant for its parent. With the GIL.
  static SignalPipe& OfProcess() {
    static SignalPipe pipe;
    if (pipe.pid_ != getpid()) pipe.OpenAnew();
    return pipe;
  }

  [[nodiscard]] int reading() const noexcept { return ends_[0]; }
  [[nodiscard]] int writing() const noexcept { return ends_[1]; }
  // Empties it. Another waiter of Python, such as an event loop, gets the signals too.
  void PassTo(int other) const noexcept {
    std::array<char, 64> signals{};
    for (ssize_t count = 0; (count = read(reading(), signals.data(), signals.size())) > 0;) {
      if (other >= 0 && other != writing()) [[maybe_unused]]
        const auto passed = write(other, signals.data(), static_cast<std::size_t>(count));
    }
  }

 private:
  SignalPipe() { Open(); }
  // In a forked child, where Python's handler still writes into the parent's pipe, if that waited.
  void OpenAnew() {
    prepared = 0;
    if (const int before = SetWakeupDescriptor(-1); before >= 0 && before != writing()) SetWakeupDescriptor(before);
    Open();
  }
  void Open() {
    for (const int end : std::exchange(ends_, {-1, -1})) {
      if (end >= 0) close(end);
    }
    if (pipe2(ends_.data(), O_CLOEXEC | O_NONBLOCK) != 0) {
      throw Error(std::string("No pipe can be opened: ") + std::strerror(errno) + ".", {},
                  "Close files that are not needed, or raise the limit with `ulimit -n`.");
    }
    pid_ = getpid();
  }

  std::array<int, 2> ends_{-1, -1};
  pid_t pid_ = 0;
};

// While it lives, signals of Python end a wait for `descriptor()`. Only the main thread handles signals; for another
// one it does nothing. Made and destroyed with the GIL.
class SignalWaker {
 public:
  SignalWaker() {
    if (gettid() != getpid()) return;
    pipe_ = &SignalPipe::OfProcess();
    if (prepared > 0) {
      pipe_->PassTo(before_prepared);  // Not after a wait, where a message may have come.
      return;
    }
    set_ = true;
    before_ = SetWakeupDescriptor(pipe_->writing());
  }
  SignalWaker(const SignalWaker&) = delete;
  SignalWaker& operator=(const SignalWaker&) = delete;
  ~SignalWaker() {
    if (!set_) return;
    try {
      SetWakeupDescriptor(before_);
    } catch (pybind11::error_already_set& fault) {
      fault.discard_as_unraisable("hgros");  // The descriptor that was set before was closed meanwhile.
    }
    pipe_->PassTo(before_);
  }

  [[nodiscard]] int descriptor() const noexcept { return pipe_ != nullptr ? pipe_->reading() : -1; }

 private:
  const SignalPipe* pipe_ = nullptr;
  bool set_ = false;
  int before_ = -1;
};

timespec TimeLeft(Clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(deadline - Clock::now());
  if (left.count() <= 0) return {};
  return {left.count() / 1'000'000'000, left.count() % 1'000'000'000};
}

}  // namespace

ReadyList::ReadyList(const std::shared_ptr<SessionHandle>& session) : session_(session) {}

ReadyList::~ReadyList() {
  if (descriptor_ >= 0) close(descriptor_);
}

int ReadyList::HandOutDescriptor() {
  RefuseInChild();
  const std::scoped_lock lock(mutex_);
  const int descriptor = DescriptorLocked();
  handed_out_ = true;
  return descriptor;
}

int ReadyList::DescriptorLocked() {
  if (descriptor_ >= 0) return descriptor_;
  descriptor_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (descriptor_ < 0) {
    throw Error(std::string("No event descriptor can be opened: ") + std::strerror(errno) + ".", {},
                "Close files that are not needed, or raise the limit with `ulimit -n`.");
  }
  if (rung_) WriteLocked();
  return descriptor_;
}

void ReadyList::Add(int key) {
  if (of_parent()) return;
  const std::scoped_lock lock(mutex_);
  keys_.push_back(key);
  RingLocked();
}

void ReadyList::Wake() {
  if (of_parent()) return;
  const std::scoped_lock lock(mutex_);
  woken_ = true;
  RingLocked();
}

void ReadyList::End() {
  if (of_parent()) return;
  const std::scoped_lock lock(mutex_);
  ended_ = true;
  woken_ = true;
  RingLocked();
  if (!written_) WriteLocked();  // Stays readable, for all.
}

std::vector<int> ReadyList::Take() {
  RefuseInChild();
  const std::scoped_lock lock(mutex_);
  return TakeLocked().keys;
}

ReadyList::Rung ReadyList::TakeLocked() noexcept {
  if (ended_) return {std::exchange(keys_, {}), true};
  if (std::exchange(written_, false)) {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto read_bytes = read(descriptor_, &count, sizeof count);
  }
  rung_ = false;
  return {std::exchange(keys_, {}), woken_.exchange(false)};
}

void ReadyList::RingLocked() noexcept {
  if (std::exchange(rung_, true)) return;
  if (receiving_ == nullptr || polling_ > 0 || handed_out_) WriteLocked();
  if (receiving_ != nullptr && receiver_ != std::this_thread::get_id()) receiving_->WakeReceiver();
}

void ReadyList::WriteLocked() noexcept {
  if (descriptor_ < 0) return;
  written_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto bytes = write(descriptor_, &one, sizeof one);
}

void ReadyList::Prepare() {
  if (gettid() != getpid()) return;
  // In a forked child, this forgets what the parent has prepared.
  const int writing = SignalPipe::OfProcess().writing();
  if (prepared++ == 0) before_prepared = SetWakeupDescriptor(writing);
}

void ReadyList::Relax() {
  if (gettid() != getpid() || prepared == 0 || --prepared > 0) return;
  SetWakeupDescriptor(before_prepared);
  SignalPipe::OfProcess().PassTo(before_prepared);
}

bool ReadyList::ReceiveUntil(Deadline deadline, std::optional<Rung>& rung) {
  const auto handle = session_.lock();
  if (!handle) return false;
  const SessionHandle::Receiving here(*handle);
  Session* const session = here.session();
  if (session == nullptr) return false;
  {
    const std::scoped_lock lock(mutex_);
    if (receiving_ != nullptr) return false;
    receiving_ = session;
    receiver_ = std::this_thread::get_id();
  }
  const auto ends = [this, &here] {
    const std::scoped_lock lock(mutex_);
    return rung_ || here.closing();
  };
  const bool received = session->ReceiveHere(ends, deadline);
  const std::scoped_lock lock(mutex_);
  receiving_ = nullptr;
  if (rung_) rung = TakeLocked();
  return received || rung;
}

bool ReadyList::Poll(int signals, Deadline deadline, std::optional<Rung>& rung) {
  std::array waited{pollfd{-1, POLLIN, 0}, pollfd{signals, POLLIN, 0}};
  {
    const std::scoped_lock lock(mutex_);
    if (rung_) {
      rung = TakeLocked();
      return true;
    }
    waited[0].fd = DescriptorLocked();
    ++polling_;
  }
  const timespec left = TimeLeft(deadline);
  const bool forever = deadline == Deadline::max();
  const bool in_time = ppoll(waited.data(), waited.size(), forever ? nullptr : &left, nullptr) != 0;
  const std::scoped_lock lock(mutex_);
  --polling_;
  if (rung_) rung = TakeLocked();
  return in_time;
}

ReadyList::Deadline ReadyList::DeadlineIn(double timeout_s) {
  const bool forever = timeout_s < 0 || timeout_s > kLongestWaitS || std::isnan(timeout_s);
  return forever ? Deadline::max() : Clock::now() + Nanoseconds(timeout_s);
}

std::vector<int> ReadyList::Wait(double timeout_s) {
  std::vector<int> keys;
  (void)WaitUntil(DeadlineIn(timeout_s), keys);
  return keys;
}

bool ReadyList::WaitUntil(Deadline deadline, std::vector<int>& keys) {
  RefuseInChild();
  if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  std::optional<Rung> rung;
  {
    const std::scoped_lock lock(mutex_);
    if (rung_) rung = TakeLocked();
  }
  bool in_time = true;
  while (!rung && in_time) {
    const SignalWaker signals;
    // From here on each signal is in the pipe.
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
    const GilRelease released;
    const bool has_signals = signals.descriptor() >= 0;
    if (ReceiveUntil(has_signals ? std::min(deadline, Clock::now() + kLateSignal) : deadline, rung)) {
      in_time = Clock::now() < deadline;
    } else {
      in_time = Poll(signals.descriptor(), deadline, rung);
    }
  }
  if (rung) keys = std::move(rung->keys);
  return in_time && !(rung && rung->woken);
}

}  // namespace hgros::python
