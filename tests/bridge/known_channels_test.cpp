// A session lists channels that it neither publishes nor subscribes to.
#include <foxglove/Log.pb.h>
#include <foxglove/Vector3.pb.h>

#include "session/observed_fixture.hpp"

namespace hgros::known_channels_test {
namespace {

using foxglove::Vector3;
using test::Await;
using test::kSerial;

class KnownChannels : public test::ObservedFixture {};

TEST_P(KnownChannels, ListPublishersFromBeforeAndAfterTheSessionsConnect) {
  robot.emplace(PublisherYaml(), "robot");
  const auto before = robot->session->Advertise<Vector3>("before");
  observer.emplace(ObserverYaml(), "observer");
  Connect(*observer->session, *robot->session);
  ASSERT_TRUE(Await([&] { return IsPublished("before"); }));
  const auto after = robot->session->Advertise<foxglove::Log>("after");
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
}

TEST_P(KnownChannels, DoNotListASubscriberAsAPublisher) {
  Begin();
  const auto subscription = robot->session->FromAny<Vector3>("wanted", kSerial, [](const Vector3&) {});
  const auto publish = robot->session->Advertise<Vector3>("other");
  ASSERT_TRUE(Await([&] { return IsPublished("other"); }));
  if (GetParam() == "sharedmemory") {  // Over an endpoint, only the publisher of the channel learns of it.
    ASSERT_TRUE(Await([&] { return Known("wanted").has_value(); }));
    EXPECT_EQ(Known("wanted")->subscribers.at(0).process, "robot");
    EXPECT_EQ(Known("wanted")->type_name, "foxglove.Vector3");
  }
  EXPECT_FALSE(IsPublished("wanted"));
}

TEST_P(KnownChannels, ShowAPublisherItsSubscribers) {
  Begin();
  const auto publish = robot->session->Advertise<Vector3>("v");
  std::optional<Subscription> subscription =
      observer->session->FromAny<Vector3>("v", kSerial, [](const Vector3&) {}, {.queue = Queue::KeepAll(4)});
  const auto subscribers = [&] {
    for (const KnownChannel& channel : robot->session->Channels()) {
      if (channel.name == "v") return channel.subscribers;
    }
    return std::vector<ChannelUser>();
  };
  ASSERT_TRUE(Await([&] { return subscribers().size() == 1; }));
  EXPECT_EQ(subscribers()[0].session, observer->session->id());
  EXPECT_TRUE(subscribers()[0].lossless);
  subscription.reset();
  EXPECT_TRUE(Await([&] { return subscribers().empty(); }));
}

TEST_P(KnownChannels, ShowWhetherASubscriberIsLosslessNow) {
  Begin();
  const auto publish = robot->session->Advertise<Vector3>("v");
  const auto ignore = [](const Vector3&) {};
  const Subscription first = observer->session->FromAny<Vector3>("v", kSerial, ignore);
  const auto lossless = [&]() -> std::optional<bool> {
    for (const KnownChannel& channel : robot->session->Channels()) {
      if (channel.name == "v" && channel.subscribers.size() == 1) return channel.subscribers[0].lossless;
    }
    return std::nullopt;
  };
  ASSERT_TRUE(Await([&] { return lossless() == false; }));
  std::optional<Subscription> second =
      observer->session->FromAny<Vector3>("v", kSerial, ignore, {.queue = Queue::KeepAll(4)});
  if (GetParam() != "sharedmemory") return;  // Over an endpoint, the publisher learns this when they connect.
  EXPECT_TRUE(Await([&] { return lossless() == true; }));
  second.reset();
  EXPECT_TRUE(Await([&] { return lossless() == false; }));
}

TEST_P(KnownChannels, DisappearWithTheirSession) {
  Begin();
  std::optional<Publisher<Vector3>> publish = robot->session->Advertise<Vector3>("v");
  ASSERT_TRUE(Await([&] { return IsPublished("v"); }));
  publish.reset();
  robot.reset();
  EXPECT_TRUE(Await([&] { return !IsPublished("v"); }));
}

TEST_P(KnownChannels, ReportChanges) {
  Begin();
  std::atomic<int> told{0};
  const auto subscription = observer->session->FromGraph<ChannelsChanged>(kChannelEventsChannel, kSerial,
                                                                          [&](const ChannelsChanged&) { ++told; });
  ASSERT_FALSE(IsPublished("a"));  // From now on changes are reported.
  for (const char* name : {"a", "b", "c"}) {
    const int before = told;
    (void)robot->session->Advertise<Vector3>(name);
    ASSERT_TRUE(Await([&] { return told > before && IsPublished(name); }));
  }
}

TEST_P(KnownChannels, IncludeTheSessionsOwnChannels) {
  Begin();
  const auto publish = observer->session->Advertise<Vector3>("mine");
  const auto subscription = observer->session->FromAnyRaw("any", kSerial, [](const RawMessage&) {});
  ASSERT_TRUE(IsPublished("mine"));
  EXPECT_EQ(Known("mine")->publishers[0].session, observer->session->id());
  ASSERT_EQ(Known("any")->subscribers.size(), 1U);
  EXPECT_EQ(Known("any")->type_name, "");
}

INSTANTIATE_TEST_SUITE_P(Over, KnownChannels, testing::Values("sharedmemory", "ipc", "tcp"), test::TransportName);

TEST(KnownChannelsAlone, RefuseASubscriptionToTheirEventsWithAWrongType) {
  test::Robot robot("discovery: {local: false}\n");
  EXPECT_THROW((void)robot->FromGraph<PeerEvent>(kChannelEventsChannel, kSerial, [](const PeerEvent&) {}), Error);
}

TEST(KnownChannelsAlone, AreTheSessionsOwnChannels) {
  test::Robot robot("discovery: {local: false}\n");
  EXPECT_TRUE(robot->Channels().empty());
  (void)robot->Advertise<Vector3>("v");
  ASSERT_EQ(robot->Channels().size(), 1U);
  EXPECT_EQ(robot->Channels()[0].publishers.size(), 1U);
}

}  // namespace
}  // namespace hgros::known_channels_test
