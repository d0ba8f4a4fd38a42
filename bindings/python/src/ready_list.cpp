#include "ready_list.hpp"

#include <poll.h>
#include <pybind11/pybind11.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros::python {
namespace {

using Clock = std::chrono::steady_clock;

// No signal is handled by this thread while it lives, except inside ppoll.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

  [[nodiscard]] const sigset_t& before() const noexcept { return before_; }

 private:
  sigset_t before_{};
};

// More is as good as forever.
constexpr double kLongestWaitS = 1e9;

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
  const std::scoped_lock lock(mutex_);
  keys_.push_back(key);
  RingLocked();
}

void ReadyList::Wake() {
  const std::scoped_lock lock(mutex_);
  RingLocked();
}

std::vector<int> ReadyList::Take() {
  const std::scoped_lock lock(mutex_);
  if (rung_) {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto read_bytes = read(descriptor_, &count, sizeof count);
    rung_ = false;
  }
  return std::exchange(keys_, {});
}

void ReadyList::RingLocked() noexcept {
  if (rung_) return;
  rung_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = write(descriptor_, &one, sizeof one);
}

std::vector<int> ReadyList::Wait(double timeout_s) {
  std::vector<int> keys = Take();
  if (!keys.empty()) return keys;
  const bool forever = timeout_s < 0 || timeout_s > kLongestWaitS || std::isnan(timeout_s);
  const auto deadline =
      forever ? Clock::time_point::max()
              : Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_s));
  while (true) {
    int found = 0;
    {
      // A signal that comes after Python was asked for signals must end the wait: so it stays pending until ppoll.
      const BlockedSignals blocked;
      if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
      const pybind11::gil_scoped_release released;
      pollfd one{descriptor_, POLLIN, 0};
      const timespec left = forever ? timespec{} : TimeLeft(deadline);
      found = ppoll(&one, 1, forever ? nullptr : &left, &blocked.before());
    }
    if (found > 0) return Take();
    if (found == 0) return {};
  }
}

}  // namespace hgros::python
