#include "discovery/wake_event.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <string>

#include "hgros/base/error.hpp"

namespace hgros::discovery {

WakeEvent::WakeEvent() : event_([] { return eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC); }) {
  if (event_) return;
  throw Error(std::string("Cannot create an eventfd: ") + std::strerror(errno) + ".", {},
              "Raise the limit of open files (ulimit -n).");
}

void WakeEvent::Signal() noexcept {
  const std::uint64_t one = 1;
  // Fails only when the counter is full, and then the descriptor is readable anyway.
  [[maybe_unused]] const auto written = write(event_.get(), &one, sizeof one);
}

void WakeEvent::Wait(int fd, std::optional<std::chrono::steady_clock::time_point> deadline) noexcept {
  pollfd waiting[2] = {{event_.get(), POLLIN, 0}, {fd, POLLIN, 0}};
  timespec left{};
  if (deadline) {
    const auto nanoseconds =
        std::chrono::nanoseconds(std::max(*deadline - std::chrono::steady_clock::now(), {})).count();
    left.tv_sec = static_cast<time_t>(nanoseconds / 1'000'000'000);
    left.tv_nsec = static_cast<long>(nanoseconds % 1'000'000'000);
  }
  if (ppoll(waiting, 2, deadline ? &left : nullptr, nullptr) <= 0) return;
  if (waiting[0].revents != 0) {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto taken = read(event_.get(), &count, sizeof count);
  }
}

}  // namespace hgros::discovery
