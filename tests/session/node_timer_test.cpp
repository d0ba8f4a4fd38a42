#include "hgros/session/node_timer.hpp"

#include "hgros/clock/derived_clocks.hpp"
#include "hgros/session/session_parts.hpp"
#include "session/session_fixture.hpp"
#include "support/error_of.hpp"

namespace hgros::test {
namespace {

using namespace std::chrono_literals;

std::unique_ptr<Session> SessionOn(std::shared_ptr<Clock> clock, const std::string& yaml = {}) {
  return std::make_unique<Session>(
      Config::Parse(yaml),
      SessionOptions{.name = "robot", .log = [](LogLevel, std::string_view) {}, .clock = std::move(clock)});
}

NodeSnapshot NodeOf(const Session& session, const std::string& channel) {
  for (const ChannelSnapshot& one : session.Snapshot().graph.channels) {
    if (one.name == channel) return one.nodes.at(0);
  }
  return {};
}

class Ticks {
 public:
  void operator()(const Tick& tick) {
    const std::scoped_lock lock(mutex_);
    ticks_.push_back(tick);
  }
  [[nodiscard]] std::vector<Tick> all() const {
    const std::scoped_lock lock(mutex_);
    return ticks_;
  }
  [[nodiscard]] bool Have(std::size_t count) const {
    return Await([&] { return all().size() >= count; });
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Tick> ticks_;
};

TEST(NodeTimer, FollowsTheClockOfTheSession) {
  const auto clock = SimulatedClock::Paused(Time{1000});
  const auto session = SessionOn(clock);
  EXPECT_EQ(session->clock(), clock);
  Ticks ticks;
  const NodeTimer timer = session->CreateTimer("control", 10ms, std::ref(ticks));
  for (std::size_t turn = 1; turn <= 5; ++turn) {
    clock->Step(10ms);
    ASSERT_TRUE(ticks.Have(turn));
    EXPECT_EQ(ticks.all().back().planned, Time{1000} + 10ms * static_cast<int>(turn));
    EXPECT_EQ(ticks.all().back().missed, 0U);
  }
  clock->JumpTo(Time{0});
  clock->Step(10ms);
  ASSERT_TRUE(ticks.Have(6));
  EXPECT_EQ(ticks.all().back().planned, Time{0} + 10ms) << "a jump back causes no gap";
  clock->JumpTo(Time{0} + 1h);
  clock->Step(10ms);
  ASSERT_TRUE(ticks.Have(7));
  EXPECT_EQ(ticks.all().back().planned, Time{0} + 1h + 10ms) << "a jump ahead causes no burst";
  EXPECT_EQ(ticks.all().back().missed, 0U);
}

TEST(NodeTimer, SkipsOrCatchesUpOnMissedTurns) {
  const auto clock = SimulatedClock::Paused();
  const auto session = SessionOn(clock);
  Ticks skipping;
  Ticks catching_up;
  const NodeTimer first = session->CreateTimer("skipping", 10ms, std::ref(skipping));
  const NodeTimer second =
      session->CreateTimer("catching_up", 10ms, std::ref(catching_up), {.missed = Missed::kCatchUp, .first = 5ms});
  clock->Step(100ms);
  ASSERT_TRUE(skipping.Have(1));
  ASSERT_TRUE(catching_up.Have(10));
  EXPECT_EQ(skipping.all().at(0).planned, Time{0} + 100ms);
  EXPECT_EQ(skipping.all().at(0).missed, 9U);
  for (int turn = 0; turn < 10; ++turn) {
    EXPECT_EQ(catching_up.all().at(static_cast<std::size_t>(turn)).planned, Time{0} + 5ms + turn * 10ms);
  }
}

TEST(NodeTimer, ReportsTheTurnsThatPassedWhileItsCallbackRan) {
  const auto clock = SimulatedClock::Paused();
  const auto session = SessionOn(clock);
  Ticks ticks;
  Door door;
  const NodeTimer timer = session->CreateTimer("slow", 10ms, [&](const Tick& tick) {
    ticks(tick);
    door.Pass();
  });
  for (std::uint64_t turn = 1; turn <= 5; ++turn) {
    clock->Step(10ms);
    ASSERT_TRUE(Await([&] { return timer.stats().received == turn; }));
    if (turn == 1) {
      ASSERT_TRUE(ticks.Have(1));
    }
  }
  door.Open();
  ASSERT_TRUE(ticks.Have(2));
  EXPECT_EQ(ticks.all().at(1).planned, Time{0} + 50ms) << "the latest one waits";
  EXPECT_EQ(ticks.all().at(1).missed, 3U);
  EXPECT_EQ(timer.stats().dropped, 3U);
}

TEST(NodeTimer, HasItsTurnAfterOneCallbackOfEachNodeThatIsAlwaysBusy) {
  const auto clock = SimulatedClock::Paused();
  const auto session = SessionOn(clock, "data_graph: {threads: 1}");
  Door door;
  std::atomic<int> begun{0};
  std::atomic<int> begun_before{-1};
  std::vector<Subscription> busy;
  for (const std::string channel : {"left", "right"}) {
    const auto be_busy = [&](const int&) {
      ++begun;
      door.Pass();
      Linger(2ms);  // Longer than a turn.
    };
    busy.push_back(session->FromGraph<int>(channel, Invoke::kSerial, be_busy, {.queue = Queue::KeepAll(100)}));
    for (int i = 0; i < 100; ++i) (void)session->ToGraph(channel, std::make_unique<int>(i));
  }
  const NodeTimer timer = session->CreateTimer("control", 10ms, [&](const Tick&) { begun_before = begun.load(); });
  ASSERT_TRUE(Await([&] { return begun == 1; }));
  clock->Step(10ms);
  (void)SessionParts(*session).SettleTimers();
  door.Open();
  ASSERT_TRUE(Await([&] { return begun_before >= 0; }));
  EXPECT_LE(begun_before, 2);
}

TEST(NodeTimer, IsConfiguredAndCountedLikeAnyNode) {
  const auto clock = SimulatedClock::Paused();
  const auto session =
      SessionOn(clock, "data_graph: {nodes: {control: {executor: {kind: dedicated}, queue: {keep_last: 7}}}}");
  std::atomic<int> calls{0};
  const NodeTimer timer = session->CreateTimer("control", 10ms, [&](const Tick&) {
    if (++calls == 2) throw std::runtime_error("no");
  });
  EXPECT_EQ(timer.name(), "control");
  for (int turn = 1; turn <= 3; ++turn) {
    clock->Step(10ms);
    ASSERT_TRUE(Await([&] { return calls == turn; }));
  }
  ASSERT_TRUE(session->WaitIdle(kPatience));
  const NodeSnapshot node = NodeOf(*session, "timer/control");
  EXPECT_EQ(node.name, "control");
  EXPECT_EQ(node.executor.kind(), Executor::Kind::kDedicated);
  EXPECT_EQ(node.queue, Queue::KeepLast(7));
  EXPECT_EQ(node.invoke, Invoke::kSerial);
  EXPECT_EQ(node.run, 3U);
  EXPECT_EQ(node.failed, 1U);
}

TEST(NodeTimer, RefusesAnExecutorThatNobodyRunsAsServicesDo) {
  const auto session = SessionOn(nullptr);
  EXPECT_THROW((void)session->CreateTimer("t", 1s, [](const Tick&) {}, {.executor = Executor::Polled()}), Error);
  const MessageSchema text{"text", Encoding::kCustom, 0, {}};
  const auto echo = [](const RawMessage& request) { return request.data; };
  EXPECT_THROW((void)session->ServeRaw("echo", text, text, echo, Invoke::kSerial, {.executor = Executor::Polled()}),
               Error);
  (void)session->ServeRaw("echo", text, text, echo);  // The name is still free.
}

TEST(NodeTimer, RefusesAnEmptyNameAZeroPeriodAndANameInUse) {
  const auto clock = SimulatedClock::Paused();
  const auto session = SessionOn(clock);
  const auto nothing = [](const Tick&) {};
  EXPECT_THROW((void)session->CreateTimer("", 10ms, nothing), Error);
  EXPECT_THROW((void)session->CreateTimer("control", 0ms, nothing), Error);
  NodeTimer timer = session->CreateTimer("control", 10ms, nothing);
  const std::string taken = ErrorOf([&] { return session->CreateTimer("control", 10ms, nothing); });
  EXPECT_NE(taken.find("already has a timer \"control\""), std::string::npos) << taken;
  timer.Reset();
  EXPECT_FALSE(timer.active());
  Ticks ticks;
  timer = session->CreateTimer("control", 10ms, std::ref(ticks));
  clock->Step(10ms);
  EXPECT_TRUE(ticks.Have(1)) << "the name is free again";
}

class NodeTimerOnEveryExecutor : public testing::TestWithParam<Executor> {};
INSTANTIATE_TEST_SUITE_P(Timers, NodeTimerOnEveryExecutor,
                         testing::Values(Executor::Tbb(), Executor::Inline(), Executor::Dedicated()));

TEST_P(NodeTimerOnEveryExecutor, MayBeEndedAndCreatedAgainByItsOwnCallback) {
  const auto clock = SimulatedClock::Paused();
  std::optional<NodeTimer> timer;  // before the session, whose end waits for callbacks in flight
  Ticks ticks;
  const auto session = SessionOn(clock);
  Door made;
  auto captured = std::make_shared<int>(5);
  const std::weak_ptr<int> watch = captured;
  timer.emplace(session->CreateTimer("control", 10ms,
                                     [&, captured](const Tick&) {
                                       made.Pass();
                                       EXPECT_FALSE(timer->Join()) << "it cannot wait for itself";
                                       timer->Reset();
                                       timer.emplace(session->CreateTimer("control", 10ms, std::ref(ticks),
                                                                          {.executor = GetParam()}));
                                       EXPECT_EQ(*captured, 5);
                                     },
                                     {.executor = GetParam()}));
  captured.reset();
  made.Open();
  clock->Step(10ms);
  ASSERT_TRUE(Await([&] { return watch.expired(); }));
  clock->Step(10ms);
  ASSERT_TRUE(ticks.Have(1));
  EXPECT_EQ(ticks.all().at(0).planned, Time{0} + 20ms);
}

TEST_P(NodeTimerOnEveryExecutor, ResetWaitsForItsCallbackAndNoneRunsAfterwards) {
  const auto session = SessionOn(nullptr);
  for (int round = 0; round < 50; ++round) {
    auto alive = std::make_unique<std::atomic<bool>>(true);
    NodeTimer timer = session->CreateTimer(
        "fast", 20us, [state = alive.get()](const Tick&) { EXPECT_TRUE(state->load()); }, {.executor = GetParam()});
    if (round % 2 == 0) (void)Await([&] { return timer.stats().run > 0; });
    timer.Reset();
    *alive = false;
    alive.reset();  // The address sanitizer reports a later callback.
  }
}

TEST_P(NodeTimerOnEveryExecutor, TwoTimersMayEndEachOtherInTheirCallbacks) {
  for (int round = 0; round < 20; ++round) {
    NodeTimer first;
    NodeTimer second;
    std::atomic<int> inside{0};
    std::atomic<int> done{0};
    Door made;
    const auto end = [&](NodeTimer& other) {
      made.Pass();
      ++inside;
      (void)Await([&] { return inside >= 2; }, 20ms);  // Lets both run at once if there are enough threads.
      other.Reset();
      ++done;
    };
    const auto session = SessionOn(nullptr);
    const Executor own = GetParam().kind() == Executor::Kind::kInline ? Executor::Dedicated() : GetParam();
    first = session->CreateTimer("first", 100us, [&](const Tick&) { end(second); }, {.executor = GetParam()});
    second = session->CreateTimer("second", 100us, [&](const Tick&) { end(first); }, {.executor = own});
    made.Open();
    EXPECT_TRUE(Await([&] { return done >= 1; }));
  }
}

TEST_P(NodeTimerOnEveryExecutor, SessionCanBeDestroyedWhileItsTimersFire) {
  for (int round = 0; round < 20; ++round) {
    auto session = SessionOn(nullptr);
    Session& there = *session;  // until all callbacks have returned
    std::atomic<int> calls{0};
    std::vector<NodeTimer> timers;
    for (int i = 0; i < 5; ++i) {
      const auto create_another = [&](const Tick&) {
        ++calls;
        try {
          (void)there.CreateTimer("another", 1s, [](const Tick&) {});
        } catch (const Error&) {  // Another callback creates it, or the session shuts down.
        }
      };
      timers.push_back(
          session->CreateTimer("timer" + std::to_string(i), 10us, create_another, {.executor = GetParam()}));
    }
    ASSERT_TRUE(Await([&] { return calls > 10; }));
    session.reset();
    const int last = calls;
    timers.clear();
    EXPECT_EQ(calls, last) << "no callback runs after the session has ended";
  }
}

}  // namespace
}  // namespace hgros::test
