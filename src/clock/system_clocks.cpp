#include "hgros/clock/system_clocks.hpp"

#include <algorithm>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "clock/wall_jump_watch.hpp"
#include "clock/wall_offset.hpp"
#include "hgros/base/forced_unwind.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/internal/clock/waiting_room.hpp"

namespace hgros {
namespace {

// Period of checks while the wall clock cannot be watched.
constexpr Duration kLookAgain = std::chrono::milliseconds(100);

struct BothClocks {
  Time wall;
  Time steady;
};

// Reads both clocks at about the same moment. Tries again if the thread was interrupted in between.
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
  const ForkGuard fork;  // A child has none of the threads.
  explicit State(LogSink sink) : State(std::move(sink), ReadBoth()) {}
  State(LogSink sink, const BothClocks& both) : log(std::move(sink)), offset(both.wall, both.steady) {}

  ClockReading Read() {
    const std::scoped_lock lock(mutex);
    const BothClocks both = ReadBoth();
    return offset.Correct(both.wall, both.steady);
  }

  void Watch() {
    const std::scoped_lock lock(watch_mutex);
    StartWatch();
  }

  // False if the clock cannot be watched at the moment.
  bool TryWatch() {
    const std::scoped_lock lock(watch_mutex);
    const Time now{MonotonicNow()};
    if (watch == nullptr && now < watch_again) return false;
    try {
      StartWatch();
      if (std::exchange(unwatched, false)) SayOf(LogLevel::kInfo, "The wall clock is watched again.");
      return true;
    } catch (const std::exception& e) {
      watch_again = Later(now, kLookAgain);
      if (std::exchange(unwatched, true)) return false;
      SayOf(LogLevel::kWarning, std::string(e.what()) + " Until then, waiting threads check it ten times per second.");
      return false;
    }
  }

  // Call it under watch_mutex. Throws if descriptors or threads are used up.
  void StartWatch() {
    if (watch != nullptr) return;
    OwnDescriptor timer = MakeWallTimer();
    told = Read().jumped;  // Earlier jumps are not reported: no listener was there.
    watch = std::make_unique<WallJumpWatch>(std::move(timer), [this] { TellJump(); });
  }

  // On the watch's thread.
  void TellJump() {
    const ClockReading reading = Read();
    const Duration jump = reading.jumped - std::exchange(told, reading.jumped);
    try {
      if (jump != Duration::zero()) listeners.Tell({reading.now - jump, reading.now});
    } catch (const std::exception& error) {
      SayOf(LogLevel::kError, std::string("A callback for jumps of the system's clock threw: ") + error.what());
    } catch (const ForcedUnwind&) {
      Log to(log ? log : DefaultLogSink());
      EndAfterForcedUnwind(to, "A callback for jumps of the system's clock");
    } catch (...) {
      SayOf(LogLevel::kError,
            "A callback for jumps of the system's clock threw something that is not a std::exception.");
    }
    waiting.WakeAll();
  }

  void SayOf(LogLevel level, std::string_view text) { Log(log ? log : DefaultLogSink()).Write(level, text); }

  const LogSink log;
  std::mutex mutex;
  WallOffset offset;  // guarded by mutex
  Duration told{0};   // used only by the watch's thread once it runs
  Listeners<ClockJump> listeners;
  WaitingRoom waiting;
  std::mutex watch_mutex;
  bool unwatched = false;                // guarded by watch_mutex, as the next two
  Time watch_again{0};                   // By the steady clock.
  std::unique_ptr<WallJumpWatch> watch;  // last, because its thread uses the rest
};

SystemClock::SystemClock(LogSink log) : state_(std::make_unique<State>(std::move(log))) {}
SystemClock::~SystemClock() {
  if (state_->fork.IsChild()) LeaveToParent(std::shared_ptr<const State>(std::move(state_)));
}

ClockReading SystemClock::Read() const { return state_->Read(); }

void SystemClock::Wait(Sleeper& sleeper, const ClockReading& seen, Time due) {
  const bool watched = state_->TryWatch();
  const WaitingRoom::Seat seat(state_->waiting, sleeper);
  const ClockReading reading = Read();
  if (reading.jumped != seen.jumped || reading.now >= due) return;
  if (watched) return sleeper.WaitUntil(due.ToSystemClock());
  sleeper.WaitUntil(std::chrono::steady_clock::now() + std::min(due - reading.now, kLookAgain));
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
