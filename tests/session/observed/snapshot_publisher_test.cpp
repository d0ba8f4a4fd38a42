// Sessions publish their counters to each other.
#include "session/observed/snapshot_publisher.hpp"

#include <deque>
#include <map>

#include <foxglove/Vector3.pb.h>

#include "hgros/codec/dynamic_schema.hpp"
#include "hgros/session/snapshot_message.hpp"
#include "session/observed_fixture.hpp"
#include "support/error_of.hpp"

namespace hgros::test::snapshot_publisher_test {
namespace {

using foxglove::Vector3;

class SnapshotPublishers : public ObservedFixture {
 protected:
  SnapshotPublishers() { Begin(); }
  // The latest snapshot of a session that the observer received, and their number.
  struct Heard {
    Snapshot last;
    int times = 0;
  };

  [[nodiscard]] Subscription Listen() {
    return observer->session->FromAny<Snapshot>(kSnapshotsChannel, kSerial,
                                                [this](const Snapshot& snapshot, const MessageInfo& info) {
                                                  const std::scoped_lock lock(mutex_);
                                                  Heard& heard = heard_[info.id.publisher];
                                                  heard.last = snapshot;
                                                  ++heard.times;
                                                });
  }
  [[nodiscard]] Heard Of(const Session& session) {
    const std::scoped_lock lock(mutex_);
    return heard_[session.id().value];
  }
  [[nodiscard]] Snapshot::Channel ChannelOf(const Session& session, const std::string& name) {
    const Heard heard = Of(session);
    for (const Snapshot::Channel& channel : heard.last.channels()) {
      if (channel.name() == name) return channel;
    }
    return {};
  }

 private:
  std::mutex mutex_;
  std::map<std::uint64_t, Heard> heard_;
};

TEST_P(SnapshotPublishers, PublishCountersRepeatedlyAndToLateSubscribersWhileALosslessOneStandsStill) {
  Session& session = *robot->session;
  Robot stuck(ObserverYaml(), "stuck");
  Connect(*stuck.session, session);
  Door door;
  std::atomic<int> taken{0};
  const auto standing = stuck.session->FromAny<Snapshot>(kSnapshotsChannel, kSerial,
                                                         [&](const Snapshot&, const MessageInfo& info) {
                                                           if (info.id.publisher != session.id().value) return;
                                                           ++taken;
                                                           door.Pass();
                                                         },
                                                         {.queue = Queue::KeepAll(1)});
  const auto node = session.FromAny<Vector3>("v", kSerial, [](const Vector3&) {}, {.name = "eater"});
  const auto publish = session.Advertise<Vector3>("v");
  const auto outside = observer->session->FromAny<Vector3>("v", kSerial, [](const Vector3&) {});
  ASSERT_TRUE(session.WaitForSubscribers("v", 2, std::chrono::seconds(30)));
  ASSERT_TRUE(Await([&] { return taken == 1; }));
  std::optional<Subscription> listening = Listen();
  for (int i = 0; i < 5; ++i) ASSERT_EQ(publish(Vector3()), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] {
    const auto channel = ChannelOf(session, "v");
    return channel.published() == 5 && channel.sent() == 5 && channel.nodes_size() == 1 && channel.nodes(0).run() == 5;
  }));
  EXPECT_EQ(Of(session).last.process(), "robot");
  EXPECT_EQ(Of(session).last.session(), session.id().value);
  EXPECT_EQ(Of(session).last.pid(), getpid());
  EXPECT_GT(Of(session).last.steady_ns(), 0);
  EXPECT_EQ(ChannelOf(session, "v").type(), "foxglove.Vector3");
  EXPECT_EQ(ChannelOf(session, "v").nodes(0).name(), "eater");
  ASSERT_TRUE(Await([&] { return Of(session).times >= 2; }));
  listening.reset();
  ASSERT_EQ(publish(Vector3()), PublishStatus::kOk);
  listening = Listen();
  EXPECT_TRUE(Await([&] { return ChannelOf(session, "v").published() == 6; }));
  EXPECT_EQ(taken, 1);
  door.Open();
}

TEST_P(SnapshotPublishers, AreListedWithTheirSchemaAndKeepTheirChannelForThemselves) {
  const auto publish = robot->session->Advertise<Vector3>("v");
  ASSERT_TRUE(Await([&] { return IsPublished(std::string(kSnapshotsChannel)) && IsPublished("v"); }));
  const KnownChannel known = *Known(std::string(kSnapshotsChannel));
  EXPECT_EQ(known.type_name, TypeOf<Snapshot>().name);
  EXPECT_EQ(known.encoding, Encoding::kProtobuf);
  const auto schema = observer->session->AwaitSchema(kSnapshotsChannel, std::chrono::seconds(30));
  ASSERT_NE(schema, nullptr);
  std::string fault;
  EXPECT_NE(DynamicSchema::Build(*schema, fault), nullptr) << fault;
  const std::string refused = ErrorOf([&] { (void)robot->session->Advertise<Snapshot>(kSnapshotsChannel); });
  EXPECT_NE(refused.find("belongs to the library"), std::string::npos) << refused;
  EXPECT_THROW((void)robot->session->ToAny("hgros/call/add", Vector3()), Error);
}

// A publisher without transports; the test runs its errands.
class SnapshotPublisherAlone : public testing::Test {
 protected:
  void RunNext() {
    ASSERT_FALSE(errands_.empty());
    const auto errand = std::move(errands_.front().second);
    errands_.pop_front();
    errand();
  }

  int counted_ = 0;
  std::deque<std::pair<std::chrono::nanoseconds, std::function<void()>>> errands_;
  SnapshotPublisher publisher_{MessageId{1, 1, 0},
                               std::make_shared<Log>([](LogLevel, std::string_view) {}),
                               std::make_shared<HostClocks>(nullptr),
                               {[this] {
                                  ++counted_;
                                  return SessionSnapshot();
                                },
                                [this](std::chrono::nanoseconds delay, std::function<void()> errand) {
                                  errands_.emplace_back(delay, std::move(errand));
                                }}};
};

TEST_F(SnapshotPublisherAlone, CountsOncePerSecondAndOnlyWhileSubscribed) {
  EXPECT_TRUE(errands_.empty());
  ChannelOutlet& outlet = *publisher_.outlet();
  outlet.OnSubscribers(1);
  ASSERT_EQ(errands_.size(), 1U);
  EXPECT_EQ(errands_[0].first.count(), 0);
  outlet.OnSubscribers(2);
  EXPECT_EQ(errands_.size(), 1U) << "an errand is posted already";
  RunNext();
  EXPECT_EQ(counted_, 1);
  ASSERT_EQ(errands_.size(), 1U);
  EXPECT_EQ(errands_[0].first, std::chrono::seconds(1));
  RunNext();
  EXPECT_EQ(counted_, 2);
  outlet.OnSubscribers(0);
  RunNext();
  EXPECT_EQ(counted_, 2) << "there is no subscriber";
  EXPECT_TRUE(errands_.empty());
  outlet.OnSubscribers(1);
  EXPECT_EQ(errands_.size(), 1U) << "there is a subscriber again";
}

// A program that looks once must not wait for the next second.
TEST_F(SnapshotPublisherAlone, TellsEachNewSubscriberSoon) {
  ChannelOutlet& outlet = *publisher_.outlet();
  outlet.OnSubscribers(1);
  RunNext();
  ASSERT_EQ(errands_.size(), 1U) << "the next second is planned";
  outlet.OnSubscribers(2);
  ASSERT_EQ(errands_.size(), 2U);
  EXPECT_LE(errands_[1].first, std::chrono::milliseconds(500));
  errands_.pop_front();
  RunNext();
  EXPECT_EQ(counted_, 2);
  EXPECT_TRUE(errands_.empty()) << "the next second was planned before";
}

INSTANTIATE_TEST_SUITE_P(Over, SnapshotPublishers, testing::Values("sharedmemory", "ipc", "tcp"), TransportName);

TEST(SnapshotMessage, ContainsEveryCounterOfASession) {
  SessionSnapshot counted;
  counted.id = {7};
  counted.name = "robot";
  NodeSnapshot node;
  node.name = "n";
  node.invoke = Invoke::kConcurrent;
  node.queue = Queue::KeepLast(3);
  node.received = 10;
  node.dropped = 2;
  node.run = 8;
  node.failed = 1;
  node.queued = 4;
  node.queue_wait.Record(1000);
  node.run_time.Record(2000);
  node.ages.push_back({9, {}});
  node.ages[0].age.Record(5000);
  node.ages[0].age.Record(7000);
  counted.graph.channels.push_back(
      {.name = "a", .type = "T", .published = 11, .refused = 12, .received = 13, .nodes = {node}});
  counted.graph.channels.push_back({.name = "inside", .type = "U", .published = 1, .nodes = {}});
  ChannelTraffic traffic;
  traffic.channel = "a";
  traffic.encoded = 41;
  traffic.encoded_bytes = 4200;
  traffic.out = {.subscribers = 2, .sent = 21, .dropped = 22, .missed = 1};
  traffic.in = {{.publisher = {8}, .lost = 3}, {.publisher = {9}, .lost = 4}};
  traffic.faults[0] = 5;
  traffic.faults[1] = 6;
  traffic.transport.Record(3000);
  counted.traffic = {traffic};
  counted.services = {{"add", 31, 32}};

  const Snapshot told = ToMessage(counted);
  EXPECT_EQ(told.session(), 7U);
  EXPECT_EQ(told.process(), "robot");
  EXPECT_EQ(told.pid(), getpid());
  EXPECT_FALSE(told.host().empty());
  EXPECT_GT(told.time_ns(), 0);
  EXPECT_GT(told.steady_ns(), 0);
  ASSERT_EQ(told.channels_size(), 2);
  ASSERT_EQ(told.channels(0).nodes(0).ages_size(), 1);
  const Snapshot::ChainAge& ages = told.channels(0).nodes(0).ages(0);
  EXPECT_EQ(ages.origin(), 9U);
  EXPECT_EQ(ages.count(), 2U);
  EXPECT_GE(ages.p50_ns(), 5000);
  EXPECT_LE(ages.p50_ns(), 5625);
  EXPECT_EQ(ages.p99_ns(), 7000);
  EXPECT_EQ(ages.max_ns(), 7000);
  const Snapshot::Channel& a = told.channels(0);
  EXPECT_EQ(a.name(), "a");
  EXPECT_EQ(a.type(), "T");
  EXPECT_EQ(a.published(), 11U);
  EXPECT_EQ(a.refused(), 12U);
  EXPECT_EQ(a.received(), 13U);
  EXPECT_EQ(a.encoded(), 41U);
  EXPECT_EQ(a.encoded_bytes(), 4200U);
  EXPECT_EQ(a.sent(), 21U);
  EXPECT_EQ(a.subscribers(), 2U);
  EXPECT_EQ(a.send_dropped(), 23U);
  EXPECT_EQ(a.lost(), 7U);
  EXPECT_EQ(a.faults(), 11U);
  EXPECT_GE(a.transport_p50_ns(), 3000);
  ASSERT_EQ(a.nodes_size(), 1);
  EXPECT_EQ(a.nodes(0).name(), "n");
  EXPECT_FALSE(a.nodes(0).serial());
  EXPECT_FALSE(a.nodes(0).lossless());
  EXPECT_EQ(a.nodes(0).queue_depth(), 3U);
  EXPECT_EQ(a.nodes(0).received(), 10U);
  EXPECT_EQ(a.nodes(0).dropped(), 2U);
  EXPECT_EQ(a.nodes(0).run(), 8U);
  EXPECT_EQ(a.nodes(0).failed(), 1U);
  EXPECT_EQ(a.nodes(0).queued(), 4U);
  EXPECT_GE(a.nodes(0).wait_p50_ns(), 1000);
  EXPECT_GE(a.nodes(0).run_p99_ns(), 2000);
  EXPECT_EQ(told.channels(1).sent(), 0U) << "it has no transport";
  ASSERT_EQ(told.services_size(), 1);
  EXPECT_EQ(told.services(0).name(), "add");
  EXPECT_EQ(told.services(0).unhandled_requests(), 31U);
  EXPECT_EQ(told.services(0).dropped_replies(), 32U);
}

}  // namespace
}  // namespace hgros::test::snapshot_publisher_test
