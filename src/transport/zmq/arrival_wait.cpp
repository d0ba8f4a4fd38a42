#include "transport/zmq/arrival_wait.hpp"

#include <algorithm>
#include <utility>

namespace hgros::zmq {
namespace {

// The kernel and ZeroMQ do not say when they have sent something.
constexpr auto kLookEvery = std::chrono::milliseconds(10);

}  // namespace

void ArrivalWait::Await(std::chrono::milliseconds linger, std::chrono::milliseconds at_most,
                        const std::function<Arriving()>& look) {
  using Clock = std::chrono::steady_clock;
  auto before = Clock::now();
  const auto last = before + std::max(linger, at_most);
  Clock::duration quiet{};
  std::uint64_t progress = 0;
  std::unique_lock lock(mutex_);
  for (;;) {
    const auto seen = rounds_;
    const Arriving arriving = look();
    const auto now = Clock::now();
    if (!arriving.any || now >= last) return;
    // While this process stands still, nobody else is silent.
    quiet += std::min<Clock::duration>(now - before, 2 * kLookEvery);
    if (std::exchange(progress, arriving.progress) != arriving.progress) quiet = {};
    if (quiet >= linger) return;
    before = now;
    read_.wait_until(lock, std::min(last, now + kLookEvery), [&] { return rounds_ != seen; });
  }
}

void ArrivalWait::NoteRound() {
  const std::scoped_lock lock(mutex_);
  ++rounds_;
  read_.notify_all();
}

}  // namespace hgros::zmq
