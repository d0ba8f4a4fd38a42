// How a starter ends its units.
#include <signal.h>

#include <algorithm>

#include "launch/starter.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::milliseconds kTurnsPatience{500};  // Then all that is left ends together.

}  // namespace

void Starter::KillLate() {
  for (Unit& unit : units_) {
    if (unit.kill_at > Clock::now()) continue;
    unit.kill_at = Clock::time_point::max();
    if (unit.running == nullptr || unit.over_at != Clock::time_point::max()) continue;
    if (unit.HangsAlone()) {
      Say(unit, LogLevel::kWarning, "A component was not constructed again in time, so it ends and starts again.");
      unit.EndHanging(kill_at_);
      continue;
    }
    if (unit.AskLate()) continue;
    Say(unit, LogLevel::kWarning, "It did not end in time, and is killed.");
    unit.running->Signal(SIGKILL);
  }
}

void Starter::EndAll(const std::string& why, int code) {
  code_ = std::max(code_, code);
  if (ending_) return;
  ending_ = true;
  kill_at_ = Clock::now() + kEndPatience;
  together_at_ = Clock::now() + kTurnsPatience;
  if (!why.empty()) surroundings_.console.Say(why);
}

void Starter::EndNext() {
  const bool late = Clock::now() >= kill_at_;
  if (late || Clock::now() >= together_at_) together_at_ = Clock::time_point::min();
  for (auto unit = units_.rbegin(); unit != units_.rend(); ++unit) {
    if (unit->running == nullptr) continue;
    if (late) {
      unit->running->Signal(SIGKILL);
    } else if (unit->stage != Stage::kEnds) {
      unit->again = false;
      unit->TellToEnd(kill_at_);
    }
    unit->stage = Stage::kEnds;
    if (together_at_ > Clock::time_point::min()) return;  // The next one ends after this.
  }
  if (late) kill_at_ = Clock::time_point::max();
}

void Starter::EndEmpty() {
  const auto is_empty = [](const Unit& unit) { return unit.process != nullptr && unit.process->components.empty(); };
  const bool others =
      std::ranges::any_of(units_, [&](const Unit& unit) { return unit.stage != Stage::kEnded && !is_empty(unit); });
  if (!others && released_ && !AllEnded()) EndAll({}, code_);
}

bool Starter::AllEnded() const {
  return std::ranges::all_of(units_, [this](const Unit& unit) {
    if (unit.running != nullptr) return false;
    return unit.stage == Stage::kEnded || ending_;
  });
}

}  // namespace hgros::cli
