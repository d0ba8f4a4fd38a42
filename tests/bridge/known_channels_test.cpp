// A session lists channels that it neither publishes nor subscribes to.
#include <foxglove/Log.pb.h>
#include <foxglove/Vector3.pb.h>

#include "bridge/stranger_channels.hpp"
#include "session/observed_fixture.hpp"

namespace hgros::test::known_channels_test {
namespace {

using foxglove::Vector3;

class KnownChannels : public ObservedFixture {};

TEST_P(KnownChannels, ListPublishersFromBeforeAndAfterTheSessionsConnectUntilTheirSessionEnds) {
  robot.emplace(PublisherYaml(), "robot");
  std::optional<Publisher<Vector3>> before = robot->session->Advertise<Vector3>("before");
  observer.emplace(ObserverYaml(), "observer");
  Connect(*observer->session, *robot->session);
  ASSERT_TRUE(Await([&] { return IsPublished("before"); }));
  std::optional<Publisher<foxglove::Log>> after = robot->session->Advertise<foxglove::Log>("after");
  ASSERT_TRUE(Await([&] { return IsPublished("after"); }));

  const KnownChannel known = *Known("before");
  EXPECT_EQ(known.type_name, "foxglove.Vector3");
  EXPECT_EQ(known.encoding, Encoding::kProtobuf);
  EXPECT_EQ(known.fingerprint, TypeOf<Vector3>().fingerprint);
  EXPECT_TRUE(known.subscribers.empty());
  ASSERT_EQ(known.publishers.size(), 1U);
  EXPECT_EQ(known.publishers[0].session, robot->session->id());
  EXPECT_EQ(known.publishers[0].process, "robot");
  EXPECT_EQ(known.publishers[0].pid, getpid());
  EXPECT_EQ(Known("after")->type_name, "foxglove.Log");
  before.reset();
  after.reset();
  robot.reset();
  EXPECT_TRUE(Await([&] { return !IsPublished("before"); }));
}

TEST_P(KnownChannels, IncludeTheSessionsOwnListNoSubscriberAsAPublisherAndReportChanges) {
  Begin();
  std::atomic<int> told{0};
  const auto events = observer->session->FromGraph<ChannelsChanged>(kChannelEventsChannel, kSerial,
                                                                    [&](const ChannelsChanged&) { ++told; });
  ASSERT_FALSE(IsPublished("a"));  // From now on changes are reported.
  for (const char* name : {"a", "b", "c"}) {
    const int before = told;
    (void)robot->session->Advertise<Vector3>(name);
    ASSERT_TRUE(Await([&] { return told > before && IsPublished(name); }));
  }

  const auto subscription = robot->session->FromAny<Vector3>("wanted", kSerial, [](const Vector3&) {});
  const auto publish = robot->session->Advertise<Vector3>("other");
  ASSERT_TRUE(Await([&] { return IsPublished("other"); }));
  if (GetParam() == "sharedmemory") {  // Over an endpoint, only the publisher of the channel learns of it.
    ASSERT_TRUE(Await([&] { return Known("wanted").has_value(); }));
    EXPECT_EQ(Known("wanted")->subscribers.at(0).process, "robot");
    EXPECT_EQ(Known("wanted")->type_name, "foxglove.Vector3");
  }
  EXPECT_FALSE(IsPublished("wanted"));

  const auto mine = observer->session->Advertise<Vector3>("mine");
  const auto any = observer->session->FromAnyRaw("any", kSerial, [](const RawMessage&) {});
  ASSERT_TRUE(IsPublished("mine"));
  EXPECT_EQ(Known("mine")->publishers[0].session, observer->session->id());
  ASSERT_EQ(Known("any")->subscribers.size(), 1U);
  EXPECT_EQ(Known("any")->type_name, "");
}

TEST_P(KnownChannels, ShowAPublisherItsSubscribersAndWhetherTheyAreLosslessNow) {
  Begin();
  const auto subscribers = [&](const std::string& name) {
    for (const KnownChannel& channel : robot->session->Channels()) {
      if (channel.name == name) return channel.subscribers;
    }
    return std::vector<ChannelUser>();
  };
  const auto await = [&](const std::string& name, bool lossless) {
    return Await([&] {
      const auto found = subscribers(name);
      return found.size() == 1 && found[0].lossless == lossless;
    });
  };
  const auto publish_v = robot->session->Advertise<Vector3>("v");
  const auto publish_w = robot->session->Advertise<Vector3>("w");
  const auto ignore = [](const Vector3&) {};
  const NodeOptions all{.queue = Queue::KeepAll(4)};
  std::optional<Subscription> subscription = observer->session->FromAny<Vector3>("v", kSerial, ignore, all);
  ASSERT_TRUE(await("v", true));
  EXPECT_EQ(subscribers("v")[0].session, observer->session->id());
  subscription.reset();
  EXPECT_TRUE(Await([&] { return subscribers("v").empty(); }));

  const Subscription first = observer->session->FromAny<Vector3>("w", kSerial, ignore);
  ASSERT_TRUE(await("w", false));
  if (GetParam() != "sharedmemory") return;  // Over an endpoint, the publisher learns this when they connect.
  subscription = observer->session->FromAny<Vector3>("w", kSerial, ignore, all);
  EXPECT_TRUE(await("w", true));
  subscription.reset();
  EXPECT_TRUE(await("w", false));
}

INSTANTIATE_TEST_SUITE_P(Over, KnownChannels, testing::Values("sharedmemory", "ipc", "tcp"), TransportName);

TEST(KnownChannelsAlone, AreTheSessionsOwnChannels) {
  Robot robot("discovery: {local: false}\n");
  EXPECT_TRUE(robot->Channels().empty());
  EXPECT_THROW((void)robot->FromGraph<PeerEvent>(kChannelEventsChannel, kSerial, [](const PeerEvent&) {}), Error);
  (void)robot->Advertise<Vector3>("v");
  ASSERT_EQ(robot->Channels().size(), 1U);
  EXPECT_EQ(robot->Channels()[0].publishers.size(), 1U);
}

using Uses = std::vector<std::pair<std::string, StrangerChannels::Use>>;

Uses Channels(SessionId session, std::size_t first, std::size_t count) {
  Uses uses;
  for (std::size_t i = first; i < first + count; ++i) {
    uses.emplace_back("channel" + std::to_string(i), StrangerChannels::Use{session, true, false, {}});
  }
  return uses;
}

TEST(StrangerChannels, FindTheSessionsOfOneChannelAmongManyWithoutTheOthers) {
  StrangerChannels strangers;
  for (std::uint64_t i = 1; i <= 4; ++i) strangers.Remember(SessionId{i}, Channels(SessionId{i}, 0, 12'000));
  strangers.Remember(SessionId{9}, Channels(SessionId{9}, 12'000, 1));
  EXPECT_EQ(strangers.UsesOf("channel7").size(), 4U);
  EXPECT_TRUE(strangers.UsesOf("another").empty());
  const auto last = strangers.UsesOf("channel12000");
  ASSERT_EQ(last.size(), 1U);
  EXPECT_EQ(last[0].session, SessionId{9});
}

TEST(StrangerChannels, ForgetWhatASessionNoLongerAnnounces) {
  StrangerChannels strangers;
  strangers.Remember(SessionId{1}, Channels(SessionId{1}, 0, 3));
  strangers.Remember(SessionId{2}, Channels(SessionId{2}, 0, 3));
  strangers.Remember(SessionId{1}, Channels(SessionId{1}, 2, 2));
  EXPECT_EQ(strangers.UsesOf("channel0").size(), 1U);
  EXPECT_EQ(strangers.UsesOf("channel2").size(), 2U);
  EXPECT_EQ(strangers.UsesOf("channel3").size(), 1U);
  strangers.Forget(SessionId{2});
  EXPECT_TRUE(strangers.UsesOf("channel0").empty());
  Uses twice = Channels(SessionId{3}, 5, 1);
  twice.push_back(twice.front());
  strangers.Remember(SessionId{3}, std::move(twice));
  strangers.Forget(SessionId{3});
  EXPECT_TRUE(strangers.UsesOf("channel5").empty());
}

}  // namespace
}  // namespace hgros::test::known_channels_test
