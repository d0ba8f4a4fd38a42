#include "hgros/c/clock.h"

#include "c/executors.hpp"
#include "c/handles.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/session/clock_publisher.hpp"

struct hgros_timer {
  hgros::NodeTimer timer;
};

namespace hgros::c {

// A clock and who publishes it.
struct PublishedClock {
  PublishedClock(Session& session, std::shared_ptr<SimulatedClock> shown)
      : clock(std::move(shown)), publisher(session, clock) {}
  const std::shared_ptr<SimulatedClock> clock;
  ClockPublisher publisher;
};

}  // namespace hgros::c

struct hgros_simulated_clock {
  std::shared_ptr<hgros::c::Life> life;
  std::shared_ptr<hgros::c::Held<hgros::c::PublishedClock>> held;
};

namespace hgros::c {
namespace {

// The sessions that follow a clock take no other times. The difference of two does not overflow.
void RequireNear(Time time, const char* what) {
  constexpr std::int64_t kFarthest = std::int64_t{1} << 62U;
  if (time.nanoseconds > -kFarthest && time.nanoseconds < kFarthest) return;
  throw InvalidArgument(std::string(what) +
                        " is too far away. A simulated clock shows times, and sums up jumps, of less than 2^62 ns.");
}

template <class F>
hgros_status UseClock(hgros_simulated_clock* clock, F&& use) {
  return Guarded([&] {
    const auto held = Given(clock, "clock").held;
    return held->Use([&](PublishedClock& of) {
      use(*of.clock);
      return hgros_status{HGROS_OK};
    });
  });
}

}  // namespace
}  // namespace hgros::c

namespace c = hgros::c;

int64_t hgros_wall_now(void) { return hgros::WallNow().nanoseconds; }
int64_t hgros_monotonic_now(void) { return hgros::MonotonicNow(); }
int64_t hgros_session_now(const hgros_session* session) {
  return session == nullptr ? 0 : session->session->clock()->Now().nanoseconds;
}

hgros_status hgros_session_sleep_until(const hgros_session* session, int64_t due_ns) {
  return c::Guarded([&] {
    const hgros_session& on = c::Opened(session);
    const auto clock = on.session->clock();
    if (SleepUntil(*clock, hgros::Time{due_ns}, on.life->stop())) return hgros_status{HGROS_OK};
    return c::Fail(HGROS_CLOSED, c::kSessionClosed);
  });
}

hgros_status hgros_timer_open(hgros_session* session, const char* name, int64_t period_ns,
                              const hgros_timer_options* options, hgros_timer_callback callback, void* user,
                              hgros_release release, hgros_timer** timer) {
  return c::CreatingFor(
      c::CallbackOf{c::LifeOf(session), {}}, user, release, timer, [&](const std::shared_ptr<const c::User>& kept) {
        const hgros_session& on = c::Opened(session);
        if (callback == nullptr) c::RefuseNull("callback");
        const hgros_timer_options chosen = c::OptionsFrom(options);
        hgros::NodeTimerOptions node;
        node.missed = chosen.catch_up != 0 ? hgros::Missed::kCatchUp : hgros::Missed::kSkip;
        if (chosen.first_ns < 0) throw c::InvalidArgument("first_ns is below zero. 0 means one period.");
        if (chosen.first_ns > 0) node.first = hgros::Duration(chosen.first_ns);
        node.executor = c::ExecutorOf(chosen.executor);
        return std::make_unique<hgros_timer>(hgros_timer{on.session->CreateTimer(
            c::Text(name, "name"), hgros::Duration(period_ns),
            [callback, kept, life = on.life](const hgros::Tick& turn) {
              const c::InCallback inside(life.get());
              const hgros_tick tick{sizeof(hgros_tick), turn.planned.nanoseconds, turn.now.nanoseconds, turn.missed};
              callback(kept->get(), &tick);
            },
            std::move(node))});
      });
}

void hgros_timer_close(hgros_timer* timer) {
  const c::InClose closes;
  delete timer;
}

hgros_status hgros_simulated_clock_open(hgros_session* session, int64_t start_ns, int32_t paused,
                                        hgros_simulated_clock** clock) {
  return c::Creating(clock, [&] {
    const hgros_session& on = c::Opened(session);
    const hgros::Time start{start_ns};
    c::RequireNear(start, "start_ns");
    auto shown = paused != 0 ? hgros::SimulatedClock::Paused(start) : std::make_shared<hgros::SimulatedClock>(start);
    auto held = std::make_shared<c::Held<c::PublishedClock>>(
        std::make_unique<c::PublishedClock>(*on.session, std::move(shown)));
    on.life->Add(held);
    return std::make_unique<hgros_simulated_clock>(hgros_simulated_clock{on.life, std::move(held)});
  });
}

hgros_status hgros_simulated_clock_close(hgros_simulated_clock* clock) {
  if (clock == nullptr) return HGROS_OK;
  return c::Closing(clock->life.get(), *clock->held, [&] { delete clock; });
}

int64_t hgros_simulated_clock_now(hgros_simulated_clock* clock) {
  int64_t now = 0;
  (void)c::UseClock(clock, [&](const hgros::SimulatedClock& of) { now = of.Now().nanoseconds; });
  return now;
}

hgros_status hgros_simulated_clock_step(hgros_simulated_clock* clock, int64_t time_ns) {
  return c::UseClock(clock, [&](hgros::SimulatedClock& of) {
    c::RequireNear(Later(of.Now(), hgros::Duration(time_ns)), "The time after the step");
    of.Step(hgros::Duration(time_ns));
  });
}
hgros_status hgros_simulated_clock_jump(hgros_simulated_clock* clock, int64_t time_ns) {
  return c::UseClock(clock, [&](hgros::SimulatedClock& of) {
    const hgros::ClockReading now = of.Read();
    const hgros::Time to{time_ns};
    c::RequireNear(to, "time_ns");
    c::RequireNear(Later(Later(to, hgros::Duration(-now.now.nanoseconds)), now.jumped), "The sum of all jumps");
    of.JumpTo(to);
  });
}
hgros_status hgros_simulated_clock_set_rate(hgros_simulated_clock* clock, double rate) {
  return c::UseClock(clock, [&](hgros::SimulatedClock& of) { of.SetRate(rate); });
}
hgros_status hgros_simulated_clock_pause(hgros_simulated_clock* clock) {
  return c::UseClock(clock, [](hgros::SimulatedClock& of) { of.Pause(); });
}
hgros_status hgros_simulated_clock_resume(hgros_simulated_clock* clock) {
  return c::UseClock(clock, [](hgros::SimulatedClock& of) { of.Resume(); });
}
