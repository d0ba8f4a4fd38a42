#include "hgros/clock/clock.hpp"

namespace hgros {
namespace {

// `due` computes the end of the sleep from a reading.
template <class Due>
bool Sleep(Clock& clock, const std::stop_token& stop, const Due& due) {
  Sleeper sleeper;
  const std::stop_callback wake(stop, [&sleeper] { sleeper.Wake(); });
  for (;;) {
    const ClockReading reading = clock.Read();
    const Time end = due(reading);
    if (reading.now >= end) return true;
    if (stop.stop_requested()) return false;
    clock.Wait(sleeper, reading, end);
  }
}

}  // namespace

bool SleepUntil(Clock& clock, Time due, const std::stop_token& stop) {
  return Sleep(clock, stop, [due](const ClockReading&) { return due; });
}

bool SleepFor(Clock& clock, Duration time, const std::stop_token& stop) {
  const Time end = Later(clock.Read().elapsed(), time);
  return Sleep(clock, stop, [end](const ClockReading& reading) { return Later(end, reading.jumped); });
}

}  // namespace hgros
