// One program of a server and its callers, by pointer, through shared memory, over ipc and over tcp.
#include <gmock/gmock.h>

#include <array>
#include <random>

#include "services/services_fixture.hpp"
#include "support/seed.hpp"

namespace hgros::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class ServiceOverEveryTransport : public PairFixture {};

TEST_P(ServiceOverEveryTransport, RepliesToACallback) {
  const Service service = pair->server().Serve<Sum, Total>("add", Add);
  std::atomic<int> sum{0};
  const auto ticket = pair->caller().Call<Sum, Total>("add", std::make_unique<Sum>(Sum{2, 3}), kLong,
                                                      [&](const CallResult<Total>& result) { sum = result->value; });
  EXPECT_TRUE(Await([&] { return sum == 5; }));
  EXPECT_TRUE(ticket.done());
}

TEST_P(ServiceOverEveryTransport, IsWaitedForUntilItIsServed) {
  EXPECT_FALSE(pair->caller().WaitForService("add", std::chrono::milliseconds(1)));
  bool found = false;
  std::thread waiting([&] { found = pair->caller().WaitForService("add", kLong); });
  Service service = pair->server().Serve<Sum, Total>("add", Add);
  waiting.join();
  ASSERT_TRUE(found);
  EXPECT_TRUE((pair->caller().Call<Sum, Total>("add", Sum{2, 3}, kLong).Wait()));
  service.Reset();
  EXPECT_TRUE(Await([&] { return !pair->caller().WaitForService("add", std::chrono::nanoseconds(0)); }));
}

TEST_P(ServiceOverEveryTransport, ReportsWhatTheHandlerThrew) {
  const Service service = pair->server().Serve<Note, Note>(
      "parse", [](const Note& note) -> Note { throw std::runtime_error("\"" + note.text + "\" is not a number"); });
  const auto result = pair->caller().Call<Note, Note>("parse", Note("seven"), kLong).Wait();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.failure().kind, Kind::kHandlerFailed);
  EXPECT_EQ(result.failure().reason, "\"seven\" is not a number");
  const auto odd = pair->caller().Call<Note, Note>("parse", Note("caf\xe9"), kLong).Wait();
  ASSERT_FALSE(odd);
  EXPECT_EQ(odd.failure().reason, R"("caf\xe9" is not a number)") << "always UTF-8";
}

TEST_P(ServiceOverEveryTransport, TimesOutWhileTheHandlerIsBusy) {
  Door door;
  const auto handle = [&](const Sum& sum) {
    if (sum.a == 1) door.Pass();
    return Add(sum);
  };
  const Service service = pair->server().Serve<Sum, Total>("slow", handle, Invoke::kConcurrent);
  ASSERT_TRUE((pair->caller().Call<Sum, Total>("slow", Sum{2, 3}, kLong).Wait()));
  const auto result = pair->caller().Call<Sum, Total>("slow", Sum{1, 1}, std::chrono::milliseconds(300)).Wait();
  EXPECT_FALSE(result);
  EXPECT_EQ(result.failure().kind, Kind::kTimedOut);
  EXPECT_EQ(result.failure().reason, "Service \"slow\" did not reply within 300 ms.");
  door.Open();
}

TEST_P(ServiceOverEveryTransport, MatchesThousandsOfRepliesInAnyOrder) {
  constexpr int kCalls = 2000;
  std::vector<Service> services;
  // Two services on their own threads, so that replies come in any order.
  const auto handler = [](const Sum& sum) { return Add(sum); };
  services.push_back(pair->server().Serve<Sum, Total>("left", handler, Invoke::kConcurrent));
  services.push_back(
      pair->server().Serve<Sum, Total>("right", handler, Invoke::kConcurrent, {.executor = Executor::Dedicated()}));
  std::vector<CallFuture<Total>> futures;
  futures.reserve(kCalls);
  for (int i = 0; i < kCalls; ++i) {
    futures.push_back(pair->caller().Call<Sum, Total>(i % 2 == 0 ? "left" : "right", Sum{i, 1}, kLong));
  }
  std::vector<int> order(kCalls);
  for (int i = 0; i < kCalls; ++i) order[static_cast<std::size_t>(i)] = i;
  std::mt19937 random(7);
  std::shuffle(order.begin(), order.end(), random);
  for (const int i : order) {
    const auto result = futures[static_cast<std::size_t>(i)].Wait();
    ASSERT_TRUE(result) << i << ": " << result.failure().reason;
    ASSERT_EQ(result->value, i + 1);
  }
}

TEST_P(ServiceOverEveryTransport, CancelsACallAndItsWaitingRequest) {
  Door door;
  std::atomic<int> handled{0};
  const Service service = pair->server().Serve<Sum, Total>("slow", [&](const Sum& sum) {
    ++handled;
    if (sum.a == 1) door.Pass();
    return Add(sum);
  });
  const auto first = pair->caller().Call<Sum, Total>("slow", Sum{1, 1}, kLong);
  ASSERT_TRUE(Await([&] { return handled == 1; }));
  const auto second = pair->caller().Call<Sum, Total>("slow", Sum{2, 1}, kLong);
  second.Cancel();
  EXPECT_EQ(second.Wait().failure().kind, Kind::kCancelled);
  { const auto dropped = pair->caller().Call<Sum, Total>("slow", Sum{3, 1}, kLong); }
  // Sent after the two, and after their ends, over the same connection.
  const auto last = pair->caller().Call<Sum, Total>("slow", Sum{4, 1}, kLong);
  ASSERT_TRUE(Await([&] { return service.stats().received == 4; }));
  door.Open();
  EXPECT_EQ(first.Wait()->value, 2);
  EXPECT_EQ(last.Wait()->value, 5);
  EXPECT_EQ(handled, 2);
}

TEST_P(ServiceOverEveryTransport, FailsCallsWhenTheServiceEnds) {
  Door door;
  std::atomic<int> handled{0};
  Service service = pair->server().Serve<Sum, Total>("slow", [&](const Sum& sum) {
    ++handled;
    door.Pass();
    return Add(sum);
  });
  const auto begun = pair->caller().Call<Sum, Total>("slow", Sum{1, 1}, kLong);
  ASSERT_TRUE(Await([&] { return handled == 1; }));
  std::vector<CallFuture<Total>> waiting;
  for (int i = 0; i < 8; ++i) waiting.push_back(pair->caller().Call<Sum, Total>("slow", Sum{i, 1}, kLong));
  std::jthread ender([&] { service.Reset(); });
  for (const auto& call : waiting) EXPECT_EQ(call.Wait().failure().kind, Kind::kServerGone);
  door.Open();
  EXPECT_TRUE(begun.Wait() || begun.Wait().failure().kind == Kind::kServerGone);
}

// A request that comes between two servers of one session reaches neither. The caller sees the same session before and
// after.
TEST_P(ServiceOverEveryTransport, EndsEveryCallAlthoughTheServiceIsServedAgainAtOnce) {
  const int lives = test::Rounds(15, 60);
  constexpr std::chrono::seconds kLost{20};
  std::atomic<bool> stop{false};
  std::atomic<int> newest{0};  // The latest reply.
  std::atomic<int> lost{0};
  Service service = pair->server().Serve<Sum, Total>("add", Add);
  std::jthread caller([&] {
    while (!stop && lost == 0) {
      const auto result = pair->caller().Call<Sum, Total>("add", Sum{2, 3}, kLost).Wait();
      if (result) newest = result->value;
      if (!result && result.failure().kind == Kind::kTimedOut) ++lost;
    }
  });
  for (int life = 1; life <= lives && lost == 0 && !HasFailure(); ++life) {
    service.Reset();
    EXPECT_FALSE(service.active());
    service = pair->server().Serve<Sum, Total>("add", [life](const Sum& sum) { return Total{sum.a + sum.b + life}; });
    EXPECT_TRUE(Await([&] { return newest == 5 + life || lost > 0; })) << life;
    const auto next = pair->caller().Call<Sum, Total>("add", Sum{2, 3}, kLost).Wait();
    EXPECT_TRUE(!next || next->value == 5 + life) << life;
  }
  stop = true;
  caller.join();
  EXPECT_EQ(lost, 0);
}

// The thread that subscribes to the requests again is held, in a callback of an event.
TEST_P(ServiceOverEveryTransport, ServedAgainRunsNoCallThatFailsBecauseTheLastOneHasEnded) {
  if (GetParam() == "pointer") GTEST_SKIP() << "calls of one session go to the service directly";
  Door errands;
  Door door;
  std::atomic<bool> held{false};
  std::atomic<int> handled{0};
  Service service = pair->server().Serve<Sum, Total>("add", Add);
  ASSERT_TRUE((pair->caller().Call<Sum, Total>("add", Sum{2, 3}, kLong).Wait()));
  const auto hold = [&](const PeerEvent& event) {
    if (event.kind != PeerEvent::Kind::kTypeMismatch) return;
    held = true;
    errands.Pass();
  };
  const auto events = pair->server().FromGraph<PeerEvent>(kPeerEventsChannel, kSerial, hold, Inline());
  const auto notes = pair->server().Advertise<Note>("odd");
  const auto sums = pair->caller().FromAny<Sum>("odd", kSerial, [](const Sum&) {});
  ASSERT_TRUE(Await([&] { return held.load(); }));
  service.Reset();
  service = pair->server().Serve<Sum, Total>("add", [&](const Sum& sum) {
    ++handled;
    door.Pass();
    return Add(sum);
  });
  const auto call = pair->caller().Call<Sum, Total>("add", Sum{2, 3}, kLong);
  (void)Await([&] { return handled > 0; }, std::chrono::milliseconds(200));  // It never is.
  errands.Open();
  EXPECT_EQ(call.Wait().failure().kind, Kind::kServerGone);
  EXPECT_EQ(handled, 0);
  door.Open();
  EXPECT_TRUE(Await([&] { return bool(pair->caller().Call<Sum, Total>("add", Sum{2, 3}, kLong).Wait()); }));
  service.Reset();
}

TEST_P(ServiceOverEveryTransport, FailsWithFullWhenTooManyRequestsWait) {
  Door door;
  std::atomic<int> handled{0};
  const auto handle = [&](const Sum& sum) {
    ++handled;
    door.Pass();
    return Add(sum);
  };
  const Service service =
      pair->server().Serve<Sum, Total>("slow", handle, Invoke::kSerial, {.queue = Queue::KeepAll(2)});
  const auto first = pair->caller().Call<Sum, Total>("slow", Sum{0, 0}, kLong);
  ASSERT_TRUE(Await([&] { return handled == 1; }));
  std::vector<CallFuture<Total>> calls;
  for (int i = 0; i < 3; ++i) calls.push_back(pair->caller().Call<Sum, Total>("slow", Sum{i, i}, kLong));
  const auto full = calls.back().Wait();
  EXPECT_EQ(full.failure().kind, Kind::kFull);
  EXPECT_EQ(full.failure().reason, "Service \"slow\" has 2 requests waiting already.");
  door.Open();
  EXPECT_TRUE(calls[0].Wait());
  EXPECT_TRUE(calls[1].Wait());
}

TEST_P(ServiceOverEveryTransport, ReportsATypeMismatchOfTheRequestAndOfTheReply) {
  std::atomic<int> handled{0};
  const auto handle = [&](const Sum& sum) {
    ++handled;
    return Add(sum);
  };
  const Service add = pair->server().Serve<Sum, Total>("add", handle);
  const Service other = pair->server().Serve<Sum, Total>("other", handle);  // A session calls each with one type.
  const auto request = pair->caller().Call<Note, Total>("add", Note("2+3"), kLong).Wait().failure();
  EXPECT_EQ(request.kind, Kind::kTypeMismatch);
  EXPECT_THAT(request.reason, AllOf(HasSubstr("Note"), HasSubstr("Sum")));
  const auto reply = pair->caller().Call<Sum, Note>("other", Sum{2, 3}, kLong).Wait().failure();
  EXPECT_EQ(reply.kind, Kind::kTypeMismatch);
  EXPECT_THAT(reply.reason, AllOf(HasSubstr("Note"), HasSubstr("Total")));
  EXPECT_EQ(handled, 0);
}

TEST_P(ServiceOverEveryTransport, ReportsMessagesThatCannotBeEncodedOrDecoded) {
  if (GetParam() == "pointer") GTEST_SKIP() << "nothing is encoded there";
  const Service service = pair->server().Serve<Note, Note>("echo", [](const Note& note) { return note; });
  for (const std::string text : {"unwritable", "unreadable"}) {
    const auto result = pair->caller().Call<Note, Note>("echo", Note(text), kLong).Wait();
    EXPECT_EQ(result.failure().kind, Kind::kNotWritable) << text << ": " << result.failure().reason;
  }
  EXPECT_EQ((pair->caller().Call<Note, Note>("echo", Note("fine"), kLong).Wait()->text), "fine");
}

TEST_P(ServiceOverEveryTransport, WaitsForAServerThatIsStarting) {
  if (GetParam() == "pointer") GTEST_SKIP() << "one session knows at once that there is no server";
  const auto early = pair->caller().Call<Sum, Total>("add", Sum{2, 3}, kLong);
  const Service service = pair->server().Serve<Sum, Total>("add", Add);
  const auto result = early.Wait();
  ASSERT_TRUE(result) << result.failure().reason;
  EXPECT_EQ(result->value, 5);
}

TEST_P(ServiceOverEveryTransport, EndsAllCallsUnderLoadWhenEitherSessionEnds) {
  if (GetParam() == "pointer") GTEST_SKIP() << "one session";
  for (const bool server_first : {true, false}) {
    std::array<std::atomic<int>, 10> failures{};  // By kind.
    std::atomic<int> replies{0};
    std::atomic<int> ended{0};
    std::atomic<int> made{0};
    pair.emplace(PlacesOf(GetParam()));
    Service service = pair->server().Serve<Sum, Total>("add", Add, Invoke::kConcurrent);
    Session& caller = pair->caller();
    std::jthread load([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        ++made;
        caller.Call<Sum, Total>("add", Sum{1, 2}, std::chrono::seconds(1), [&](const CallResult<Total>& result) {
          if (result) ++replies;
          if (!result) failures[static_cast<std::size_t>(result.failure().kind)]++;
          ++ended;
        });
        if (made % 64 == 0) (void)Await([&] { return made - ended < 256 || stop.stop_requested(); });
      }
    });
    EXPECT_TRUE(Await([&] { return replies > 200; }))
        << replies << " replies to " << made << " calls, " << ended << " ended; " << failures[0] << " found no server, "
        << failures[1] << " timed out";
    if (server_first) pair->EndServer();
    load.request_stop();
    load.join();
    if (!server_first) pair->EndCaller();
    EXPECT_TRUE(Await([&] { return made == ended; }))
        << (server_first ? "server" : "caller") << " first: " << made << " calls, " << ended << " ended";
    pair.reset();
  }
}

INSTANTIATE_TEST_SUITE_P(Placed, ServiceOverEveryTransport, testing::Values("pointer", "sharedmemory", "ipc", "tcp"),
                         TransportName);

}  // namespace
}  // namespace hgros::test
