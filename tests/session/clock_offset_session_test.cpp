// Sessions over tcp whose wall clocks differ, as those of two hosts do.
#include <cmath>

#include "hgros/clock/system_clocks.hpp"
#include "session/domain_fixture.hpp"

namespace hgros::test {
namespace {

using namespace std::chrono_literals;

const std::string kQuick = "heartbeat_ms: 5, peer_timeout_ms: 10000";

// A wall clock that is ahead of the real one by `ahead`, and by `drift` more each second.
struct Wall {
  Duration ahead{0};
  double drift = 0;
  std::int64_t since = MonotonicNow();

  [[nodiscard]] Time operator()() const { return WallNow() + Offset(); }
  [[nodiscard]] Duration Offset() const {
    return ahead + Duration(std::llround(static_cast<double>(MonotonicNow() - since) * drift));
  }
};

std::unique_ptr<Session> On(const Wall& wall, const std::string& yaml, const std::string& name) {
  return std::make_unique<Session>(
      Config::Parse(yaml),
      SessionOptions{.name = name, .log = [](LogLevel, std::string_view) {}, .wall = [wall] { return wall(); }});
}

std::unique_ptr<Session> Publishing(const Wall& wall) {
  return On(wall, "network: {publisher: {ip: 'tcp://127.0.0.1:*'}, " + kQuick + "}\ndiscovery: {local: false}",
            "publisher");
}
std::unique_ptr<Session> Subscribing(const Wall& wall, const Session& publisher) {
  return On(wall,
            "network: {subscribers: [{ip: '" + publisher.PublisherEndpoints().at(0) + "'}], " + kQuick +
                "}\ndiscovery: {local: false}",
            "subscriber");
}

// True if the estimated offset is right within its uncertainty; empty while there is no estimate.
std::optional<bool> Holds(const Session& session, const Session& peer, const Wall& own, const Wall& other) {
  const auto known = session.OffsetTo(peer.id());
  if (!known) return std::nullopt;
  const Duration error = known->offset - (other.Offset() - own.Offset());
  return std::chrono::abs(error) <=
         known->uncertainty + 1ms;  // 1 ms, because the test reads the clocks a little later.
}

class ClockOffsetOfSessions : public testing::TestWithParam<std::pair<Wall, Wall>> {};

TEST_P(ClockOffsetOfSessions, IsKnownOnBothSidesWithinItsUncertainty) {
  const auto& one = GetParam().first;
  const auto& other = GetParam().second;
  const auto publisher = Publishing(one);
  const auto subscriber = Subscribing(other, *publisher);
  ASSERT_TRUE(Await([&] { return Holds(*publisher, *subscriber, one, other).has_value(); }));
  ASSERT_TRUE(Await([&] { return Holds(*subscriber, *publisher, other, one).has_value(); }));
  int looks = 0;
  EXPECT_TRUE(Await([&] {
    EXPECT_EQ(Holds(*publisher, *subscriber, one, other), true);
    EXPECT_EQ(Holds(*subscriber, *publisher, other, one), true);
    return ++looks == 100;
  }));
  const auto there = publisher->OffsetTo(subscriber->id());
  const auto back = subscriber->OffsetTo(publisher->id());
  ASSERT_TRUE(there && back);
  EXPECT_LE(std::chrono::abs(there->offset + back->offset), there->uncertainty + back->uncertainty + 1ms);
  EXPECT_LT(there->uncertainty, 1s) << "an uncertainty of an hour would pass Holds(), too";
}

INSTANTIATE_TEST_SUITE_P(Skewed, ClockOffsetOfSessions,
                         testing::Values(std::pair{Wall{}, Wall{}}, std::pair{Wall{}, Wall{100s}},
                                         std::pair{Wall{}, Wall{-100s}}, std::pair{Wall{-1h}, Wall{1h}},
                                         std::pair{Wall{0s, 100e-6}, Wall{3s, -100e-6}},
                                         std::pair{Wall{24h, -200e-6}, Wall{0s, 200e-6}}));

TEST(ClockOffsetOfSessions, CorrectsLatenciesInStatistics) {
  for (const Duration ahead : {Duration(100s), Duration(-100s)}) {
    const Wall wall{ahead, 50e-6};
    const auto publisher = Publishing(wall);
    const auto subscriber = Subscribing({}, *publisher);
    std::atomic<int> got{0};
    const auto subscription =
        subscriber->FromAny<Note>("notes", Invoke::kSerial, [&](const Note&, const MessageInfo& info) {
          EXPECT_GT(std::chrono::abs(Duration(info.publish_time_ns - WallNow().nanoseconds)), 50s)
              << "the sender's stamp stays as it is";
          ++got;
        });
    const auto publish = publisher->Advertise<Note>("notes");
    ASSERT_TRUE(publisher->WaitForSubscribers("notes", 1, kPatience));
    ASSERT_TRUE(Await([&] { return subscriber->OffsetTo(publisher->id()).has_value(); }));
    for (int i = 1; i <= 10; ++i) {
      (void)publish(std::make_unique<Note>("x"));
      ASSERT_TRUE(Await([&] { return got == i; }));
    }
    const LogHistogram latency = subscriber->Snapshot().traffic.at(0).transport;
    ASSERT_EQ(latency.count(), 10U);
    EXPECT_LT(latency.max_ns(), Duration(50s).count());
  }
}

TEST(ClockOffsetOfSessions, IsUnknownForStrangersAndForPeersThatAreGone) {
  const auto publisher = Publishing({});
  auto subscriber = Subscribing(Wall{5s}, *publisher);
  EXPECT_EQ(publisher->OffsetTo(SessionId::Random()), std::nullopt);
  const SessionId id = subscriber->id();
  ASSERT_TRUE(Await([&] { return publisher->OffsetTo(id).has_value(); }));
  subscriber.reset();
  EXPECT_TRUE(Await([&] { return !publisher->OffsetTo(id).has_value(); }));
}

class ClockOffsetOnOneHost : public DomainFixture {};

TEST_F(ClockOffsetOnOneHost, IsZeroAtOnce) {
  Session one;
  Session other;
  const auto subscription = one.FromAny<Note>("notes", Invoke::kSerial, [](const Note&) {});
  const auto publish = other.Advertise<Note>("notes");
  ASSERT_TRUE(other.WaitForSubscribers("notes", 1, kPatience));
  const auto offset = one.OffsetTo(other.id());
  ASSERT_TRUE(offset);
  EXPECT_EQ(offset->offset, 0s);
  EXPECT_EQ(offset->uncertainty, 0s);
  EXPECT_TRUE(one.OffsetTo(one.id()));
}

}  // namespace
}  // namespace hgros::test
