#include "clock/wall_jump_watch.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/system_limits.hpp"

namespace hgros {
namespace {

// Sets the timer to the year 2262. It never expires; the kernel cancels it when the wall clock is set.
void Arm(int timer) {
  itimerspec when{};
  when.it_value.tv_sec = std::numeric_limits<std::int64_t>::max() / 1'000'000'000;
  timerfd_settime(timer, TFD_TIMER_ABSTIME | TFD_TIMER_CANCEL_ON_SET, &when, nullptr);
}

OwnDescriptor Required(OwnDescriptor descriptor) {
  if (descriptor) return descriptor;
  throw Error(std::string("The wall clock cannot be watched: ") + std::strerror(errno) + ".", {},
              "Raise the limit of open files (ulimit -n).");
}

}  // namespace

OwnDescriptor MakeWallTimer() {
  OwnDescriptor timer =
      Required(OwnDescriptor([] { return timerfd_create(CLOCK_REALTIME, TFD_NONBLOCK | TFD_CLOEXEC); }));
  Arm(timer.get());
  return timer;
}

WallJumpWatch::WallJumpWatch(OwnDescriptor timer, std::function<void()> on_set)
    : timer_(std::move(timer)),
      end_(Required(OwnDescriptor([] { return eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC); }))),
      on_set_(std::move(on_set)),
      thread_(StartThread<std::jthread>("the thread that watches the wall clock", [this] { Loop(); })) {}

WallJumpWatch::~WallJumpWatch() {
  const std::uint64_t one = 1;
  (void)!write(end_.get(), &one, sizeof one);
  thread_.join();
}

void WallJumpWatch::Loop() {
  std::array<pollfd, 2> descriptors{pollfd{timer_.get(), POLLIN, 0}, pollfd{end_.get(), POLLIN, 0}};
  for (;;) {
    if (poll(descriptors.data(), descriptors.size(), -1) < 0) {
      if (errno == EINTR) continue;
      return;
    }
    if (descriptors[1].revents != 0) return;
    std::uint64_t expired = 0;
    (void)!read(timer_.get(), &expired, sizeof expired);  // ECANCELED: the clock was set.
    Arm(timer_.get());
    on_set_();
  }
}

}  // namespace hgros
