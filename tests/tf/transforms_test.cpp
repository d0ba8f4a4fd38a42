#include "hgros/tf/transforms.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <limits>

#include <foxglove/FrameTransforms.pb.h>

#include "hgros/clock/derived_clocks.hpp"
#include "hgros/session/clock_publisher.hpp"
#include "hgros/tf/default_transforms.hpp"
#include "hgros/tf/robot_description.hpp"
#include "session/domain_fixture.hpp"
#include "support/error_of.hpp"
#include "tf/tf_fixture.hpp"

namespace hgros::transforms_test {
namespace {

using namespace std::chrono_literals;
using test::Await;
using test::Difference;
using test::kPatience;
using test::Robot;
using test::Shift;

Time At(double seconds) { return Time{static_cast<std::int64_t>(seconds * 1e9)}; }

foxglove::FrameTransforms Message(const std::string& parent, const std::string& child, double w = 1,
                                  std::int64_t seconds = 1, std::int32_t nanos = 0) {
  foxglove::FrameTransforms message;
  auto& one = *message.add_transforms();
  one.set_parent_frame_id(parent);
  one.set_child_frame_id(child);
  one.mutable_timestamp()->set_seconds(seconds);
  one.mutable_timestamp()->set_nanos(nanos);
  one.mutable_rotation()->set_w(w);
  return message;
}

bool Listens(const Robot& robot, std::string_view channel) {
  for (const ChannelSnapshot& one : robot->Snapshot().graph.channels) {
    if (one.name == channel) return !one.nodes.empty();
  }
  return false;
}

// Two robots in a separate domain.
class TransformsOfTwo : public test::DomainFixture {
 protected:
  // Waits until `there` has received everything that was sent before.
  static bool Arrives(Transforms& there, const std::string& parent, const std::string& child, Time time) {
    TransformTree& tree = there.tree();
    return bool(tree.Wait({tree.Frame(parent), tree.Frame(child), time}, kPatience));
  }
  static bool Arrives(Transforms& there, const std::string& parent, const std::string& child) {
    TransformTree& tree = there.tree();
    return bool(tree.Wait({tree.Frame(parent), tree.Frame(child)}, kPatience));
  }
  // Publishes by hand in session a, when `looking`, of session b, listens.
  Publisher<foxglove::FrameTransforms> ToLooking(Transforms& looking) const {
    (void)looking.tree();
    auto publish = a->Advertise<foxglove::FrameTransforms>(kTransformsChannel);
    EXPECT_TRUE(a->WaitForSubscribers(kTransformsChannel, 1, kPatience));
    return publish;
  }

  Robot a{"", "a"};
  Robot b{"", "b"};
};

TEST_F(TransformsOfTwo, OneSessionLooksUpTransformsOfTheOther) {
  Transforms setting(*a.session);
  Transforms looking(*b.session);
  (void)looking.tree();
  EXPECT_TRUE(setting.ToTF(At(1), "map", "base", Shift(1)));
  ASSERT_TRUE(a->WaitForSubscribers(kTransformsChannel, 1, kPatience));
  EXPECT_TRUE(setting.ToTF(At(2), "map", "base", Shift(2).Isometry()));
  EXPECT_TRUE(setting.ToTF(At(3), "map", "base", Shift(3)));
  ASSERT_TRUE(Arrives(looking, "map", "base", At(3)));
  EXPECT_LT(Difference(looking.FromTF("map", "base")->T_target_source, Shift(3)), 1e-12);
  EXPECT_LT(Difference(looking.FromTF("map", "base", At(2.25))->T_target_source, Shift(2.25)), 1e-9);
  EXPECT_EQ(looking.tree().Edges().at(0).publisher, "a");
  EXPECT_EQ(looking.stats().refused_transforms, 0U);
}

TEST_F(TransformsOfTwo, LateSessionGetsAllStaticEdges) {
  Transforms setting(*a.session, {.batch = 0ns});
  EXPECT_TRUE(setting.ToStaticTF("base", "laser", Shift(1)));
  EXPECT_TRUE(setting.ToStaticTF("base", "camera", Shift(2)));
  EXPECT_TRUE(setting.ToStaticTF("base", "laser", Shift(3)));
  Transforms looking(*b.session);
  ASSERT_TRUE(Arrives(looking, "laser", "camera"));
  EXPECT_LT(Difference(looking.FromTF("base", "laser")->T_target_source, Shift(3)), 1e-12);
  EXPECT_EQ(looking.FromTF("base", "camera")->stamp, Time{});
  EXPECT_EQ(looking.stats().received_transforms, 2U) << "each edge once";
}

TEST_F(TransformsOfTwo, OnReceivedRunsAfterTreeIsUpdated) {
  std::mutex mutex;
  std::vector<double> found;
  TransformTree* tree = nullptr;
  const auto told = [&] {
    const std::scoped_lock lock(mutex);
    if (tree == nullptr) return;
    const TransformResult moving = tree->Lookup("map", "base");
    const TransformResult still = tree->Lookup("base", "laser");
    found.push_back(moving ? moving->T_target_source.translation.x() : 0);
    found.push_back(still ? still->T_target_source.translation.x() : 0);
  };
  Transforms setting(*a.session, {.batch = 0ns});
  Transforms looking(*b.session, {.on_received = told});
  {
    const std::scoped_lock lock(mutex);
    tree = &looking.tree();
  }
  const auto last = [&] {
    const std::scoped_lock lock(mutex);
    return found.size() < 2 ? std::pair(0.0, 0.0) : std::pair(found[found.size() - 2], found.back());
  };
  EXPECT_TRUE(setting.ToStaticTF("base", "laser", Shift(7)));
  EXPECT_TRUE(Await([&] { return last().second == Shift(7).translation.x(); }));
  ASSERT_TRUE(setting.ToTF(At(1), "map", "base", Shift(1)));
  ASSERT_TRUE(a->WaitForSubscribers(kTransformsChannel, 1, kPatience));
  for (int i = 2; i < 50; ++i) {
    ASSERT_TRUE(setting.ToTF(At(i), "map", "base", Shift(i)));
    ASSERT_TRUE(Await([&] { return last().first == Shift(i).translation.x(); })) << i;
  }
}

TEST_F(TransformsOfTwo, SubscribesAfterTheFirstLookupAndReceivesWhatItsOwnSessionPublishesByHand) {
  Transforms transforms(*a.session);
  EXPECT_TRUE(transforms.ToTF(At(1), "map", "base", Shift(1)));
  EXPECT_FALSE(Listens(a, kTransformsChannel));
  EXPECT_FALSE(Listens(a, kStaticTransformsChannel));
  EXPECT_TRUE(transforms.FromTF("map", "base")) << "its own transform is there at once";
  EXPECT_TRUE(Listens(a, kTransformsChannel));
  EXPECT_TRUE(Listens(a, kStaticTransformsChannel));
  EXPECT_EQ(a->ToAny(kTransformsChannel, Message("map", "hand")), PublishStatus::kOk);
  EXPECT_TRUE(Arrives(transforms, "map", "hand"));
  EXPECT_TRUE(transforms.ToTF(At(2), "map", "base", Shift(1)));
  ASSERT_TRUE(a->WaitIdle(kPatience));
  EXPECT_EQ(transforms.stats().received_transforms, 1U) << "its own transforms are not added twice";
}

TEST_F(TransformsOfTwo, SendsABurstInFewMessages) {
  constexpr int kCount = 200;
  Transforms setting(*a.session, {.batch = 20ms});
  Transforms looking(*b.session);
  (void)looking.tree();
  ASSERT_TRUE(setting.ToTF(At(0), "map", "base", Shift(0)));
  ASSERT_TRUE(a->WaitForSubscribers(kTransformsChannel, 1, kPatience));
  for (int i = 1; i <= kCount; ++i) ASSERT_TRUE(setting.ToTF(At(i * 0.001), "map", "base", Shift(i)));
  ASSERT_TRUE(Arrives(looking, "map", "base", At(kCount * 0.001)));
  EXPECT_LT(setting.stats().sent_messages, kCount / 4U);
  EXPECT_TRUE(Await([&] { return setting.stats().sent_transforms == kCount + 1U; }));
  EXPECT_TRUE(Await([&] { return looking.tree().Edges().at(0).transforms >= std::size_t{kCount}; }));
}

TEST_F(TransformsOfTwo, SendsABatchInOneMessageWithoutRefusedTransforms) {
  Transforms setting(*a.session, {.batch = 0ns});
  const std::vector<StampedEdge> edges = {{"map", "base", At(1), Shift(1)},
                                          {"base", "map", At(1), Shift(1)},
                                          {"base", "base", At(1), Shift(1)},
                                          {"base", "arm", At(1), Shift(2)}};
  const SetResult result = setting.ToTF(edges);
  EXPECT_EQ(result.fault(), SetFault::kCycle);
  EXPECT_THAT(result.text(), testing::HasSubstr("\"base\" to \"map\""));
  EXPECT_EQ(setting.stats().sent_messages, 1U);
  EXPECT_EQ(setting.stats().sent_transforms, 2U);
  EXPECT_TRUE(setting.FromTF("map", "arm"));
}

TEST_F(TransformsOfTwo, DestructorSendsWaitingTransforms) {
  Transforms looking(*b.session);
  (void)looking.tree();
  {
    Transforms setting(*a.session, {.batch = 1h});
    ASSERT_TRUE(setting.ToTF(At(1), "map", "base", Shift(1)));
    ASSERT_TRUE(a->WaitForSubscribers(kTransformsChannel, 1, kPatience));
    ASSERT_TRUE(setting.ToTF(At(2), "map", "base", Shift(2)));
    setting.Flush();
    EXPECT_TRUE(Arrives(looking, "map", "base", At(2)));
    ASSERT_TRUE(setting.ToTF(At(3), "map", "base", Shift(3)));
  }
  EXPECT_TRUE(Arrives(looking, "map", "base", At(3)));
}

TEST_F(TransformsOfTwo, SecondOneOfASessionIsRefused) {
  auto first = std::make_optional<Transforms>(*a.session);
  EXPECT_THAT(test::ErrorOf([this] { const Transforms second(*a.session); }),
              testing::HasSubstr("The session \"a\" has a Transforms already."));
  EXPECT_TRUE(first->ToStaticTF("base", "laser", Shift(1))) << "the first one is not affected";
  first.reset();
  Transforms next(*a.session);
  EXPECT_TRUE(next.ToStaticTF("base", "laser", Shift(1)));
}

TEST_F(TransformsOfTwo, StampsFarAheadOfTheClockAreRefusedAndTheEdgeKeepsWorking) {
  Transforms setting(*a.session);
  const SetResult refused = setting.ToTF(WallNow() + 1h, "map", "base", Shift(1));
  EXPECT_EQ(refused.fault(), SetFault::kTooNew);
  EXPECT_THAT(refused.text(), testing::HasSubstr("its stamp is 3600 s ahead of the clock of session \"a\""));

  Transforms looking(*b.session);
  const auto publish = ToLooking(looking);
  const std::int64_t now = WallNow().nanoseconds / 1'000'000'000;
  ASSERT_EQ(publish(Message("map", "base", 1, now + 3600)), PublishStatus::kOk);
  ASSERT_EQ(publish(Message("map", "base", 1, now)), PublishStatus::kOk);
  ASSERT_TRUE(Arrives(looking, "map", "base", At(static_cast<double>(now))));
  EXPECT_EQ(looking.stats().refused_transforms, 1U);
  EXPECT_TRUE(b.Said("more than max_ahead allows (10 s)"));
}

TEST_F(TransformsOfTwo, LimitForStampsAheadOfTheClockCanBeSet) {
  Transforms patient(*a.session, {.max_ahead = Duration::max()});
  EXPECT_TRUE(patient.ToTF(WallNow() + 24h, "map", "base", Shift(1)));
  const Robot simulated("time: simulated", "simulated");
  Transforms waiting(*simulated.session);
  EXPECT_TRUE(waiting.ToTF(At(5000), "map", "base", Shift(1))) << "no clock was heard so far";
}

TEST(TransformsOfAnotherHost, AreTakenIfItsClockIsKnownToBeAheadAndBeginAgainWhenItWasSetBack) {
  const std::string quick = "heartbeat_ms: 5, peer_timeout_ms: 10000}\ndiscovery: {local: false}";
  std::atomic<Duration> ahead{3600s};
  Session robot(Config::Parse("network: {publisher: {ip: 'tcp://127.0.0.1:*'}, " + quick),
                {.name = "robot", .log = [](LogLevel, std::string_view) {}, .wall = [&] { return WallNow() + ahead; }});
  Robot desk("network: {subscribers: [{ip: '" + robot.PublisherEndpoints().at(0) + "'}], " + quick, "desk");
  Transforms looking(*desk.session);
  const auto publish = robot.Advertise<foxglove::FrameTransforms>(kTransformsChannel);
  (void)looking.tree();
  ASSERT_TRUE(robot.WaitForSubscribers(kTransformsChannel, 1, kPatience));
  ASSERT_TRUE(Await([&] { return desk->OffsetTo(robot.id()).has_value(); }));
  const std::int64_t now = WallNow().nanoseconds / 1'000'000'000;
  const auto newest_is = [&](std::int64_t stamp) {
    const TransformResult found = looking.FromTF("map", "base");
    return found && found->stamp == Time{stamp * 1'000'000'000};
  };
  const auto refused_are = [&](std::size_t count) {
    return Await([&] { return looking.stats().refused_transforms == count; });
  };
  ASSERT_EQ(publish(Message("map", "base", 1, now + 3600)), PublishStatus::kOk);
  ASSERT_EQ(publish(Message("map", "base", 1, now + 7200)), PublishStatus::kOk);
  EXPECT_TRUE(refused_are(1)) << looking.stats().refused_transforms;
  EXPECT_TRUE(Await([&] { return looking.stats().received_transforms == 2; }));
  ASSERT_TRUE(newest_is(now + 3600)) << looking.FromTF("map", "base").text();
  ASSERT_EQ(publish(Message("map", "base", 1, now)), PublishStatus::kOk);
  ASSERT_TRUE(refused_are(2)) << "the clock may be right";
  ahead = Duration(0);
  ASSERT_TRUE(Await([&] {
    const auto known = desk->OffsetTo(robot.id());
    return known && known->offset + known->uncertainty < 60s;
  }));
  ASSERT_EQ(publish(Message("map", "base", 1, now + 1)), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return newest_is(now + 1); }));
  ASSERT_EQ(publish(Message("map", "base", 1, now + 2)), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return newest_is(now + 2); }));
  EXPECT_EQ(desk.Count("begins again"), 1U);
}

TEST_F(TransformsOfTwo, EdgesBeginAgainWhenARecordingIsPlayedTwiceAndItIsSaidOnce) {
  Transforms looking(*b.session);
  const auto publish = ToLooking(looking);
  ASSERT_EQ(publish(Message("map", "base", 1, 160)), PublishStatus::kOk);
  ASSERT_EQ(publish(Message("map", "arm", 1, 160)), PublishStatus::kOk);
  std::int32_t nanos = 0;
  EXPECT_TRUE(Await([&] {
    ++nanos;
    for (const char* child : {"base", "arm"}) (void)publish(Message("map", child, 1, 100, nanos));
    const TransformResult base = looking.FromTF("map", "base");
    const TransformResult arm = looking.FromTF("map", "arm");
    return base && base->stamp < At(101) && arm && arm->stamp < At(101);
  }));
  EXPECT_EQ(b.Count("jumped back"), 1U);
  EXPECT_TRUE(b.Said("\"a\" jumped back"));
}

TEST_F(TransformsOfTwo, ReportsAnEdgeOfTwoSessionsOnce) {
  Transforms one(*a.session);
  Transforms two(*b.session);
  (void)one.tree();
  (void)two.tree();
  ASSERT_TRUE(one.ToTF(At(1), "map", "one", Shift(1)));
  ASSERT_TRUE(two.ToTF(At(1), "map", "two", Shift(1)));
  for (Robot* robot : {&a, &b}) {  // The other one, and itself.
    ASSERT_TRUE((*robot)->WaitForSubscribers(kTransformsChannel, 2, kPatience));
  }
  // A lookup sees an edge a moment before its owner is noted.
  const auto handled = [](Robot& robot, Transforms& there, const std::string& child, double seconds) {
    return Arrives(there, "map", child, At(seconds)) && robot->WaitIdle(kPatience);
  };
  for (int i = 1; i <= 5; ++i) {
    ASSERT_TRUE(one.ToTF(At(2 * i), "map", "base", Shift(1)));
    ASSERT_TRUE(handled(b, two, "base", 2 * i));
    ASSERT_TRUE(two.ToTF(At(2 * i + 1), "map", "base", Shift(2)));
    ASSERT_TRUE(handled(a, one, "base", 2 * i + 1));
  }
  for (Robot* robot : {&a, &b}) {
    EXPECT_EQ(robot->Count("Two sessions set the edge from \"map\" to \"base\""), 1U);
  }
  EXPECT_EQ(one.stats().shared_edges, 1U);
  EXPECT_TRUE(a.Said(": a:" + std::to_string(getpid()) + " and b:" + std::to_string(getpid())) ||
              a.Said(": b:" + std::to_string(getpid()) + " and a:" + std::to_string(getpid())));

  // Many such edges, and many invalid ones, write few lines.
  constexpr int kMany = 100;
  std::vector<StampedEdge> many;
  for (int i = 0; i < kMany; ++i) many.push_back({"map", "many" + std::to_string(i), At(1), Shift(1)});
  for (int i = 1; i <= 3; ++i) {
    for (StampedEdge& edge : many) edge.stamp = At(2 * i);
    ASSERT_TRUE(one.ToTF(many));
    ASSERT_TRUE(handled(b, two, "many99", 2 * i));
    for (StampedEdge& edge : many) edge.stamp = At(2 * i + 1);
    ASSERT_TRUE(two.ToTF(many));
    ASSERT_TRUE(handled(a, one, "many99", 2 * i + 1));
  }
  EXPECT_EQ(one.stats().shared_edges, 1U + kMany);
  EXPECT_EQ(a.Count("Two sessions set the edge"), 10U);
}

TEST_F(TransformsOfTwo, EdgeTakenOverByAnotherSessionIsNotShared) {
  Transforms looking(*b.session);
  (void)looking.tree();
  {
    Robot before{"", "localizer"};
    Transforms setting(*before.session);
    ASSERT_TRUE(setting.ToTF(At(1), "map", "base", Shift(1)));
    ASSERT_TRUE(before->WaitForSubscribers(kTransformsChannel, 1, kPatience));
    ASSERT_TRUE(setting.ToTF(At(2), "map", "base", Shift(1)));
    ASSERT_TRUE(Arrives(looking, "map", "base", At(2)));
  }
  ASSERT_TRUE(Await([&] {  // Otherwise there are two sessions that set it.
    return std::ranges::none_of(b->Peers(), [](const PeerInfo& peer) { return peer.process == "localizer"; });
  }));
  Transforms setting(*a.session);
  ASSERT_TRUE(setting.ToTF(At(3), "map", "base", Shift(1)));
  ASSERT_TRUE(a->WaitForSubscribers(kTransformsChannel, 1, kPatience));
  ASSERT_TRUE(setting.ToTF(At(4), "map", "base", Shift(1)));
  ASSERT_TRUE(Arrives(looking, "map", "base", At(4)));
  EXPECT_EQ(looking.stats().shared_edges, 0U);
  EXPECT_EQ(looking.tree().Edges().at(0).publisher, "a");
}

TEST_F(TransformsOfTwo, RefusesCountsAndLogsInvalidTransforms) {
  Transforms looking(*b.session);
  const auto publish = ToLooking(looking);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const foxglove::FrameTransforms bad[] = {
      Message("map", "a", kNan), Message("map", "b", 0.5),          Message("", "c"),
      Message("map", "map"),     Message("map", "d", 1, INT64_MAX), Message("map", "e", 1, 1, -1)};
  for (const auto& message : bad) ASSERT_EQ(publish(message), PublishStatus::kOk);
  ASSERT_EQ(publish(Message("map", "base")), PublishStatus::kOk);
  ASSERT_TRUE(Arrives(looking, "map", "base", At(1)));
  EXPECT_EQ(looking.stats().received_transforms, 7U);
  EXPECT_EQ(looking.stats().refused_transforms, 6U);
  EXPECT_EQ(looking.tree().Edges().size(), 1U);
  EXPECT_TRUE(b.Said("A transform of session \"a\": The edge from \"map\" to \"d\" was refused"));
  EXPECT_EQ(b.Count("A transform of session"), 6U);
}

TEST_F(TransformsOfTwo, RefusesAFloodOfFramesAndLogsItOnce) {
  Transforms looking(*b.session, {.tree = {.max_frames = 10}});
  const auto publish = ToLooking(looking);
  foxglove::FrameTransforms flood;
  for (int i = 0; i < 100; ++i) flood.MergeFrom(Message("map", "flood" + std::to_string(i)));
  ASSERT_EQ(publish(flood), PublishStatus::kOk);
  ASSERT_EQ(publish(Message("map", "flood0", 1, 2)), PublishStatus::kOk);
  ASSERT_TRUE(Arrives(looking, "map", "flood0", At(2)));
  EXPECT_EQ(looking.stats().refused_transforms, 91U);
  EXPECT_EQ(looking.tree().Edges().size(), 9U);
  EXPECT_EQ(b.Count("A transform of session"), 1U);
  EXPECT_TRUE(b.Said("the tree has 10 frames"));
}

TEST_F(TransformsOfTwo, CallbackMaySetTransformsOnAnyExecutor) {
  Transforms transforms(*a.session, {.batch = 0ns});
  int rounds = 0;
  const auto answer = [&](const foxglove::FrameTransforms&) {
    if (++rounds < 5) {
      EXPECT_TRUE(transforms.ToTF(At(rounds), "map", "echo", Shift(rounds)));
    }
  };
  const Subscription echo =
      a->FromAny<foxglove::FrameTransforms>(kTransformsChannel, Invoke::kSerial, answer, test::Inline());
  EXPECT_TRUE(transforms.ToTF(At(1), "map", "base", Shift(1)));
  EXPECT_TRUE(Await([&] { return transforms.stats().sent_messages == 5; }));
}

TEST_F(TransformsOfTwo, DestructorEndsWhileASubscriberHasNoRoom) {
  test::Door door;
  std::atomic<int> taken{0};
  const auto hold = [&](const foxglove::FrameTransforms&) {
    ++taken;
    door.Pass();
  };
  const Subscription full = a->FromAny<foxglove::FrameTransforms>(
      kStaticTransformsChannel, Invoke::kSerial, hold, {.queue = Queue::KeepAll(1), .executor = Executor::Dedicated()});
  for (int life = 0; life < 20; ++life) {
    Transforms transforms(*a.session, {.batch = 0ns});
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(transforms.ToStaticTF("base", "s" + std::to_string(i), Shift(i)));
  }
  EXPECT_TRUE(Await([&] { return taken == 1; }));
  door.Open();
}

TEST_F(TransformsOfTwo, SendsARobotsJoints) {
  const auto robot = RobotDescription::FromText(R"(<robot name="arm">
    <link name="base"/><link name="mast"/><link name="head"/>
    <joint name="stand" type="fixed"><parent link="base"/><child link="mast"/><origin xyz="0 0 1"/></joint>
    <joint name="neck" type="continuous"><parent link="mast"/><child link="head"/><axis xyz="0 0 1"/></joint>
    </robot>)");
  Transforms setting(*a.session);
  Transforms looking(*b.session);
  (void)looking.tree();
  ASSERT_TRUE(setting.ToStaticTF(robot.FixedEdges()));
  const JointPosition neck{"neck", 0.5};
  ASSERT_TRUE(setting.ToTF(robot.EdgesAt(At(1), {&neck, 1})));
  ASSERT_TRUE(a->WaitForSubscribers(kTransformsChannel, 1, kPatience));
  ASSERT_TRUE(setting.ToTF(robot.EdgesAt(At(2), {&neck, 1})));
  ASSERT_TRUE(Arrives(looking, "base", "head", At(2)));
  EXPECT_LT(Difference(looking.FromTF("base", "head")->T_target_source, Shift(0, 0, 1) * test::TurnZ(0.5)), 1e-9);
}

TEST_F(TransformsOfTwo, RestartWhenTheSessionsClockJumpsBack) {
  const auto clock = SimulatedClock::Paused(At(100));
  Session player(Config::Parse(""), {.name = "player", .clock = clock});
  const Robot follower{"time: simulated", "follower"};
  const ClockPublisher publisher(player, clock);
  Transforms setting(player, {.batch = 0ns});
  Transforms looking(*follower.session);
  (void)looking.tree();
  ASSERT_TRUE(Await([&] { return follower->clock()->Now() == At(100); }));
  ASSERT_TRUE(setting.ToTF(At(100), "map", "base", Shift(1)));
  ASSERT_TRUE(player.WaitForSubscribers(kTransformsChannel, 1, kPatience));
  ASSERT_TRUE(setting.ToTF(At(101), "map", "base", Shift(1)));
  ASSERT_TRUE(Arrives(looking, "map", "base", At(101)));
  EXPECT_EQ(setting.ToTF(At(1), "map", "base", Shift(2)).fault(), SetFault::kTooOld);

  std::atomic<bool> jumped{false};
  const Listening after_them = follower->clock()->OnJump([&](const ClockJump&) { jumped = true; });
  clock->JumpTo(At(0));
  ASSERT_TRUE(Await([&] { return jumped.load(); }));
  const TransformTree& tree = looking.tree();
  std::atomic<bool> came{false};
  const auto pending = tree.WhenAvailable({*tree.Find("map"), *tree.Find("base"), At(0.5)},
                                          [&](const TransformResult& result) { came = bool(result); });
  ASSERT_TRUE(setting.ToTF(At(101.5), "map", "base", Shift(3))) << "it was in flight";
  for (const double stamp : {0.25, 0.75}) ASSERT_TRUE(setting.ToTF(At(stamp), "map", "base", Shift(stamp)));
  ASSERT_TRUE(Await([&] { return came.load(); }));
  for (Transforms* one : {&setting, &looking}) {
    EXPECT_LT(Difference(one->FromTF("map", "base", At(0.5))->T_target_source, Shift(0.5)), 1e-9);
    EXPECT_EQ(one->FromTF("map", "base")->stamp, At(0.75)) << "transforms from before the jump are still there";
  }
}

TEST_F(TransformsOfTwo, DestructorEndsWhileTheClockJumps) {
  const auto clock = SimulatedClock::Paused(At(100));
  Session session(Config::Parse(""), {.name = "robot", .clock = clock});
  std::jthread jumper([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      clock->JumpTo(At(100));
      clock->JumpTo(At(0));
    }
  });
  for (int life = 0; life < 200; ++life) {
    Transforms transforms(session, {.batch = 0ns, .max_ahead = Duration::max()});
    ASSERT_TRUE(transforms.ToTF(At(life), "map", "base", Shift(life)));
  }
}

// Callbacks of one session on two threads.
TEST_F(TransformsOfTwo, DestructorInACallbackWaitsForTransformsThatAreBeingReceived) {
  Session session(Config::Parse("data_graph: {threads: 4}"), {.name = "robot"});
  std::atomic<bool> receives{false};
  std::atomic<bool> go_on{false};
  std::atomic<bool> destroying{false};
  std::atomic<bool> received{false};
  bool waited = false;
  std::atomic<bool> destroyed{false};
  auto transforms = std::make_unique<Transforms>(session, TransformsOptions{.on_received = [&] {
                                                   receives = true;
                                                   EXPECT_TRUE(Await([&] { return go_on.load(); }));
                                                   received = true;
                                                 }});
  (void)transforms->tree();
  const auto subscription = session.FromGraph<int>("end", Invoke::kSerial, [&](const int&) {
    destroying = true;
    transforms.reset();
    waited = received;
    destroyed = true;
  });
  session.ToAny(kTransformsChannel, Message("map", "base"));
  ASSERT_TRUE(Await([&] { return receives.load(); }));
  session.ToGraph("end", std::make_unique<int>(1));
  ASSERT_TRUE(Await([&] { return destroying.load(); }));
  (void)Await([&] { return destroyed.load(); }, 50ms);  // Time for the fault.
  go_on = true;
  ASSERT_TRUE(Await([&] { return destroyed.load(); }));
  EXPECT_TRUE(waited);
}

TEST(DefaultTransforms, BelongToTheDefaultSession) {
  for (int life = 0; life < 2; ++life) {
    Init();
    EXPECT_FALSE(FromTF("map", "base")) << "transforms of an earlier session are still there";
    EXPECT_TRUE(ToTF(At(1), "map", "base", Shift(1)));
    EXPECT_TRUE(ToTF(At(2), "map", "base", Shift(3).Isometry()));
    EXPECT_LT(Difference(FromTF("map", "base")->T_target_source, Shift(3)), 1e-12);
    EXPECT_LT(Difference(FromTF("map", "base", At(1.5))->T_target_source, Shift(2)), 1e-9);
    Shutdown();
  }
  EXPECT_THROW((void)FromTF("map", "base"), Error);
}

}  // namespace
}  // namespace hgros::transforms_test
