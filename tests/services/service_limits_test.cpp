// What waits for a slow server, or for a caller that takes no replies, is limited and told.
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "hgros/codec/block.hpp"
#include "services/services_fixture.hpp"

namespace hgros::test {
namespace {

constexpr std::size_t kMega = 1U << 20;

std::uint64_t RequestsAt(Session& server, const std::string& service) {
  std::uint64_t received = 0;
  for (const ChannelTraffic& one : server.Snapshot().traffic) {
    if (one.channel != "hgros/call/" + service) continue;
    for (const PublisherTraffic& publisher : one.in) received += publisher.received;
  }
  return received;
}

class WaitingRequests : public DomainFixture, public testing::WithParamInterface<std::string> {
 protected:
  /// Handles one block when the door opens.
  Service ServeSlowly(Session& server) {
    return server.Serve<Block, Total>("slow", [this](const Block& block) {
      ++handled;
      door.Pass();
      return Total{static_cast<int>(block.size())};
    });
  }
  Door door;
  std::atomic<int> handled{0};
};

TEST_P(WaitingRequests, StayAtTheCallerAboveTheWindow) {
  Pair pair(PlacesOf(GetParam()), "shared_memory: {limit_bytes: 1GiB}\n", "shared_memory: {limit_bytes: 1GiB}\n");
  const Service service = ServeSlowly(pair.server());
  constexpr int kCalls = 75;
  const auto call = [&] { return pair.caller().Call<Block, Total>("slow", Block::Allocate(kMega), kLong); };
  std::vector<CallFuture<Total>> calls;
  calls.push_back(call());
  ASSERT_TRUE(Await([&] { return handled == 1; }));
  for (int i = 1; i < kCalls; ++i) calls.push_back(call());
  ASSERT_TRUE(Await([&] { return RequestsAt(pair.server(), "slow") >= 60; }));
  const auto late = pair.caller().Call<Block, Total>("slow", Block::Allocate(kMega), std::chrono::milliseconds(300));
  const auto result = late.Wait();
  EXPECT_EQ(result.failure().kind, Kind::kFull);
  EXPECT_EQ(result.failure().reason, "The server of \"slow\" has taken no more requests within 300 ms: too many wait.");
  EXPECT_LE(RequestsAt(pair.server(), "slow"), 66U) << "64 MiB wait, one is handled";
  door.Open();
  for (const auto& one : calls) {
    const auto reply = one.Wait();
    ASSERT_TRUE(reply) << reply.failure().reason;
    EXPECT_EQ(reply->value, static_cast<int>(kMega));
  }
}

TEST_P(WaitingRequests, FailWithFullWhenTheServerHadLittleMemory) {
  Pair pair(PlacesOf(GetParam()));
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &limit), 0);
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlimit small{pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + 160 * kMega, limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_AS, &small), 0);
  const Service service = ServeSlowly(pair.server());
  ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
  std::vector<CallFuture<Total>> calls;
  for (int i = 0; i < 60; ++i) {
    calls.push_back(pair.caller().Call<Block, Total>("slow", Block::Allocate(kMega), kLong));
    ASSERT_TRUE(Await([&] { return handled == 1; }));
  }
  ASSERT_TRUE(Await([&] { return RequestsAt(pair.server(), "slow") == 60; }));
  door.Open();
  int full = 0;
  for (const auto& one : calls) {
    const auto result = one.Wait();
    if (result) continue;
    ++full;
    EXPECT_EQ(result.failure().kind, Kind::kFull) << result.failure().reason;
    EXPECT_TRUE(result.failure().reason.ends_with(" MiB of requests waiting already.")) << result.failure().reason;
  }
  EXPECT_GE(full, 15) << "two eighths of the free memory may wait";
  EXPECT_LT(full, 58);
}

// The first request is larger than the window, so no other one may come while it counts as on its way.
TEST_P(WaitingRequests, LeaveRoomForCallsOfTheirOwnHandlers) {
  Pair pair(PlacesOf(GetParam()), "shared_memory: {limit_bytes: 1GiB}\n", "shared_memory: {limit_bytes: 1GiB}\n");
  constexpr std::size_t kFirst = 65 * kMega;
  const auto call_back = [&](const Block& block) {
    if (block.size() != kFirst) return Total{5};
    const auto result = pair.server().Call<Sum, Total>("back", Sum{}, kLong).Wait();
    return result ? *result : Total{-1};
  };
  const Service there = pair.server().Serve<Block, Total>("there", call_back, Invoke::kConcurrent);
  const Service back = pair.caller().Serve<Sum, Total>("back", [&](const Sum&) {
    const auto result =
        pair.caller().Call<Block, Total>("there", Block::Allocate(kMega), std::chrono::seconds(15)).Wait();
    return result ? *result : Total{-2};
  });
  const auto result = pair.caller().Call<Block, Total>("there", Block::Allocate(kFirst), kLong).Wait();
  ASSERT_TRUE(result) << result.failure().reason;
  EXPECT_EQ(result->value, 5);
}

INSTANTIATE_TEST_SUITE_P(Over, WaitingRequests, testing::Values("sharedmemory", "tcp"), TransportName);

/// A server and a caller that reach each other only over ipc, with lists of channels.
class MissingDirection : public DomainFixture {
 protected:
  static constexpr auto kAlone = "discovery: {local: false}\n";
  Bus bus;
  [[nodiscard]] std::string Lists(const std::string& own, const std::string& out, const std::string& other,
                                  const std::string& in) const {
    return "network: {" + bus.Publisher(own, out) + ", subscribers: [" + bus.Subscriber(other, in) + "]}\n" + kAlone;
  }
  /// Waits until the server has reached the caller's endpoint. So a call is sent at once.
  [[nodiscard]] static bool IsReached(Robot& caller) {
    return Await([&] {
      return std::ranges::any_of(caller->Channels(), [](const KnownChannel& one) {
        return one.name == "hgros/call/add" && !one.subscribers.empty();
      });
    });
  }
};

TEST_F(MissingDirection, IsToldAndKeepsNoReplies) {
  Robot server(Lists("a", "scan", "b", ""), "server");
  Robot caller(Lists("b", "", "a", ""), "caller");
  Robot other_server(Lists("c", "", "d", ""), "server");
  Robot other_caller(Lists("d", "", "c", "scan"), "caller");
  const Service service = server->Serve<Sum, Total>("add", Add);
  const Service other = other_server->Serve<Sum, Total>("add", Add);
  ASSERT_TRUE(IsReached(caller) && IsReached(other_caller));
  const auto out_of_the_server = caller->Call<Sum, Total>("add", Sum{2, 3}, std::chrono::seconds(2));
  const auto into_the_caller = other_caller->Call<Sum, Total>("add", Sum{2, 3}, std::chrono::seconds(2));
  EXPECT_EQ(out_of_the_server.Wait().failure().kind, Kind::kTimedOut);
  EXPECT_EQ(out_of_the_server.Wait().failure().reason,
            "Service \"add\" did not reply within 2000 ms. Nobody offers its replies here. If the server runs, check "
            "that a subscriber endpoint here reaches its publisher endpoint, and that \"hgros/call/add\" is in their "
            "lists of channels.");
  EXPECT_TRUE(Await([&] { return server->Snapshot().services.at(0).dropped_replies == 1; }));
  EXPECT_EQ(server.Count("A reply of service \"add\" to session "), 1U);
  EXPECT_TRUE(
      server.Said("Replies cannot leave this session: no publisher endpoint has \"hgros/call/add\" in its list "
                  "of channels. Add it."));
  EXPECT_EQ(into_the_caller.Wait().failure().reason,
            "Service \"add\" did not reply within 2000 ms. Replies cannot reach this session: no subscriber endpoint "
            "has \"hgros/call/add\" in its list of channels. Add it.");
  EXPECT_TRUE(Await([&] { return other_server.Said("That session does not subscribe to its replies: "); }));
}

TEST_F(MissingDirection, DropsTheReplyOfACancelledCall) {
  Robot server(Lists("a", "scan", "b", ""), "server");
  Robot caller(Lists("b", "", "a", ""), "caller");
  std::atomic<int> handled{0};
  const Service service = server->Serve<Sum, Total>("add", [&](const Sum& sum) {
    ++handled;
    return Add(sum);
  });
  auto call = caller->Call<Sum, Total>("add", Sum{2, 3}, std::chrono::nanoseconds::max());
  ASSERT_TRUE(Await([&] { return handled == 1; }));
  server->WaitIdle(kLong);
  EXPECT_EQ(server->Snapshot().services.at(0).dropped_replies, 0U);
  call.Cancel();
  EXPECT_TRUE(Await([&] { return server->Snapshot().services.at(0).dropped_replies == 1; }));
}

}  // namespace
}  // namespace hgros::test
