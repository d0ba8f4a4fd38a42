#include "terminal/pause.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>

#include "hgros/base/error.hpp"

namespace hgros::cli {

Pause::Pause() {
  sigset_t ending;
  sigemptyset(&ending);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&ending, signal);
  pthread_sigmask(SIG_BLOCK, &ending, &before_);
  signals_ = signalfd(-1, &ending, SFD_CLOEXEC | SFD_NONBLOCK);
  wakes_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (signals_ < 0 || wakes_ < 0) {
    throw Error("The command cannot wait for signals: " + std::string(std::strerror(errno)) + ".");
  }
}

Pause::~Pause() {
  close(signals_);
  close(wakes_);
}

void Pause::Wake() noexcept {
  const std::uint64_t one = 1;
  (void)!write(wakes_, &one, sizeof one);
}

Pause::End Pause::Until(std::chrono::steady_clock::time_point deadline) { return UntilReadable(-1, deadline); }

// poll() ignores a negative descriptor.
Pause::End Pause::UntilReadable(int descriptor, std::chrono::steady_clock::time_point deadline) {
  using std::chrono::nanoseconds;
  std::array<pollfd, 3> watched{pollfd{signals_, POLLIN, 0}, pollfd{wakes_, POLLIN, 0}, pollfd{descriptor, POLLIN, 0}};
  while (signal_ == 0) {
    const auto left =
        std::max(deadline - std::chrono::steady_clock::now(), std::chrono::steady_clock::duration::zero());
    const auto seconds = std::min(std::chrono::duration_cast<std::chrono::seconds>(left), std::chrono::seconds(3600));
    timespec time{seconds.count(), seconds.count() == 3600 ? 0 : nanoseconds(left - seconds).count()};
    if (ppoll(watched.data(), watched.size(), &time, nullptr) < 0 && errno != EINTR) return End::kDeadline;
    signalfd_siginfo caught{};
    if (read(signals_, &caught, sizeof caught) == sizeof caught) {
      signal_ = static_cast<int>(caught.ssi_signo);
      break;
    }
    std::uint64_t wakes = 0;
    if (read(wakes_, &wakes, sizeof wakes) == sizeof wakes || watched[2].revents != 0) return End::kWoken;
    if (std::chrono::steady_clock::now() >= deadline) return End::kDeadline;
  }
  return End::kInterrupted;
}

void Pause::EndBySignal() const {
  if (signal_ == 0) return;
  (void)std::signal(signal_, SIG_DFL);
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  (void)raise(signal_);
}

}  // namespace hgros::cli
