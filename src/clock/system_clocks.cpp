#include "hgros/clock/system_clocks.hpp"

#include <memory>
#include <mutex>
#include <utility>

#include "clock/wall_jump_watch.hpp"
#include "clock/wall_offset.hpp"
#include "hgros/clock/waiting_room.hpp"

namespace hgros {
namespace {

struct BothClocks {
  Time wall;
  Time steady;
};

// Both clocks at about the same moment: a thread that loses its slice in between tries again.
BothClocks ReadBoth() {
  constexpr std::int64_t kLongest = 100'000;
  BothClocks both;
  for (int attempt = 0; attempt < 16; ++attempt) {
    both.steady = {MonotonicNow()};
    both.wall = WallNow();
    if (MonotonicNow() - both.steady.nanoseconds < kLongest) break;
  }
  return both;
}

}  // namespace

struct SystemClock::State {
  State() : State(ReadBoth()) {}
  explicit State(const BothClocks& both) : offset(both.wall, both.steady) {}

  ClockReading Read() {
    const std::scoped_lock lock(mutex);
    const BothClocks both = ReadBoth();
    return offset.Take(both.wall, both.steady);
  }

  void Watch() {
    const std::scoped_lock lock(watch_mutex);
    if (watch != nullptr) return;
    OwnDescriptor timer = MakeWallTimer();
    told = Read().jumped;  // What came before nobody has asked for.
    watch = std::make_unique<WallJumpWatch>(std::move(timer), [this] { TellJump(); });
  }

  // On the watch's thread.
  void TellJump() {
    const ClockReading reading = Read();
    const Duration jump = reading.jumped - std::exchange(told, reading.jumped);
    if (jump != Duration::zero()) listeners.Tell({reading.now - jump, reading.now});
    waiting.WakeAll();
  }

  std::mutex mutex;
  WallOffset offset;  // guarded by mutex
  Duration told{0};   // the watch's thread alone, once there is one
  Listeners<ClockJump> listeners;
  WaitingRoom waiting;
  std::mutex watch_mutex;
  std::unique_ptr<WallJumpWatch> watch;  // guarded by watch_mutex; last, because its thread uses the rest
};

SystemClock::SystemClock() : state_(std::make_unique<State>()) {}
SystemClock::~SystemClock() = default;

ClockReading SystemClock::Read() const { return state_->Read(); }

void SystemClock::Wait(Sleeper& sleeper, const ClockReading& seen, Time due) {
  state_->Watch();
  const WaitingRoom::Seat seat(state_->waiting, sleeper);
  const ClockReading reading = Read();
  if (reading.jumped != seen.jumped || reading.now >= due) return;
  sleeper.WaitUntil(due.ToSystemClock());
}

Listening SystemClock::OnJump(JumpCallback callback) {
  state_->Watch();
  return state_->listeners.Add(std::move(callback));
}

void SteadyClock::Wait(Sleeper& sleeper, const ClockReading& /*seen*/, Time due) {
  sleeper.WaitUntil(std::chrono::steady_clock::time_point(Duration(due.nanoseconds)));
}

Listening SteadyClock::OnJump(JumpCallback /*callback*/) { return {}; }

}  // namespace hgros
