// Sessions publish their counters to each other.
#include "session/observed/snapshot_publisher.hpp"

#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <utility>

#include <foxglove/Vector3.pb.h>

#include "hgros/codec/dynamic_schema.hpp"
#include "hgros/session/snapshot_message.hpp"
#include "session/observed_fixture.hpp"

namespace hgros::snapshot_publisher_test {
namespace {

using foxglove::Vector3;
using test::Await;
using test::kSerial;

class SnapshotPublishers : public test::ObservedFixture {
 protected:
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

TEST_P(SnapshotPublishers, PublishCountersOfChannelsAndNodes) {
  Begin();
  Session& session = *robot->session;
  const auto node = session.FromAny<Vector3>("v", kSerial, [](const Vector3&) {}, {.name = "eater"});
  const auto publish = session.Advertise<Vector3>("v");
  const auto outside = observer->session->FromAny<Vector3>("v", kSerial, [](const Vector3&) {});
  ASSERT_TRUE(session.WaitForSubscribers("v", 2, std::chrono::seconds(30)));
  const auto listening = Listen();
  for (int i = 0; i < 5; ++i) ASSERT_EQ(publish(Vector3()), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] {
    const auto channel = ChannelOf(session, "v");
    return channel.published() == 5 && channel.sent() == 5 && channel.nodes_size() == 1 && channel.nodes(0).run() == 5;
  }));
  EXPECT_EQ(Of(session).last.process(), "robot");
  EXPECT_EQ(Of(session).last.session(), session.id().value);
  EXPECT_EQ(Of(session).last.pid(), getpid());
  EXPECT_EQ(ChannelOf(session, "v").type(), "foxglove.Vector3");
  EXPECT_EQ(ChannelOf(session, "v").nodes(0).name(), "eater");
}

TEST_P(SnapshotPublishers, PublishRepeatedlyAndToLateSubscribers) {
  Begin();
  const auto publish = robot->session->Advertise<Vector3>("v");
  {
    const auto listening = Listen();
    ASSERT_TRUE(Await([&] { return Of(*robot->session).times >= 2; }));
  }
  EXPECT_GT(Of(*robot->session).last.steady_ns(), 0);
  ASSERT_EQ(publish(Vector3()), PublishStatus::kOk);
  const auto again = Listen();
  EXPECT_TRUE(Await([&] { return ChannelOf(*robot->session, "v").published() == 1; }));
}

TEST_P(SnapshotPublishers, ReachOthersWhileALosslessSubscriberStandsStill) {
  Begin();
  const auto publish = robot->session->Advertise<Vector3>("v");  // So that other sessions find it.
  test::Robot stuck(ObserverYaml(), "stuck");
  Connect(*stuck.session, *robot->session);
  test::Door door;
  std::atomic<int> taken{0};
  const auto standing = stuck.session->FromAny<Snapshot>(kSnapshotsChannel, kSerial,
                                                         [&](const Snapshot&, const MessageInfo& info) {
                                                           if (info.id.publisher != robot->session->id().value) return;
                                                           ++taken;
                                                           door.Pass();
                                                         },
                                                         {.queue = Queue::KeepAll(1)});
  ASSERT_TRUE(Await([&] { return taken == 1; }));
  const auto listening = Listen();
  EXPECT_TRUE(Await([&] { return Of(*robot->session).times >= 2; }));
  EXPECT_EQ(taken, 1);
  door.Open();
}

TEST_P(SnapshotPublishers, AreListedAmongTheKnownChannels) {
  Begin();
  const auto publish = robot->session->Advertise<Vector3>("v");
  ASSERT_TRUE(Await([&] { return IsPublished(std::string(kSnapshotsChannel)) && IsPublished("v"); }));
  const KnownChannel known = *Known(std::string(kSnapshotsChannel));
  EXPECT_EQ(known.type_name, TypeOf<Snapshot>().name);
  EXPECT_EQ(known.encoding, Encoding::kProtobuf);
}

TEST_P(SnapshotPublishers, SendTheirSchemaToSubscribersWithoutTheClass) {
  Begin();
  const auto publish = robot->session->Advertise<Vector3>("v");
  const auto schema = observer->session->AwaitSchema(kSnapshotsChannel, std::chrono::seconds(30));
  ASSERT_NE(schema, nullptr);
  std::string fault;
  EXPECT_NE(DynamicSchema::Build(*schema, fault), nullptr) << fault;
}

TEST_P(SnapshotPublishers, KeepProgramsFromPublishingOnTheirChannel) {
  Begin();
  try {
    (void)robot->session->Advertise<Snapshot>(kSnapshotsChannel);
    FAIL() << "a program could publish on the session's channel";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("belongs to the library"), std::string::npos) << error.what();
  }
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

INSTANTIATE_TEST_SUITE_P(Over, SnapshotPublishers, testing::Values("sharedmemory", "ipc", "tcp"),
                         [](const auto& over) { return over.param; });

}  // namespace
}  // namespace hgros::snapshot_publisher_test
