// How a starter ends its units.
#include <signal.h>

#include <algorithm>
#include <utility>

#include "launch/starter.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::milliseconds kEndPatience{1600};  // Then what has not ended is killed.
constexpr std::chrono::seconds kRelayPatience{1};        // More, because its host kills what runs there, and tells.

}  // namespace

void Starter::TellToEnd(Unit& unit) {
  const auto patience = unit.remote ? kEndPatience + kRelayPatience : kEndPatience;
  unit.kill_at = std::min(kill_at_, Clock::now() + patience);
  if (unit.program != nullptr) return unit.running->Signal(SIGTERM);
  RunOrder order;
  order.mutable_end()->set_save(unit.again);
  unit.Send(order);
}

void Starter::KillLate() {
  for (Unit& unit : units_) {
    if (unit.kill_at > Clock::now()) continue;
    unit.kill_at = Clock::time_point::max();
    if (unit.running == nullptr || unit.over_at != Clock::time_point::max()) continue;
    unit.again = unit.again || !std::exchange(unit.alone, {}).empty();
    Say(unit, LogLevel::kWarning, "It did not end in time, and is killed.");
    unit.running->Signal(SIGKILL);
  }
}

void Starter::EndAll(const std::string& why, int code) {
  code_ = std::max(code_, code);
  if (ending_) return;
  ending_ = true;
  kill_at_ = Clock::now() + kEndPatience;
  if (!why.empty()) surroundings_.console.Say(why);
}

void Starter::EndNext() {
  const bool late = Clock::now() >= kill_at_;
  for (auto unit = units_.rbegin(); unit != units_.rend(); ++unit) {
    if (unit->running == nullptr) continue;
    if (late) {
      unit->running->Signal(SIGKILL);
    } else if (unit->stage == Stage::kEnds) {
      return;  // The next one ends after this.
    } else {
      TellToEnd(*unit);
    }
    unit->stage = Stage::kEnds;
    if (!late) return;
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
