// Parameters, transforms, clocks and timers.
#include <array>
#include <cmath>

#include "c/c_fixture.hpp"

namespace hgros::test {
namespace {

using ParamsHandle = std::unique_ptr<hgros_params, Ends<hgros_params_close>>;
using ClockHandle = std::unique_ptr<hgros_simulated_clock, Ends<hgros_simulated_clock_close>>;
using TimerHandle = std::unique_ptr<hgros_timer, Ends<hgros_timer_close>>;

class CParts : public CTest {
 protected:
  static ParamsHandle Params(const SessionHandle& session, const std::vector<std::string>& files = {}) {
    std::vector<const char*> paths;
    for (const std::string& file : files) paths.push_back(file.c_str());
    return Opened<hgros_params_close>(hgros_params_open, session.get(), paths.data(), paths.size());
  }
  static void DeclareSpeed(const ParamsHandle& params) {
    auto info = Sized<hgros_param_info>();
    info.description = "Speed of the base";
    info.unit = "m/s";
    info.has_least = info.has_most = 1;
    info.most = 2;
    EXPECT_EQ(hgros_params_declare(params.get(), "speed", HGROS_PARAM_NUMBER, "0.5", &info), HGROS_OK) << LastError();
  }
  // Watches with that, which must live as long.
  template <class Callback>
  static WatchHandle Watch(const ParamsHandle& params, const char* path, const Callback& callback) {
    const auto call = [](void* user, const char* at, const char* yaml) {
      (*static_cast<const Callback*>(user))(at, yaml);
    };
    return Opened<hgros_watch_close>(hgros_params_watch, params.get(), path, call, const_cast<Callback*>(&callback),
                                     nullptr);
  }
  static double Speed(const ParamsHandle& params) {
    double speed = -1;
    EXPECT_EQ(hgros_params_get_number(params.get(), "speed", &speed), HGROS_OK) << LastError();
    return speed;
  }
};

TEST_F(CParts, ParametersHaveKindsAndBounds) {
  const auto params = Params(session);
  DeclareSpeed(params);
  EXPECT_EQ(Speed(params), 0.5);
  EXPECT_EQ(hgros_params_set_number(params.get(), "speed", 1.5), HGROS_OK);
  EXPECT_EQ(Speed(params), 1.5);
  EXPECT_EQ(hgros_params_set_number(params.get(), "speed", 3), HGROS_REFUSED);
  EXPECT_NE(LastError().find("speed"), std::string::npos) << LastError();
  EXPECT_EQ(hgros_params_set_text(params.get(), "speed", "fast"), HGROS_REFUSED);
  EXPECT_EQ(Speed(params), 1.5);
  double missing = 7;
  EXPECT_EQ(hgros_params_get_number(params.get(), "sped", &missing), HGROS_REFUSED);
  EXPECT_EQ(missing, 0);
  EXPECT_EQ(hgros_params_declare(params.get(), "x", 99, "1", nullptr), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_params_remove(params.get(), "speed"), HGROS_OK);
  EXPECT_EQ(Speed(params), 0.5) << "back to the fallback";
}

TEST_F(CParts, ParametersOfAnyShapeAreYaml) {
  const auto params = Params(nullptr);
  ASSERT_EQ(hgros_params_set(params.get(), "arm", "{joints: [1, 2.5], name: \"left\", on: true}"), HGROS_OK);
  EXPECT_EQ(hgros_params_set_integer(params.get(), "arm.count", 3), HGROS_OK);
  EXPECT_EQ(hgros_params_set_bool(params.get(), "arm.on", 0), HGROS_OK);
  char* value = nullptr;
  ASSERT_EQ(hgros_params_get(params.get(), "arm.joints", &value), HGROS_OK);
  EXPECT_STREQ(value, "[1, 2.5]");
  hgros_text_free(value);
  ASSERT_EQ(hgros_params_get_text(params.get(), "arm.name", &value), HGROS_OK);
  EXPECT_STREQ(value, "left");
  hgros_text_free(value);
  std::int64_t count = 0;
  EXPECT_EQ(hgros_params_get_integer(params.get(), "arm.count", &count), HGROS_OK);
  EXPECT_EQ(count, 3);
  std::int32_t on = 7;
  EXPECT_EQ(hgros_params_get_bool(params.get(), "arm.on", &on), HGROS_OK);
  EXPECT_EQ(on, 0);
  EXPECT_EQ(hgros_params_set(params.get(), "arm", "{joints: ["), HGROS_CONFIG_ERROR);
  EXPECT_EQ(hgros_params_get(params.get(), "leg", &value), HGROS_REFUSED);
  EXPECT_EQ(value, nullptr);
}

TEST_F(CParts, ParametersAreReadFromFilesAndSaved) {
  const ScratchFolder folder;
  const std::string file = folder.Write("params.yaml", "speed: 1.25  # of the base\n");
  {
    const auto params = Params(nullptr, {file});
    EXPECT_EQ(Speed(params), 1.25);
    ASSERT_EQ(hgros_params_set_number(params.get(), "speed", 0.75), HGROS_OK);
    ASSERT_EQ(hgros_params_save(params.get()), HGROS_OK) << LastError();
  }
  EXPECT_EQ(Speed(Params(nullptr, {file})), 0.75);
  hgros_params* none = nullptr;
  const std::string missing = folder / "missing.yaml";
  const char* const files[] = {missing.c_str()};
  EXPECT_EQ(hgros_params_open(nullptr, files, 1, &none), HGROS_CONFIG_ERROR) << LastError();
}

TEST_F(CParts, ParametersOfAnotherSessionAreReadSetAndWatched) {
  const auto other = OpenOther();
  const auto own = Params(session);
  DeclareSpeed(own);
  const auto remote = Opened<hgros_params_close>(hgros_params_of, other.get(), "robot", kPatienceNs);
  EXPECT_EQ(Speed(remote), 0.5);
  EXPECT_EQ(hgros_params_set_number(remote.get(), "speed", 5), HGROS_REFUSED);
  EXPECT_EQ(hgros_params_set_number(remote.get(), "spee", 1), HGROS_REFUSED) << "it must exist";
  Texts changes;
  const auto note = [&](const char* path, const char* value) {
    EXPECT_EQ(hgros_params_close(own.get()), HGROS_WOULD_DEADLOCK);
    (void)Speed(own);  // It may be read in a callback.
    changes.Add(std::string(path) + "=" + (value == nullptr ? "nothing" : value));
  };
  const auto watching = Watch(own, "speed", note);
  ASSERT_EQ(hgros_params_set_number(remote.get(), "speed", 1), HGROS_OK) << LastError();
  EXPECT_EQ(Speed(own), 1);
  EXPECT_TRUE(Await([&] { return !changes.all().empty(); }));
  EXPECT_EQ(changes.all(), std::vector<std::string>{"speed=1.0"});
  EXPECT_EQ(hgros_params_save(remote.get()), HGROS_ERROR);
  EXPECT_EQ(hgros_params_declare(remote.get(), "x", HGROS_PARAM_BOOL, "true", nullptr), HGROS_ERROR);
}

TEST_F(CParts, EndOfASessionEndsItsWaitForTheParametersOfAnother) {
  const auto other = OpenOther();
  const auto own = Params(session);
  DeclareSpeed(own);
  const auto remote = Opened<hgros_params_close>(hgros_params_of, other.get(), "robot", INT64_MAX);
  std::atomic<bool> entered{false};
  Door door;
  const auto listen = [&](const char*, const char*) {
    entered = true;
    door.Pass();
  };
  const auto watching = Watch(own, "speed", listen);
  std::atomic<hgros_status> set{-1};
  std::thread setting([&] { set = hgros_params_set_number(remote.get(), "speed", 1); });
  EXPECT_TRUE(Await([&] { return entered.load(); }));
  hgros_session_end(other.get());
  EXPECT_TRUE(Await([&] { return set != -1; }, std::chrono::seconds(5)));
  door.Open();
  setting.join();
  EXPECT_EQ(set, HGROS_CLOSED);
}

TEST_F(CParts, WatchTellsOnlyOfItsPathAndNotOnceItIsClosed) {
  const auto params = Params(nullptr);
  ASSERT_EQ(hgros_params_set(params.get(), "arm", "{speed: 1, torque: 2}"), HGROS_OK);
  struct Watcher {
    std::vector<std::string> seen;
    hgros_watch* watch = nullptr;
    bool closes = false;
  } part;
  Watcher closing;
  closing.closes = true;
  const auto note = [](void* user, const char* path, const char* value) {
    auto& self = *static_cast<Watcher*>(user);
    self.seen.push_back(std::string(path) + "=" + value);
    if (self.closes) hgros_watch_close(self.watch);
  };
  ASSERT_EQ(hgros_params_watch(params.get(), "arm.speed", note, &part, nullptr, &part.watch), HGROS_OK);
  const WatchHandle watching(part.watch);
  ASSERT_EQ(hgros_params_watch(params.get(), "arm", note, &closing, nullptr, &closing.watch), HGROS_OK);
  ASSERT_EQ(hgros_params_set(params.get(), "arm", "{speed: 3, torque: 4}"), HGROS_OK) << LastError();
  EXPECT_EQ(part.seen, std::vector<std::string>{"arm.speed=3"}) << "the other one has changed, too";
  EXPECT_EQ(closing.seen.size(), 1U) << "closed in the first of two calls";
}

// Its callback meets that of another watch, and then closes that watch.
struct MeetingWatch {
  ParamsHandle params;
  hgros_watch* watch = nullptr;
  hgros_watch* other = nullptr;
  Door* here = nullptr;
  Door* there = nullptr;
  std::atomic<bool> released{false};

  void Watch() {
    EXPECT_EQ(hgros_params_watch(
                  params.get(), "a",
                  [](void* user, const char*, const char*) {
                    const auto& self = *static_cast<MeetingWatch*>(user);
                    self.here->Open();
                    self.there->Pass();
                    hgros_watch_close(self.other);
                  },
                  this, [](void* user) { static_cast<MeetingWatch*>(user)->released = true; }, &watch),
              HGROS_OK);
  }
};

TEST_F(CParts, TwoWatchesMayCloseEachOtherInTheirCallbacks) {
  std::array<MeetingWatch, 2> both;
  std::array<Door, 2> doors;
  for (std::size_t i = 0; i < 2; ++i) {
    both.at(i).params = Params(nullptr);
    both.at(i).here = &doors.at(i);
    both.at(i).there = &doors.at(1 - i);
    both.at(i).Watch();
  }
  both[0].other = both[1].watch;
  both[1].other = both[0].watch;
  std::atomic<int> done{0};
  std::vector<std::thread> threads;
  for (MeetingWatch& one : both) {
    threads.emplace_back([&] {
      EXPECT_EQ(hgros_params_set_number(one.params.get(), "a", 1), HGROS_OK) << LastError();
      ++done;
    });
  }
  ASSERT_TRUE(Await([&] { return done == 2; }, std::chrono::seconds(10))) << "each waits for the other";
  for (std::thread& one : threads) one.join();
  for (MeetingWatch& one : both) {
    EXPECT_TRUE(one.released);
    EXPECT_EQ(hgros_params_set_number(one.params.get(), "a", 2), HGROS_OK) << "nobody watches";
  }
}

hgros_transform Pose(double x, std::int64_t stamp_ns) { return {{x, 0, 0}, {0, 0, 0, 1}, stamp_ns}; }

TEST_F(CParts, TransformsAreLookedUpByNameOrSayWhyNot) {
  const auto transforms = Opened<hgros_transforms_close>(hgros_transforms_open, session.get());
  hgros_transforms* second_open = nullptr;
  EXPECT_EQ(hgros_transforms_open(session.get(), &second_open), HGROS_ERROR) << "one at a time";
  const std::int64_t now = hgros_wall_now();
  const hgros_transform laser = {{0, 0, 1}, {0, 0, std::sqrt(0.5), std::sqrt(0.5)}, 0};
  ASSERT_EQ(hgros_transforms_set_static(transforms.get(), "base", "laser", &laser), HGROS_OK) << LastError();
  const hgros_transform first = Pose(1, now);
  const hgros_transform second = Pose(3, now + 1000);
  ASSERT_EQ(hgros_transforms_set(transforms.get(), "map", "base", &first), HGROS_OK) << LastError();
  ASSERT_EQ(hgros_transforms_set(transforms.get(), "map", "base", &second), HGROS_OK) << LastError();
  hgros_transform found{};
  ASSERT_EQ(hgros_transforms_lookup_at(transforms.get(), "map", "laser", now + 500, &found), HGROS_OK) << LastError();
  EXPECT_NEAR(found.translation[0], 2, 1e-9);
  EXPECT_NEAR(found.translation[2], 1, 1e-9);
  EXPECT_NEAR(found.rotation[3], std::sqrt(0.5), 1e-9);
  EXPECT_EQ(found.stamp_ns, now + 500);
  ASSERT_EQ(hgros_transforms_lookup(transforms.get(), "map", "laser", &found), HGROS_OK);
  EXPECT_NEAR(found.translation[0], 3, 1e-9);
  EXPECT_EQ(hgros_transforms_lookup(transforms.get(), "map", "lasre", &found), HGROS_UNKNOWN_FRAME);
  EXPECT_NE(LastError().find("laser"), std::string::npos) << "names the nearest frame: " << LastError();
  EXPECT_EQ(hgros_transforms_lookup_at(transforms.get(), "map", "base", now + 2000, &found), HGROS_TOO_NEW);
  EXPECT_EQ(hgros_transforms_lookup_at(transforms.get(), "map", "base", now - 2000, &found), HGROS_TOO_OLD);
  EXPECT_EQ(hgros_transforms_wait(transforms.get(), "map", "base", now + 2000, 1'000'000, &found), HGROS_TIMED_OUT);
  const hgros_transform bent = {{0, 0, 0}, {1, 1, 1, 1}, now};
  EXPECT_EQ(hgros_transforms_set(transforms.get(), "map", "base", &bent), HGROS_REFUSED);
  EXPECT_NE(LastError().find("base"), std::string::npos) << LastError();
}

TEST_F(CParts, TransformsReachOtherSessions) {
  const auto other = OpenOther();
  const auto sends = Opened<hgros_transforms_close>(hgros_transforms_open, session.get());
  const auto receives = Opened<hgros_transforms_close>(hgros_transforms_open, other.get());
  const hgros_transform pose = Pose(2, 0);
  ASSERT_EQ(hgros_transforms_set_static(sends.get(), "map", "dock", &pose), HGROS_OK);
  hgros_transform found{};
  ASSERT_EQ(hgros_transforms_wait(receives.get(), "map", "dock", 1, -1, &found), HGROS_OK) << LastError();
  EXPECT_EQ(found.translation[0], 2);
}

TEST_F(CParts, TimersFollowASimulatedClock) {
  session = Open(yaml + "\ntime: simulated\n", log);
  const auto clock = Opened<hgros_simulated_clock_close>(hgros_simulated_clock_open, session.get(), 1000, 1);
  ASSERT_TRUE(Await([&] { return hgros_session_now(session.get()) == 1000; }));
  struct Turns {
    std::atomic<int> count{0};
    std::atomic<std::int64_t> planned{0};
    std::atomic<std::uint64_t> missed{0};
  } turns;
  hgros_timer* opened = nullptr;
  const auto note = [](void* user, const hgros_tick* tick) {
    auto& of = *static_cast<Turns*>(user);
    EXPECT_EQ(tick->size, sizeof *tick);
    of.planned = tick->planned_ns;
    of.missed = tick->missed;
    ++of.count;
  };
  EXPECT_EQ(hgros_timer_open(session.get(), "t", 0, nullptr, note, &turns, nullptr, &opened), HGROS_ERROR);
  ASSERT_EQ(hgros_timer_open(session.get(), "t", 500, nullptr, note, &turns, nullptr, &opened), HGROS_OK);
  const TimerHandle timer(opened);
  std::thread sleeping([&] { EXPECT_EQ(hgros_session_sleep_until(session.get(), 1500), HGROS_OK); });
  ASSERT_EQ(hgros_simulated_clock_step(clock.get(), 500), HGROS_OK);
  sleeping.join();
  ASSERT_TRUE(Await([&] { return turns.count == 1; }));
  EXPECT_EQ(turns.planned, 1500);
  ASSERT_EQ(hgros_simulated_clock_step(clock.get(), 1500), HGROS_OK);
  ASSERT_TRUE(Await([&] { return turns.count == 2; }));
  EXPECT_EQ(turns.planned, 3000);
  EXPECT_EQ(turns.missed, 2U);
  EXPECT_EQ(hgros_simulated_clock_now(clock.get()), 3000);
  EXPECT_EQ(hgros_simulated_clock_step(clock.get(), -1), HGROS_ERROR);
  EXPECT_EQ(hgros_simulated_clock_set_rate(clock.get(), 0), HGROS_ERROR);
  EXPECT_EQ(hgros_simulated_clock_set_rate(clock.get(), 1000), HGROS_OK);
  EXPECT_EQ(hgros_simulated_clock_resume(clock.get()), HGROS_OK);
  ASSERT_TRUE(Await([&] { return turns.count > 2; }));
  EXPECT_EQ(hgros_simulated_clock_pause(clock.get()), HGROS_OK);
  EXPECT_EQ(hgros_simulated_clock_jump(clock.get(), 50), HGROS_OK);
  EXPECT_TRUE(Await([&] { return hgros_session_now(session.get()) == 50; }));
}

TEST_F(CParts, SimulatedClockRefusesTimesThatNoneCouldFollow) {
  constexpr std::int64_t kFarthest = std::int64_t{1} << 62U;
  hgros_simulated_clock* opened = nullptr;
  EXPECT_EQ(hgros_simulated_clock_open(session.get(), INT64_MIN, 1, &opened), HGROS_INVALID_ARGUMENT);
  ASSERT_EQ(hgros_simulated_clock_open(session.get(), 1 - kFarthest, 1, &opened), HGROS_OK) << LastError();
  const ClockHandle clock(opened);
  EXPECT_EQ(hgros_simulated_clock_jump(clock.get(), INT64_MAX), HGROS_INVALID_ARGUMENT);
  EXPECT_NE(LastError().find("2^62"), std::string::npos) << LastError();
  EXPECT_EQ(hgros_simulated_clock_jump(clock.get(), kFarthest - 1), HGROS_INVALID_ARGUMENT) << "a jump too long";
  EXPECT_EQ(hgros_simulated_clock_jump(clock.get(), 0), HGROS_OK);
  EXPECT_EQ(hgros_simulated_clock_step(clock.get(), INT64_MAX), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_simulated_clock_step(clock.get(), kFarthest - 1), HGROS_OK);
  EXPECT_EQ(hgros_simulated_clock_step(clock.get(), 1), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_simulated_clock_now(clock.get()), kFarthest - 1);
}

TEST_F(CParts, TimerMayBeClosedInItsOwnCallback) {
  struct Turning {
    hgros_timer* timer = nullptr;
    Door opened;
    std::atomic<int> released{0};
  } turning;
  hgros_timer* opened = nullptr;
  ASSERT_EQ(hgros_timer_open(
                session.get(), "once", 1'000'000, nullptr,
                [](void* user, const hgros_tick*) {
                  auto& of = *static_cast<Turning*>(user);
                  of.opened.Pass();
                  hgros_timer_close(of.timer);
                },
                &turning, [](void* user) { ++static_cast<Turning*>(user)->released; }, &opened),
            HGROS_OK);
  turning.timer = opened;
  turning.opened.Open();
  EXPECT_TRUE(Await([&] { return turning.released == 1; }));
}

}  // namespace
}  // namespace hgros::test
