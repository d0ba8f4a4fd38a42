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
#include "waits.hpp"

namespace hgros::python {
namespace {

using Clock = std::chrono::steady_clock;

// Of the main thread: how often Prepare() was called, and what was set before.
int prepared = 0;
int before_prepared = -1;

// Into this pipe Python's handler of signals writes, whichever thread it runs on, while the main thread waits.
class SignalPipe {
 public:
  // One for each process: a forked child would read what is meant for its parent.
  static SignalPipe& OfProcess() {
    static SignalPipe pipe;
    if (pipe.pid_ != getpid()) {
      prepared = 0;  // For the pipe of the parent.
      pipe.Open();
    }
    return pipe;
  }

  [[nodiscard]] int reading() const noexcept { return ends_[0]; }
  [[nodiscard]] int writing() const noexcept { return ends_[1]; }
  // Empties it. Another waiter of Python, such as an event loop, gets the signals too.
  void PassTo(int other) const noexcept {
    std::array<char, 64> signals{};
    for (ssize_t count = 0; (count = read(reading(), signals.data(), signals.size())) > 0;) {
      if (other >= 0) [[maybe_unused]]
        const auto passed = write(other, signals.data(), static_cast<std::size_t>(count));
    }
  }

 private:
  SignalPipe() { Open(); }
  void Open() {
    for (const int end : ends_) {
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

// Returns the descriptor that was set before; -1: none.
int SetWakeupDescriptor(int descriptor) {
  static const pybind11::object& set =  // Never released: Python may be gone by then.
      *new pybind11::object(pybind11::module_::import("signal").attr("set_wakeup_fd"));
  return set(descriptor, pybind11::arg("warn_on_full_buffer") = false).cast<int>();
}

// While it lives, signals of Python end a wait for `descriptor()`. Only the main thread handles signals; for another
// one it does nothing. Made and destroyed with the GIL.
class SignalWaker {
 public:
  SignalWaker() {
    if (gettid() != getpid()) return;
    pipe_ = &SignalPipe::OfProcess();
    if (prepared > 0) return;
    set_ = true;
    before_ = SetWakeupDescriptor(pipe_->writing());
  }
  SignalWaker(const SignalWaker&) = delete;
  SignalWaker& operator=(const SignalWaker&) = delete;
  ~SignalWaker() {
    if (!set_) {
      if (pipe_ != nullptr) pipe_->PassTo(before_prepared);
      return;
    }
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

ReadyList::ReadyList() : descriptor_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (descriptor_ < 0) {
    throw Error(std::string("No event descriptor can be opened: ") + std::strerror(errno) + ".", {},
                "Close files that are not needed, or raise the limit with `ulimit -n`.");
  }
}

ReadyList::~ReadyList() { close(descriptor_); }

void ReadyList::Add(int key) {
  if (of_parent()) return;
  const std::scoped_lock lock(mutex_);
  keys_.push_back(key);
  RingLocked();
}

void ReadyList::Wake() {
  if (of_parent()) return;
  const std::scoped_lock lock(mutex_);
  RingLocked();
}

std::vector<int> ReadyList::Take() {
  bool rung = false;
  return TakeIfRung(rung);
}

std::vector<int> ReadyList::TakeIfRung(bool& rung) {
  RefuseInChild();
  const std::scoped_lock lock(mutex_);
  rung = std::exchange(rung_, false);
  if (rung) {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto read_bytes = read(descriptor_, &count, sizeof count);
  }
  return std::exchange(keys_, {});
}

void ReadyList::RingLocked() noexcept {
  if (rung_) return;
  rung_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = write(descriptor_, &one, sizeof one);
}

void ReadyList::Prepare() {
  if (gettid() == getpid() && prepared++ == 0) {
    before_prepared = SetWakeupDescriptor(SignalPipe::OfProcess().writing());
  }
}

void ReadyList::Relax() {
  if (gettid() == getpid() && prepared > 0 && --prepared == 0) SetWakeupDescriptor(before_prepared);
}

std::vector<int> ReadyList::Wait(double timeout_s) {
  bool rung = false;
  std::vector<int> keys = TakeIfRung(rung);
  if (rung) return keys;  // Perhaps without a key: what Wake() tells may have come after the caller's last look.
  const bool forever = timeout_s < 0 || timeout_s > kLongestWaitS || std::isnan(timeout_s);
  const auto deadline = forever ? Clock::time_point::max() : Clock::now() + Nanoseconds(timeout_s);
  while (true) {
    std::array<pollfd, 2> waited{};
    int found = 0;
    {
      const SignalWaker signals;
      // From here on each signal is in the pipe.
      if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
      waited = {pollfd{descriptor_, POLLIN, 0}, pollfd{signals.descriptor(), POLLIN, 0}};
      const pybind11::gil_scoped_release released;
      const timespec left = forever ? timespec{} : TimeLeft(deadline);
      found = ppoll(waited.data(), waited.size(), forever ? nullptr : &left, nullptr);
    }
    if (found == 0) return {};
    if (found > 0 && waited[0].revents != 0) return Take();
  }
}

}  // namespace hgros::python
