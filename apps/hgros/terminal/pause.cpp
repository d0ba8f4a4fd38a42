#include "terminal/pause.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "hgros/base/error.hpp"
#include "terminal/console.hpp"

namespace hgros::cli {

namespace {

constexpr std::int64_t kOneEndNs = 100'000'000;

// What the handler needs; it may do little.
std::atomic<int> caught{0};
std::atomic<std::int64_t> caught_at_ns{0};
std::atomic<int> told{-1};
std::atomic<bool> outlasts{false};
std::atomic<bool> caught_again{false};

std::int64_t NowNs() {
  timespec now{};
  (void)clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
}

extern "C" void OnEndingSignal(int number) {
  const int error = errno;
  if (caught == 0) {
    caught_at_ns = NowNs();
    caught = number;
  } else if (NowNs() - caught_at_ns < kOneEndNs) {
    return;  // A program such as `timeout` sends it to the process and to its group.
  } else if (!outlasts || caught_again.exchange(true)) {
    (void)std::signal(number, SIG_DFL);
    (void)raise(number);
  }
  const std::uint64_t one = 1;
  (void)!write(told, &one, sizeof one);
  errno = error;
}

}  // namespace

Pause::Pause() : ended_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)), wakes_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (ended_ < 0 || wakes_ < 0) throw Error("The command cannot wait: " + std::string(std::strerror(errno)) + ".");
  told = ended_;
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    struct sigaction ours {};
    ours.sa_handler = OnEndingSignal;
    if (sigaction(number, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) sigaction(number, &ours, nullptr);
  }
}

Pause::~Pause() {
  told = -1;
  outlasts = false;
  close(ended_);
  close(wakes_);
}

int Pause::signal() const noexcept { return caught; }
void Pause::OutlastTheSecond() noexcept { outlasts = true; }
bool Pause::signaled_again() const noexcept { return caught_again; }

void Pause::Wake() noexcept {
  const std::uint64_t one = 1;
  (void)!write(wakes_, &one, sizeof one);
}

Pause::End Pause::Until(std::chrono::steady_clock::time_point deadline) { return UntilReadable(-1, deadline); }

bool Pause::SleepUntil(std::chrono::steady_clock::time_point time) {
  End end = End::kWoken;
  while (end == End::kWoken) end = Until(time);
  return end == End::kDeadline;
}

void Pause::EachSecond(std::function<void(std::chrono::seconds)> tell) {
  tell_ = std::move(tell);
  told_ = std::chrono::seconds(0);
  begin_ = std::chrono::steady_clock::now();
}

std::chrono::steady_clock::time_point Pause::Tell() {
  if (!tell_) return std::chrono::steady_clock::time_point::max();
  const auto passed = std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - begin_);
  if (passed > told_) tell_(told_ = passed);
  return begin_ + told_ + std::chrono::seconds(1);
}

// poll() ignores a negative descriptor. Of standard output it only reports that its reader has gone.
Pause::End Pause::UntilReadable(int descriptor, std::chrono::steady_clock::time_point deadline) {
  using std::chrono::nanoseconds;
  std::array<pollfd, 4> watched{pollfd{ended_, POLLIN, 0}, pollfd{wakes_, POLLIN, 0}, pollfd{descriptor, POLLIN, 0},
                                pollfd{STDOUT_FILENO, 0, 0}};
  while (signal() == 0) {
    const auto left = std::max(std::min(deadline, Tell()) - std::chrono::steady_clock::now(),
                               std::chrono::steady_clock::duration::zero());
    const auto seconds = std::min(std::chrono::duration_cast<std::chrono::seconds>(left), std::chrono::seconds(3600));
    const timespec time{seconds.count(), seconds.count() == 3600 ? 0 : nanoseconds(left - seconds).count()};
    const int ready = ppoll(watched.data(), watched.size(), &time, nullptr);
    if (ready < 0 && errno != EINTR) return End::kDeadline;
    if (signal() != 0) break;
    if (ready > 0 && (watched[3].revents & (POLLERR | POLLHUP)) != 0) throw OutputClosed();
    std::uint64_t wakes = 0;
    const bool woken = read(wakes_, &wakes, sizeof wakes) == sizeof wakes || (ready > 0 && watched[2].revents != 0);
    if (std::chrono::steady_clock::now() >= deadline) return End::kDeadline;
    if (woken) return End::kWoken;
  }
  return End::kInterrupted;
}

void Pause::EndBySignal() const {
  if (signal() == 0) return;
  (void)std::signal(signal(), SIG_DFL);
  (void)raise(signal());
}

}  // namespace hgros::cli
