// Services: no server, two servers, counters, callbacks and the free functions.
#include <random>
#include <set>

#include "services/services_fixture.hpp"
#include "support/seed.hpp"

namespace hgros::test {
namespace {

using namespace std::chrono_literals;

struct TimedOut {
  std::chrono::milliseconds time{0};
  unsigned calls = 0;  // Including earlier calls, which were not sent.
};

// Makes calls with growing timeouts until one times out while it waits for its reply.
std::optional<TimedOut> TimeOut(Session& caller, const char* service) {
  TimedOut made{1ms, 1};
  for (; made.time < kLong; made.time *= 4, ++made.calls) {
    const auto result = caller.Call<Sum, Total>(service, Sum{3, 3}, made.time).Wait();
    if (result.failure().kind == Kind::kTimedOut) return made;
    if (result.failure().kind != Kind::kNoServer) break;
  }
  return std::nullopt;
}

class Services : public DomainFixture {};

TEST_F(Services, PassPointersInsideASession) {
  Session session;
  const Note* seen = nullptr;
  std::shared_ptr<const Note> given;
  const Service service = session.Serve<Note, Note>("echo", [&](const Note& note) {
    seen = &note;
    given = std::make_shared<const Note>(note.text);
    return given;
  });
  const auto request = std::make_shared<const Note>("hello");
  Note::written = 0;
  const auto result = session.Call<Note, Note>("echo", request, kLong).Wait();
  ASSERT_TRUE(result);
  EXPECT_EQ(seen, request.get());
  EXPECT_EQ(result.reply(), given);
  EXPECT_EQ(Note::written, 0);
}

TEST_F(Services, FailWithoutAServerOnceDiscoveryIsComplete) {
  Robot other("");
  for (const bool isolated : {true, false}) {
    SCOPED_TRACE(isolated);
    Robot robot(isolated ? "discovery: {local: false}" : "");
    for (const bool first : {true, false}) {
      const auto result = robot->Call<Sum, Total>("add", Sum{}, kLong).Wait();
      EXPECT_EQ(result.failure().kind, Kind::kNoServer);
      if (isolated || !first) {
        EXPECT_EQ(result.failure().reason, "Nobody serves \"add\": discovery knows no session that does.");
      }
    }
  }
}

TEST_F(Services, WaitForTheTimeoutOfZeroOrMoreIfAnEndpointMayLeadToAServer) {
  Robot robot("network: {publisher: {ip: 'tcp://127.0.0.1:*'}}\ndiscovery: {local: false}");
  const auto result = robot->Call<Sum, Total>("add", Sum{}, std::chrono::milliseconds(30)).Wait();
  EXPECT_EQ(result.failure().kind, Kind::kNoServer);
  EXPECT_EQ(result.failure().reason, "No server of \"add\" was found within 30 ms.");
  const auto negative = robot->Call<Sum, Total>("add", Sum{}, std::chrono::nanoseconds::min()).Wait();
  EXPECT_EQ(negative.failure().reason, "No server of \"add\" was found within 0 us.");
}

TEST_F(Services, NameTheNearestServiceIfNobodyServesOne) {
  Robot alone("discovery: {local: false}");
  const Service own = alone->Serve<Sum, Total>("add_numbers", Add);
  const auto result = alone->Call<Sum, Total>("ad_numbers", Sum{}, kLong).Wait();
  EXPECT_TRUE(result.failure().reason.ends_with("Did you mean \"add_numbers\"?")) << result.failure().reason;

  Robot server("");
  const Service service = server->Serve<Sum, Total>("add", Add);
  Robot robot("network: {publisher: {ip: 'tcp://127.0.0.1:*'}}");
  ASSERT_TRUE((robot->Call<Sum, Total>("add", Sum{}, kLong).Wait()));
  // A server is reached before its place in the list of channels is known. The caller publishes the requests itself.
  ASSERT_TRUE(Await([&] {
    const auto is_served = [](const auto& one) { return one.name.ends_with("/add") && !one.subscribers.empty(); };
    return std::ranges::any_of(robot->Channels(), is_served);
  }));
  const auto late = robot->Call<Sum, Total>("/add", Sum{}, std::chrono::milliseconds(30)).Wait();
  EXPECT_EQ(late.failure().reason, "No server of \"/add\" was found within 30 ms. Did you mean \"add\"?");
}

TEST_F(Services, LogThatACallWaitsOnlyAfterItHasWaitedForSeconds) {
  Robot server("");
  const Service service = server->Serve<Sum, Total>("add", Add);
  Robot robot("network: {publisher: {ip: 'tcp://127.0.0.1:*'}}");
  EXPECT_FALSE((robot->Call<Sum, Total>("/add", Sum{}, std::chrono::milliseconds(3500)).Wait()));
  const auto begin = std::chrono::steady_clock::now();
  const auto second = robot->Call<Sum, Total>("/add", Sum{}, kLong);
  EXPECT_TRUE(Await([&] { return robot.Said("A call of service"); }));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(4900));
}

TEST_F(Services, RefuseASecondServerBadNamesAndAQueueThatDropsRequests) {
  Session session(Config::Parse("data_graph: {nodes: {drops: {queue: {keep_last: 4}}}}"));
  const Service first = session.Serve<Sum, Total>("add", Add);
  for (const std::string& name :
       {std::string("add"), std::string("a b"), std::string(180, 'x'), std::string("drops")}) {
    EXPECT_THROW((void)(session.Serve<Sum, Total>(name, Add)), Error) << name;
  }
  EXPECT_THROW((void)(session.Call<Sum, Total>("a b", Sum{}, kLong)), Error);
  EXPECT_TRUE((session.Call<Sum, Total>("add", Sum{}, kLong).Wait()));
}

TEST_F(Services, CountUnhandledRequestsAndDroppedReplies) {
  Pair pair(PlacesOf("sharedmemory"));
  Door door;
  std::atomic<int> begun{0};
  const Service other = pair.server().Serve<Sum, Total>("other", &Add);
  const Service service = pair.server().Serve<Sum, Total>("busy", [&](const Sum& sum) {
    ++begun;
    door.Pass();
    return Add(sum);
  });
  auto first = pair.caller().Call<Sum, Total>("busy", Sum{1, 1}, kLong);
  ASSERT_TRUE(Await([&] { return begun == 1; }));
  { const auto cancelled = pair.caller().Call<Sum, Total>("busy", Sum{2, 2}, kLong); }
  EXPECT_TRUE(TimeOut(pair.caller(), "busy"));
  pair.EndCaller();
  ASSERT_TRUE(Await([&] { return pair.server().Peers().empty(); }));
  door.Open();
  const auto counts = [&] { return pair.server().Snapshot().services; };
  EXPECT_TRUE(Await([&] { return counts().at(0).dropped_replies == 1; })) << "the reply to the first call";
  EXPECT_EQ(counts().at(0).name, "busy");
  EXPECT_LE(counts().at(0).unhandled_requests, 2U) << "a request that was withdrawn before it was sent is not counted";
  EXPECT_EQ(counts().at(1).name, "other");
  EXPECT_EQ(counts().at(1).unhandled_requests, 0U);
  EXPECT_EQ(begun, 1);
}

TEST_F(Services, NeverSendCallsThatFailWithNoServer) {
  Pair pair(PlacesOf("sharedmemory"));
  std::mt19937 random(7);
  for (int round = 0; round < test::Rounds(5, 20); ++round) {
    const std::string name = "add" + std::to_string(round);
    std::mutex mutex;
    std::set<int> handled;
    std::optional<Service> service;
    std::jthread serve([&] {
      service.emplace(pair.server().Serve<Sum, Total>(name, [&](const Sum& sum) {
        const std::scoped_lock lock(mutex);
        handled.insert(sum.a);
        return Add(sum);
      }));
    });
    std::set<int> unsent;
    std::vector<CallFuture<Total>> calls;
    int number = 0;
    const auto settle = [&] {
      for (const auto& call : calls) {
        const auto& result = call.Wait();
        if (!result && result.failure().kind == Kind::kNoServer) unsent.insert(number);
        ++number;
      }
      calls.clear();
    };
    while (number < 400) {
      for (int i = 0; i < 20; ++i) {
        const std::chrono::microseconds time(random() % 1000);
        calls.push_back(pair.caller().Call<Sum, Total>(name, Sum{number + i, 1}, time));
      }
      settle();
    }
    serve.join();
    // When this call succeeds, all earlier calls of this caller have arrived.
    ASSERT_TRUE(Await([&] { return bool(pair.caller().Call<Sum, Total>(name, Sum{-1, 1}, kLong).Wait()); }));
    const std::scoped_lock lock(mutex);
    for (const int one : unsent) EXPECT_FALSE(handled.contains(one)) << "call " << one << " of round " << round;
  }
}

TEST_F(Services, RunCallbacksOnWorkersWhicheverThreadReadsTheReply) {
  Pair pair(PlacesOf("sharedmemory"));
  const Service service =
      pair.server().Serve<Sum, Total>("add", Add, Invoke::kConcurrent, {.executor = Executor::Inline()});
  ASSERT_TRUE(Await([&] { return bool(pair.caller().Call<Sum, Total>("add", Sum{1, 1}, kLong).Wait()); }));
  const auto waiting = std::this_thread::get_id();
  std::atomic<int> called{0};
  std::atomic<int> called_here{0};
  std::atomic<int> nested{0};
  constexpr int kRounds = 300;
  for (int round = 0; round < kRounds; ++round) {
    pair.caller().Call<Sum, Total>("add", Sum{1, 1}, kLong, [&](const CallResult<Total>&) {
      if (std::this_thread::get_id() == waiting) ++called_here;
      if (pair.caller().Call<Sum, Total>("add", Sum{2, 2}, kLong).Wait()) ++nested;
      ++called;
    });
    const auto reply = pair.caller().Call<Sum, Total>("add", Sum{3, 3}, kLong).Wait();
    ASSERT_TRUE(reply) << reply.failure().reason;
  }
  EXPECT_TRUE(Await([&] { return called == kRounds; }));
  EXPECT_EQ(called_here, 0);
  EXPECT_EQ(nested, kRounds);
}

TEST_F(Services, CountRequestsThatTimedOutBeforeTheirTurn) {
  const Robot robot("");
  Door door;
  std::atomic<bool> begun{false};
  const auto handle = [&](const Sum& sum) {
    begun = true;
    door.Pass();
    return Add(sum);
  };
  const Service service = robot->Serve<Sum, Total>("busy", handle, Invoke::kSerial, {.queue = Queue::KeepAll(1)});
  const auto first = robot->Call<Sum, Total>("busy", Sum{1, 1}, kLong);
  ASSERT_TRUE(Await([&] { return begun.load(); }));
  const auto late = TimeOut(*robot.session, "busy");
  ASSERT_TRUE(late);
  // The server counts the timeout from the arrival of the request. kFull shows that it has arrived.
  EXPECT_EQ((robot->Call<Sum, Total>("busy", Sum{2, 2}, kLong).Wait().failure().kind), Kind::kFull);
  Linger(2 * late->time);
  door.Open();
  EXPECT_TRUE(first.Wait());
  EXPECT_TRUE(Await([&] { return robot->Snapshot().services.at(0).unhandled_requests == 1; }));
}

TEST_F(Services, AcceptCallsThatAreMadeWhileTheyStart) {
  for (int round = 0; round < test::Rounds(5, 20); ++round) {
    const Places places = PlacesOf("ipc");  // Over an endpoint a call waits for a server until its timeout.
    const Robot robot(places.first);
    std::atomic<int> replies{0};
    std::vector<std::jthread> callers;
    for (int i = 0; i < 3; ++i) {
      callers.emplace_back([&] {
        const auto result = robot->Call<Sum, Total>("add", Sum{2, 3}, kLong).Wait();
        EXPECT_TRUE(result) << result.failure().reason;
        if (result && result->value == 5) ++replies;
      });
    }
    const Service service = robot->Serve<Sum, Total>("add", Add);
    callers.clear();
    EXPECT_EQ(replies, 3);
  }
}

TEST_F(Services, LogOnceThatACallWaitsForAServerAndReportTwoServersAndCallTheFirst) {
  Robot server("");
  const Service add = server->Serve<Sum, Total>("add", Add);
  Robot robot("network: {publisher: {ip: 'tcp://127.0.0.1:*'}}");
  const auto waiting = robot->Call<Sum, Total>("/add", Sum{}, kLong);
  const auto waiting_too = robot->Call<Sum, Total>("/add", Sum{}, kLong);
  // Two servers are reported after this timeout. A busy machine may keep a session silent for a while.
  const std::string soon = "network: {heartbeat_ms: 100, peer_timeout_ms: 2000}";
  Robot caller(soon, "caller");
  std::atomic<int> events{0};
  const auto listening = caller->FromGraph<PeerEvent>(kPeerEventsChannel, Invoke::kSerial, [&](const PeerEvent& event) {
    if (event.kind == PeerEvent::Kind::kServedTwice && event.channel == "hgros/call/who") ++events;
  });
  Robot first(soon, "first");
  Robot second(soon, "second");
  std::atomic<int> calls{0};
  const auto handler = [&](const char* name) {
    return [&calls, name](const Note&) {
      ++calls;
      return Note(name);
    };
  };
  std::optional<Service> one = first->Serve<Note, Note>("who", handler("first"));
  ASSERT_EQ((caller->Call<Note, Note>("who", Note(), kLong).Wait()->text), "first");
  const Service two = second->Serve<Note, Note>("who", handler("second"));
  EXPECT_TRUE(Await([&] { return caller.Said("Service \"who\" is served by more than one") && events == 1; }));
  EXPECT_TRUE(
      Await([&] { return first.Said("is served here and by session") && second.Said("is served here and by"); }));
  calls = 0;
  for (int i = 0; i < 20; ++i) EXPECT_EQ((caller->Call<Note, Note>("who", Note(), kLong).Wait()->text), "first");
  EXPECT_EQ(calls, 20);
  one.reset();
  EXPECT_TRUE(Await([&] {
    const auto result = caller->Call<Note, Note>("who", Note(), kLong).Wait();
    return result && result->text == "second";
  }));
  EXPECT_TRUE(Await([&] {
    return robot.Said("A call of service \"/add\" waits: no session that is reached serves it. Did you mean \"add\"?");
  }));
  Linger(std::chrono::milliseconds(200));
  EXPECT_EQ(robot.Count("A call of service"), 1U);
}

// As in moves, one right after the other.
TEST_F(Services, AreNotServedTwiceIfAServerFollowsAnother) {
  Robot first("", "first");
  Robot second("", "second");
  for (int round = 0; round < 20; ++round) {
    Service one = first->Serve<Sum, Total>("add", Add);
    const Service two = second->Serve<Sum, Total>("add", Add);
    Linger(10ms);
    one.Reset();
    Linger(10ms);
  }
  Linger(700ms);
  EXPECT_FALSE(first.Said("is served here and by"));
  EXPECT_FALSE(second.Said("is served here and by"));
}

TEST_F(Services, PassAnEndpointThatListsTheirRequestChannel) {
  const Bus bus;
  const std::string list = "hgros/call/add";
  const auto yaml = [&](const std::string& own, const std::string& other) {
    return "network: {" + bus.Publisher(own, list) + ", subscribers: [" + bus.Subscriber(other, list) +
           "]}\ndiscovery: {local: false}\n";
  };
  Robot server(yaml("a", "b"));
  Robot caller(yaml("b", "a"));
  const Service add = server->Serve<Sum, Total>("add", Add);
  const Service other = server->Serve<Sum, Total>("other", Add);
  EXPECT_EQ((caller->Call<Sum, Total>("add", Sum{1, 2}, kLong).Wait()->value), 3);
  const auto kept = caller->Call<Sum, Total>("other", Sum{}, std::chrono::milliseconds(50)).Wait();
  EXPECT_EQ(kept.failure().kind, Kind::kNoServer);
}

TEST_F(Services, AreServedAndCalledThroughFreeFunctions) {
  Init(Config::Parse("discovery: {local: false}"));
  Serve<Sum, Total>("add", Add);
  EXPECT_EQ((Call<Sum, Total>("add", Sum{1, 2}, kLong).Wait()->value), 3);
  std::atomic<int> sum{0};
  Call<Sum, Total>("add", Sum{2, 2}, kLong, [&](const CallResult<Total>& result) { sum = result->value; });
  EXPECT_TRUE(Await([&] { return sum == 4; }));
  Shutdown();
}

}  // namespace
}  // namespace hgros::test
