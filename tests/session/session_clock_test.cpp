// A simulated clock that all sessions of a domain follow.
#include <unistd.h>

#include <cmath>

#include <hgros/SimulatedTime.pb.h>

#include "hgros/clock/following_clock.hpp"
#include "hgros/clock/rate.hpp"
#include "hgros/session/clock_publisher.hpp"
#include "services/services_fixture.hpp"

namespace hgros::test {
namespace {

using namespace std::chrono_literals;

const std::string kSimulated = "time: simulated\n";
// A time that differs from the wall clock.
constexpr Time kStart{1'000'000'000'000'000};

bool Shows(const Session& session, Time time) {
  return Await([&] { return session.clock()->Now() == time; });
}

class Controller {
 public:
  explicit Controller(Session& session)
      : session_(session),
        listening_(session.clock()->OnJump([this](const ClockJump& jump) { jumped_to_ = jump.after.nanoseconds; })),
        timer_(session.CreateTimer("control", 10ms,
                                   [this](const Tick& tick) { turns_ += 1 + static_cast<int>(tick.missed); })) {}

  [[nodiscard]] bool IsAt(Time time) const {
    const int turns = time >= kStart ? static_cast<int>((time - kStart) / 10ms) : 20;
    return Shows(session_, time) && Await([&] { return turns_ == turns; });
  }
  [[nodiscard]] Time jumped_to() const { return Time{jumped_to_}; }

 private:
  Session& session_;
  std::atomic<int> turns_{0};
  std::atomic<std::int64_t> jumped_to_{0};
  Listening listening_;
  NodeTimer timer_;
};

class SessionClockOnEveryTransport : public DomainFixture, public testing::WithParamInterface<std::string> {};

// The program: a simulation that steps, and a controller with a timer.
TEST_P(SessionClockOnEveryTransport, FollowsThePublishedClock) {
  Pair pair(PlacesOf(GetParam()), kSimulated, kSimulated);
  const Controller controller(pair.caller());
  EXPECT_EQ(pair.caller().clock()->Now(), Time{}) << "no clock is published yet";
  const auto clock = SimulatedClock::Paused(kStart);
  const ClockPublisher publisher(pair.server(), clock);
  ASSERT_TRUE(controller.IsAt(kStart));
  for (int step = 0; step < 20; ++step) {
    clock->Step(10ms);
    ASSERT_TRUE(controller.IsAt(clock->Now())) << step;
  }
  clock->JumpTo(Time{5});
  ASSERT_TRUE(controller.IsAt(Time{5}));
  EXPECT_TRUE(Await([&] { return controller.jumped_to() == Time{5}; }));  // The clock shows it before it tells it.
}

INSTANTIATE_TEST_SUITE_P(Placed, SessionClockOnEveryTransport, testing::Values("pointer", "sharedmemory", "ipc", "tcp"),
                         TransportName);

class SessionClock : public DomainFixture {};

class SimulatedSession : public SessionClock {
 protected:
  const Robot simulation{""};
  Robot robot{kSimulated};
};

TEST_F(SessionClock, IsTheSystemClockUnlessYamlSaysOtherwise) {
  const Robot robot("");
  const Time before = WallNow();
  const Time shown = robot->clock()->Now();
  EXPECT_GE(shown, before);
  EXPECT_LE(shown, WallNow());
  EXPECT_FALSE(robot->config().simulated_time);
  EXPECT_TRUE(Config::Parse("time: simulated").simulated_time);
  EXPECT_FALSE(Config::Parse("time: system").simulated_time);
  EXPECT_THROW((void)Config::Parse("time: simulate"), ConfigError);
}

TEST_F(SimulatedSession, KeepsRunningBetweenMessages) {
  const auto clock = std::make_shared<SimulatedClock>(kStart);
  clock->SetRate(1000);
  const ClockPublisher publisher(*simulation.session, clock);
  ASSERT_TRUE(Await([&] { return robot->clock()->Now() >= kStart; }));
  Rate rate(robot->clock(), 1s);  // 1 ms of real time: far more often than the clock is published.
  std::uint64_t turns = 0;
  while (turns < 500) {
    const auto tick = rate.Sleep();
    ASSERT_TRUE(tick);
    turns += 1 + tick->missed;
  }
  EXPECT_LT(robot->Snapshot().traffic.at(0).in.at(0).received, 100U);
}

// And which names are probably misspelled, as soon; at its end, those that came later.
TEST_F(SessionClock, SaysThatNoClockIsPublishedSomeSecondsAfterTheStart) {
  const Robot simulation("");
  const auto begin = std::chrono::steady_clock::now();
  Robot waiting(
      kSimulated +
      "discovery: {local: false}\n"
      "data_graph: {close_channels: [pre_chanel], nodes: {planner: {queue: latest}, localisation: {queue: latest}}}\n"
      "channels: {scna: {queue: latest}}");
  const auto planner = waiting->FromGraph<Note>("pre_channel", kSerial, [](const Note&) {}, {.name = "planner"});
  const auto localizer = waiting->FromGraph<Note>("pre_channel", kSerial, [](const Note&) {}, {.name = "localization"});
  Robot following(kSimulated);
  const ClockPublisher publisher(*simulation.session, SimulatedClock::Paused(kStart));
  EXPECT_TRUE(Await([&] { return waiting.Said("No clock was heard on the channel \"clock\" so far"); }));
  const auto took = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(took, 4s) << "a clock that begins a little later is nothing to speak of";
  Linger(200ms);
  EXPECT_EQ(waiting.Count("No clock was heard"), 1U);
  EXPECT_FALSE(following.Said("No clock was heard"));

  EXPECT_TRUE(Await(
      [&] { return waiting.Said("\"pre_chanel\" in data_graph.close_channels (did you mean \"pre_channel\"?)"); }));
  EXPECT_TRUE(Await([&] { return waiting.Said("has so far: \"localisation\" (did you mean \"localization\"?)."); }));
  EXPECT_FALSE(waiting.Said("scna"));
  (void)waiting->ToAny("scan", Note("x"));
  waiting.session.reset();
  EXPECT_TRUE(waiting.Said("has not used so far: \"scna\" in channels (did you mean \"scan\"?)."));
  EXPECT_EQ(waiting.Count("has not used so far"), 2U);
  EXPECT_EQ(waiting.Count("has so far"), 1U);
}

TEST_F(SessionClock, ReachesLateSessions) {
  const Robot simulation("");
  const auto clock = SimulatedClock::Paused(kStart);
  const ClockPublisher publisher(*simulation.session, clock);
  clock->Step(7s);
  for (int i = 0; i < 3; ++i) {
    const Robot late(kSimulated);
    EXPECT_TRUE(Shows(*late.session, kStart + 7s));
  }
}

TEST_F(SimulatedSession, WakesSleepersDespiteAListenerThatThrowsAndPausesWhenThePublishedClockEnds) {
  const auto clock = std::make_shared<SimulatedClock>(kStart);
  auto publisher = std::make_optional<ClockPublisher>(*simulation.session, clock);
  ASSERT_TRUE(Await([&] { return robot->clock()->Now() >= kStart; }));
  const Listening throwing = robot->clock()->OnJump([](const ClockJump&) { throw std::runtime_error("no jumps"); });
  std::atomic<bool> told{false};
  const Listening telling = robot->clock()->OnJump([&](const ClockJump&) { told = true; });
  std::atomic<bool> awake{false};
  std::jthread sleeper([&] { awake = SleepUntil(*robot->clock(), kStart + 24h); });
  Linger(10ms);
  clock->JumpTo(kStart + 25h);
  EXPECT_TRUE(Await([&] { return awake && told; })) << "a listener that throws keeps nobody asleep";
  EXPECT_TRUE(Await([&] { return robot.Said("session's clock threw: no jumps"); }));

  publisher.reset();
  const auto follower = std::dynamic_pointer_cast<FollowingClock>(robot->clock());
  ASSERT_TRUE(follower);
  EXPECT_TRUE(Await([&] { return follower->State().paused; })) << "it pauses when the published clock ends";
  const Time stands = robot->clock()->Now();
  EXPECT_GE(stands, kStart + 25h);
  publisher.emplace(*simulation.session, SimulatedClock::Paused(kStart + 1s));
  EXPECT_TRUE(Shows(*robot.session, kStart + 1s)) << "another simulation begins";
}

TEST_F(SessionClock, PausesWhenItsPublisherIsGoneAndFollowsTheNextOne) {
  Robot robot(kSimulated);
  std::optional<Robot> simulation(std::in_place, "", "first");
  const auto clock = std::make_shared<SimulatedClock>(kStart);
  // The session ends without the publisher's goodbye, as if its process had died.
  std::optional<ClockPublisher> publisher(std::in_place, *simulation->session, clock);
  ASSERT_TRUE(Await([&] { return robot->clock()->Now() >= kStart; }));
  simulation.reset();
  const auto follower = std::dynamic_pointer_cast<FollowingClock>(robot->clock());
  EXPECT_TRUE(Await([&] { return follower->State().paused; }));
  EXPECT_TRUE(robot.Said("The clock stands still: first"));
  publisher.reset();
  Robot next("", "next");
  const ClockPublisher other(*next.session, SimulatedClock::Paused(kStart + 9h));
  EXPECT_TRUE(Shows(*robot.session, kStart + 9h));
  EXPECT_FALSE(robot.Said("Two clocks"));
}

TEST_F(SessionClock, FollowsTheFirstOfTwoPublishedClocksAndReportsBoth) {
  Robot robot(kSimulated);
  Robot first("", "first");
  Robot second("", "second");
  std::optional<ClockPublisher> one(std::in_place, *first.session, SimulatedClock::Paused(kStart));
  ASSERT_TRUE(Shows(*robot.session, kStart));
  const ClockPublisher two(*second.session, SimulatedClock::Paused(kStart + 1h));
  ASSERT_TRUE(Await([&] { return robot.Said("Two clocks are published"); }));
  EXPECT_TRUE(robot.Said("by first:" + std::to_string(getpid()) + ", which this session follows"));
  EXPECT_TRUE(robot.Said("by second:" + std::to_string(getpid())));
  EXPECT_EQ(robot->clock()->Now(), kStart);
  one.reset();
  EXPECT_TRUE(Shows(*robot.session, kStart + 1h)) << "now it is the only one";
}

TEST_F(SessionClock, LatestStateReachesASubscriberThatHadNoRoom) {
  const Robot simulation("");
  Door door;
  std::atomic<std::int64_t> shown{0};
  const Subscription slow = simulation->FromAny<SimulatedTime>(kClockChannel, Invoke::kSerial,
                                                               [&](const SimulatedTime& time) {
                                                                 door.Pass();
                                                                 shown = time.time_ns();
                                                               },
                                                               {{}, Queue::KeepAll(1), Executor::Dedicated()});
  const auto clock = SimulatedClock::Paused(kStart);
  const ClockPublisher publisher(*simulation.session, clock);
  const auto channel = [&] {
    const auto channels = simulation->Snapshot().graph.channels;
    const auto found = std::ranges::find(channels, kClockChannel, &ChannelSnapshot::name);
    return found == channels.end() ? ChannelSnapshot() : *found;
  };
  for (std::uint64_t said = 1; channel().refused == 0; ++said) {
    ASSERT_TRUE(Await([&] { return channel().published + channel().refused >= said; }));
    if (channel().refused == 0) clock->Step(1ms);
  }
  const Time last = clock->Now();
  door.Open();
  EXPECT_TRUE(Await([&] { return shown == last.nanoseconds; }));
}

TEST_F(SessionClock, IgnoresMessagesThatCannotBeAClock) {
  Robot robot(kSimulated);
  const auto publish = robot->Advertise<SimulatedTime>(kClockChannel);
  SimulatedTime time;
  time.set_clock_id(1);
  for (const double rate : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    time.set_rate(rate);
    (void)publish(time);
  }
  time.set_rate(1);
  time.set_time_ns(INT64_MIN);
  (void)publish(time);
  time.set_time_ns(0);
  time.set_jumped_ns(INT64_MAX);
  (void)publish(time);
  EXPECT_TRUE(robot.Said("cannot be a clock"));
  EXPECT_EQ(robot->clock()->Now(), Time{});
  time.set_jumped_ns(0);
  time.set_time_ns(77);
  time.set_paused(true);
  (void)publish(time);
  EXPECT_EQ(robot->clock()->Now(), Time{77});
}

}  // namespace
}  // namespace hgros::test
