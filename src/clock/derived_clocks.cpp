#include "hgros/clock/derived_clocks.hpp"

#include <algorithm>
#include <memory>
#include <sstream>
#include <string>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/clock/system_clocks.hpp"

namespace hgros {

DerivedClock::DerivedClock(Time start, std::shared_ptr<Clock> source, bool paused)
    : source_(source != nullptr ? std::move(source) : std::make_shared<SteadyClock>()) {
  line_.source = source_->Read().elapsed();
  line_.shown = start;
  line_.paused = paused;
}

ClockReading DerivedClock::Read() const {
  const std::scoped_lock lock(mutex_);
  return {line_.At(source_->Read().elapsed()), jumped_};
}

ClockLine DerivedClock::line() const {
  const std::scoped_lock lock(mutex_);
  return line_;
}

ClockState DerivedClock::State() const {
  const std::scoped_lock lock(mutex_);
  const Time source_now = source_->Read().elapsed();
  return {{line_.At(source_now), jumped_}, source_now, line_.rate, line_.paused};
}

void DerivedClock::Wait(Sleeper& sleeper, const ClockReading& seen, Time due) {
  const WaitingRoom::Seat seat(waiting_, sleeper);
  ClockReading source_seen;
  Time source_due;
  {
    const std::scoped_lock lock(mutex_);
    if (jumped_ != seen.jumped) return;
    source_seen = source_->Read();
    if (line_.At(source_seen.elapsed()) >= due) return;
    source_due = Later(line_.SourceOf(due), source_seen.jumped);
  }
  source_->Wait(sleeper, source_seen, source_due);
}

Listening DerivedClock::OnJump(JumpCallback callback) { return listeners_.Add(std::move(callback)); }

Listening DerivedClock::OnChange(std::function<void()> callback) {
  return changes_.Add([callback = std::move(callback)](const Changed&) { callback(); });
}

void DerivedClock::ChangePace(const std::function<void(ClockLine&)>& change) {
  {
    const std::scoped_lock lock(mutex_);
    const Time source_now = source_->Read().elapsed();
    line_.shown = line_.At(source_now);
    line_.source = source_now;
    change(line_);
  }
  TellChange(nullptr);
}

void DerivedClock::TellChange(const ClockJump* jump) {
  const auto wake = [](WaitingRoom* waiting) { waiting->WakeAll(); };
  const std::unique_ptr<WaitingRoom, decltype(wake)> wakes(&waiting_, wake);  // Also if a listener throws.
  try {
    if (jump != nullptr) listeners_.Tell(*jump);
  } catch (...) {
    changes_.Tell({});
    throw;
  }
  changes_.Tell({});
}

void DerivedClock::Jump(Time after) {
  ClockJump jump;
  {
    const std::scoped_lock lock(mutex_);
    const Time source_now = source_->Read().elapsed();
    jump = {line_.At(source_now), after};
    line_.source = source_now;
    line_.shown = after;
    jumped_ += jump.after - jump.before;
  }
  TellChange(&jump);
}

void DerivedClock::Replace(ClockLine line, std::optional<Duration> jump) {
  ClockJump told;
  Duration leap{0};
  {
    const std::scoped_lock lock(mutex_);
    const Time source_now = source_->Read().elapsed();
    told.before = line_.At(source_now);
    if (jump == Duration::zero()) line.least = told.before;
    told.after = line.At(source_now);
    const Duration difference = told.after - told.before;
    // If this clock has run ahead, the jump includes the way back, because elapsed time never goes back.
    if (jump != Duration::zero()) leap = std::min(jump.value_or(difference), difference);
    line_ = line;
    jumped_ += leap;
  }
  TellChange(leap != Duration::zero() ? &told : nullptr);
}

void SimulatedClock::SetRate(double rate) {
  if (!(rate > 0.0) || rate > kMostRate) {
    std::ostringstream text;
    text << "A clock cannot run at the rate " << rate << ".";
    throw Error(text.str(), {}, "Give a rate above zero, up to a million; Pause() stops the clock.");
  }
  ChangePace([rate](ClockLine& line) { line.rate = rate; });
}

void SimulatedClock::Pause() {
  ChangePace([](ClockLine& line) { line.paused = true; });
}

void SimulatedClock::Resume() {
  ChangePace([](ClockLine& line) { line.paused = false; });
}

void SimulatedClock::Step(Duration time) {
  if (time < Duration::zero()) {
    throw Error("A clock cannot step back.", {}, "JumpTo() sets it to an earlier time.");
  }
  ChangePace([time](ClockLine& line) { line.shown = Later(line.shown, time); });
}

}  // namespace hgros
