// A process with a session that forks.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include <foxglove/Log.pb.h>

#include "hgros/clock/derived_clocks.hpp"
#include "hgros/clock/system_clocks.hpp"
#include "hgros/hgros.hpp"
#include "hgros/params/param_file_watch.hpp"
#include "hgros/params/param_server.hpp"
#include "hgros/params/param_service.hpp"
#include "hgros/session/clock_publisher.hpp"
#include "hgros/tf/transforms.hpp"
#include "resilience/places.hpp"
#include "support/await.hpp"

namespace hgros::resilience {
namespace {

using foxglove::Log;
using test::Await;
using test::kPatience;

SessionOptions Quiet() {
  return {"forking", [](LogLevel, std::string_view) {}};
}
Config Parse(const std::string& argument) { return Config::Parse(argument.substr(std::string("--config=").size())); }

/// Runs `child` in a forked child; its exit status, or -1 if it did not end in time.
int InChild(const std::function<int()>& child) {
  (void)std::fflush(nullptr);
  const pid_t pid = fork();
  if (pid == 0) std::exit(child());
  int status = 0;
  if (!Await([&] { return waitpid(pid, &status, WNOHANG) == pid; })) {
    kill(pid, SIGKILL);
    waitpid(pid, &status, 0);
    return -1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Two sessions of this process that talk, as their children inherit them.
class Fork : public testing::Test {
 protected:
  Fork() {
    listener.emplace(Parse(Subscribing(bus)), Quiet());
    subscription = listener->FromAny<Log>("log", Invoke::kSerial, [this](const Log&) { ++received; },
                                          {{}, Queue::KeepAll(64), {}});
    talker.emplace(Parse(Publishing(bus)), Quiet());
    publish = talker->Advertise<Log>("log");
  }
  void ExpectUndisturbed() {
    const int before = received;
    for (int i = 0; i < 100; ++i) {
      ASSERT_EQ(publish.Wait(std::make_unique<Log>(), std::chrono::steady_clock::now() + kPatience),
                PublishStatus::kOk);
    }
    EXPECT_TRUE(Await([&] { return received == before + 100; })) << received - before;
  }

  const ScratchFolder folder;
  const std::string bus = folder.Ipc("bus");
  std::atomic<int> received{0};
  std::optional<Session> listener;
  Subscription subscription;
  std::optional<Session> talker;
  Publisher<Log> publish;
};

// Ends its process with another status if a child destroys it.
struct OfThisProcess {
  const pid_t owner = getpid();
  ~OfThisProcess() {
    if (getpid() != owner) _exit(99);
  }
};

TEST_F(Fork, ChildrenDoNotDisturbTheSessions) {
  ASSERT_TRUE(talker->WaitForSubscribers("log", 1, kPatience));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(InChild([] { return 0; }), 0) << "it exits at once";
  ExpectUndisturbed();

  EXPECT_EQ(InChild([this] {
              for (int i = 0; i < 100; ++i) {
                if (publish(std::make_unique<Log>()) != PublishStatus::kClosed) return 1;
                if (talker->ToAny("log", Log()) != PublishStatus::kClosed) return 2;
              }
              return 0;
            }),
            0)
      << "it publishes, and is refused";
  ExpectUndisturbed();

  EXPECT_EQ(InChild([this] {
              subscription.Reset();
              talker.reset();
              listener.reset();
              return 0;
            }),
            0)
      << "it destroys the sessions";
  ExpectUndisturbed();

  EXPECT_EQ(InChild([this] {
              std::atomic<int> heard{0};
              Session own(Parse(Subscribing(bus)), Quiet());
              const auto mine = own.FromAny<Log>("log", Invoke::kSerial, [&](const Log&) { ++heard; });
              return own.WaitForPublishers("log", 1, kPatience) ? 0 : 1;
            }),
            0)
      << "it makes a session of its own";
  ExpectUndisturbed();

  const auto idle = talker->FromGraph<Log>(
      "idle", Invoke::kSerial, [held = std::make_shared<OfThisProcess>()](const Log&) { EXPECT_TRUE(held); });
  for (const Executor& executor : {Executor::Tbb(), Executor::Inline(), Executor::Dedicated()}) {
    constexpr int kRuns = -2;
    std::atomic<int> status{kRuns};
    const auto forks = talker->FromGraph<Log>(
        "forks", Invoke::kSerial, [&](const Log&) { status = InChild([] { return 5; }); }, {{}, {}, executor});
    ASSERT_EQ(talker->ToGraph("forks", std::make_unique<Log>()), PublishStatus::kOk);
    ASSERT_TRUE(Await([&] { return status != kRuns; }));
    EXPECT_EQ(status, 5) << "a callback forks it";
  }
  ExpectUndisturbed();
}

TEST_F(Fork, AChildOfABusyProcessEnds) {
  ASSERT_TRUE(talker->WaitForSubscribers("log", 1, kPatience));
  int published = 0;
  {
    std::jthread busy([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) published += publish(std::make_unique<Log>()) == PublishStatus::kOk ? 1 : 0;
    });
    ASSERT_TRUE(Await([&] { return received > 100; }));
    for (int i = 0; i < 10; ++i) {
      EXPECT_EQ(InChild([this] { return publish(std::make_unique<Log>()) == PublishStatus::kClosed ? 0 : 1; }), 0);
    }
  }
  EXPECT_TRUE(Await([&] { return received == published; })) << received << " of " << published;
}

TEST_F(Fork, AChildThatDestroysObjectsWithThreadsSomeOfThemBusyEnds) {
  ParamServer server;
  ParamServer watched(ParamSources{{folder.Write("params.yaml", "speed: 1\n")}, {}});
  std::optional<ParamFileWatch> watch(std::in_place, watched, [](const ParamResult&) {});
  std::optional<ParamService> params(std::in_place, *talker, server);
  std::optional<Transforms> transforms(std::in_place, *talker);
  std::optional<ClockPublisher> clock(std::in_place, *talker, std::make_shared<SimulatedClock>());
  std::optional<SystemClock> system(std::in_place);
  const Listening jumps = system->OnJump([](const ClockJump&) {});
  test::Door door;
  std::atomic<int> inside{0};
  std::optional<Service> service(talker->Serve<Log, Log>("busy", [&](const Log& log) {
    ++inside;
    door.Pass();
    return log;
  }));
  std::optional<CallFuture<Log>> call(talker->Call<Log, Log>("busy", Log(), kPatience));
  ASSERT_TRUE(Await([&] { return inside == 1; }));
  const auto stay = [&](const Tick&) {
    ++inside;
    door.Pass();
  };
  std::optional<NodeTimer> node(
      talker->CreateTimer("busy", std::chrono::milliseconds(1), stay, {.executor = Executor::Inline()}));
  std::optional<TimerQueue> queue(std::in_place, std::make_shared<SteadyClock>());
  std::optional<Timer> timer(queue->Every(std::chrono::milliseconds(1), stay));
  ASSERT_TRUE(Await([&] { return inside == 3; }));
  EXPECT_EQ(InChild([&] {
              watch.reset();
              params.reset();
              transforms.reset();
              clock.reset();
              system.reset();
              call.reset();
              service.reset();
              node.reset();
              timer.reset();
              queue.reset();
              talker.reset();
              return 0;
            }),
            0);
  door.Open();
  EXPECT_TRUE(call->Wait());
}

TEST(ForkOfADefaultSession, AChildThatExitsEnds) {
  const ScratchFolder folder;
  Init(Parse(Both(folder.Ipc("a"), folder.Ipc("b"))), Quiet());
  FromAny<Log>("log", Invoke::kSerial, [](const Log&) {}, {{}, {}, Executor::Dedicated()});
  FromAny<Log>("log", Invoke::kSerial, [](const Log&) {});
  EXPECT_EQ(ToAny("log", Log()), PublishStatus::kOk);
  EXPECT_EQ(InChild([] { return ToAny("log", Log()) == PublishStatus::kClosed ? 0 : 1; }), 0);
  Shutdown();
}

}  // namespace
}  // namespace hgros::resilience
