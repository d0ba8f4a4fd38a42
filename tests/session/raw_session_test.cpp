// Subscriptions of programs that do not know the type of the channel.
#include <google/protobuf/descriptor.pb.h>

#include <foxglove/PointCloud.pb.h>
#include <foxglove/Vector3.pb.h>

#include "session/observed_fixture.hpp"

namespace hgros::test::raw_session_test {
namespace {

using foxglove::PointCloud;
using foxglove::Vector3;

using KeptRaw = Kept<RawMessage>;

NodeOptions All() { return {.queue = Queue::KeepAll(100)}; }

Vector3 Vector(double x) {
  Vector3 vector;
  vector.set_x(x);
  return vector;
}

double XOf(const RawMessage& message) {
  Vector3 vector;
  EXPECT_TRUE(vector.ParseFromString(std::string(AsText(message.data.bytes))));
  return vector.x();
}

class RawSubscription : public ObservedFixture {
 protected:
  RawSubscription() { Begin(); }
  /// One more publishing session that the observer reaches.
  [[nodiscard]] std::unique_ptr<Robot> Second() {
    auto second = std::make_unique<Robot>(
        GetParam() == "sharedmemory" ? ""
                                     : "network: {publisher: {ip: 'tcp://127.0.0.1:*'}}\ndiscovery: {local: false}\n",
        "second");
    Connect(*observer->session, *second->session);
    return second;
  }
};

TEST_P(RawSubscription, ReceivesBytesSenderAndSchemaOfAChannelThatIsAdvertisedLater) {
  EXPECT_EQ(observer->session->AwaitSchema("nothing", std::chrono::milliseconds(50)), nullptr);
  KeptRaw kept;
  const auto subscription = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All());
  const auto other = robot->session->Advertise<Vector3>("other");
  ASSERT_TRUE(Await([&] { return IsPublished("other"); }));
  const auto publish = robot->session->Advertise<Vector3>("v");
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  for (int i = 0; i < 10; ++i) ASSERT_EQ(publish(Vector(i)), PublishStatus::kOk);
  ASSERT_TRUE(kept.AwaitSize(10));
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(XOf(*kept.at(i)), static_cast<double>(i));
    EXPECT_EQ(kept.info(i).id.publisher, robot->session->id().value);
    EXPECT_EQ(kept.info(i).id.sequence, i + 1);
    EXPECT_TRUE(kept.info(i).remote);
  }
  EXPECT_EQ(*kept.at(0)->schema, SchemaOf(TypeOf<Vector3>()));
  EXPECT_EQ(kept.at(0)->schema, kept.at(9)->schema);
  EXPECT_FALSE(robot->Said("Use one type in both programs"));
  EXPECT_FALSE(observer->Said("Use one type in both programs"));
}

TEST_P(RawSubscription, SchemaContainsAllImports) {
  const auto publish = robot->session->Advertise<PointCloud>("cloud");
  const auto schema = observer->session->AwaitSchema("cloud", kPatience);
  ASSERT_NE(schema, nullptr);
  EXPECT_EQ(schema->type_name, "foxglove.PointCloud");
  google::protobuf::FileDescriptorSet files;
  ASSERT_TRUE(files.ParseFromString(schema->descriptor_set));
  EXPECT_GE(files.file_size(), 5) << "Timestamp, Pose, Vector3, Quaternion, PackedElementField and itself";
  EXPECT_EQ(files.file(files.file_size() - 1).name(), "foxglove/PointCloud.proto");
  EXPECT_TRUE(Await([&] { return robot->session->Snapshot().traffic.at(0).out.subscribers == 0; }))
      << "the observer is no longer a subscriber";
}

TEST_P(RawSubscription, ForgetsTheSchemaOfAPublisherThatIsGone) {
  std::unique_ptr<Robot> second = Second();
  KeptRaw kept;
  const auto subscription = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All());
  const auto newest = [&] { return observer->session->AwaitSchema("v", std::chrono::milliseconds(1)); };
  const auto is = [&](Encoding encoding) {
    const auto schema = newest();
    return schema != nullptr && schema->encoding == encoding;
  };
  const auto vectors = robot->session->Advertise<Vector3>("v");
  ASSERT_TRUE(Await([&] { return is(Encoding::kProtobuf); }));
  const auto notes = second->session->Advertise<Note>("v");
  ASSERT_TRUE(Await([&] { return is(Encoding::kCustom); })) << "the last one that came";
  second.reset();
  EXPECT_TRUE(Await([&] { return is(Encoding::kProtobuf); })) << newest()->type_name;
  robot.reset();
  EXPECT_TRUE(Await([&] { return newest() == nullptr; })) << "there is no publisher any more";
}

TEST_P(RawSubscription, LeavesPublishersOfOtherTypesWhenATypedOneTakesItsPlace) {
  for (const bool raw_first : {true, false}) {
    Begin();
    std::unique_ptr<Robot> second = Second();
    KeptRaw kept;
    Subscription raw = observer->session->FromAnyRaw("v", kSerial, std::ref(kept));
    const auto vectors = robot->session->Advertise<Vector3>("v");
    const auto notes = second->session->Advertise<Note>("v");
    ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
    ASSERT_TRUE(second->session->WaitForSubscribers("v", 1, kPatience));
    if (raw_first) raw.Reset();
    std::atomic<int> typed{0};
    const auto subscription = observer->session->FromAny<Vector3>("v", kSerial, [&](const Vector3&) { ++typed; });
    raw.Reset();
    EXPECT_TRUE(Await([&] { return second->session->Snapshot().traffic.at(0).out.subscribers == 0; }))
        << "it still sends what nobody can read";
    EXPECT_TRUE(Await([&] { return vectors(Vector(1)) == PublishStatus::kOk && typed > 0; }));
    observer.reset();
  }
}

TEST_P(RawSubscription, LosesNoMessageOfALosslessTypedOneWhenItEnds) {
  KeptRaw kept;
  // Lossless, too, so that the link is lossless from its start.
  Subscription raw = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All());
  Kept<Vector3> typed;
  const auto subscription = observer->session->FromAny<Vector3>("v", kSerial, std::ref(typed), All());
  const auto publish = robot->session->Advertise<Vector3>("v");
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(publish.Wait(std::make_unique<Vector3>(Vector(i)), std::chrono::steady_clock::now() + kPatience),
              PublishStatus::kOk);
    if (i == 50) raw.Reset();
  }
  ASSERT_TRUE(typed.AwaitSize(200)) << typed.size();
  for (std::size_t i = 0; i < 200; ++i) EXPECT_EQ(typed.at(i)->x(), static_cast<double>(i));
}

TEST_P(RawSubscription, AndATypedSubscriptionOfOneChannelBothReceiveEveryMessage) {
  for (const bool raw_first : {true, false}) {
    Begin();
    KeptRaw kept;
    Kept<Vector3> typed;
    std::optional<Subscription> raw, other;
    const auto add_raw = [&] { raw = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All()); };
    const auto add_typed = [&] { other = observer->session->FromAny<Vector3>("v", kSerial, std::ref(typed), All()); };
    raw_first ? add_raw() : add_typed();
    const auto publish = robot->session->Advertise<Vector3>("v", {.latched = 1});
    ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
    publish(Vector(1));
    ASSERT_TRUE(Await([&] { return kept.size() + typed.size() == 1; }));
    raw_first ? add_typed() : add_raw();
    ASSERT_TRUE(kept.AwaitSize(1) && typed.AwaitSize(1)) << "the latched one";
    for (int i = 2; i <= 20; ++i) ASSERT_EQ(publish(Vector(i)), PublishStatus::kOk);
    ASSERT_TRUE(kept.AwaitSize(20) && typed.AwaitSize(20));
    for (std::size_t i = 0; i < 20; ++i) {
      EXPECT_EQ(XOf(*kept.at(i)), static_cast<double>(i + 1));
      EXPECT_EQ(typed.at(i)->x(), static_cast<double>(i + 1));
    }
    EXPECT_FALSE(observer->Said("Use one type in both programs"));
    EXPECT_EQ(kept.at(19)->schema->type_name, "foxglove.Vector3");
    EXPECT_FALSE(kept.at(19)->schema->descriptor_set.empty());
  }
}

TEST_P(RawSubscription, ReceivesFromPublishersOfDifferentTypes) {
  std::unique_ptr<Robot> second = Second();
  KeptRaw kept;
  const auto raw = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All());
  const auto vectors = robot->session->Advertise<Vector3>("v");
  const auto notes = second->session->Advertise<Note>("v");
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  ASSERT_TRUE(second->session->WaitForSubscribers("v", 1, kPatience));
  vectors(Vector(1));
  ASSERT_TRUE(kept.AwaitSize(1));
  notes(std::make_unique<Note>("text"));
  ASSERT_TRUE(kept.AwaitSize(2));
  EXPECT_EQ(kept.at(0)->schema->type_name, "foxglove.Vector3");
  EXPECT_EQ(kept.at(1)->schema->encoding, Encoding::kCustom);
  EXPECT_EQ(AsText(kept.at(1)->data.bytes), "text");

  // Now this session has a type, and it differs from what the second session sends.
  std::atomic<int> typed{0};
  const auto subscription = observer->session->FromAny<Vector3>("v", kSerial, [&](const Vector3&) { ++typed; });
  ASSERT_TRUE(Await([&] { return observer->Said(second->session->NameOf(second->session->id()) + " publishes "); }));
  vectors(Vector(2));
  notes(std::make_unique<Note>("more"));
  ASSERT_TRUE(Await([&] { return kept.size() == 4 && typed == 1; }));
}

INSTANTIATE_TEST_SUITE_P(Over, RawSubscription, testing::Values("sharedmemory", "ipc", "tcp"), TransportName);

TEST_P(RawSubscription, ReceivesRemoteMessagesOnAChannelThatHasALocalType) {
  struct Local {
    std::string text;  // Not a plain struct, so it has no wire form.
  };
  const auto local = observer->session->FromGraph<Local>("v", kSerial, [](const Local&) {});
  KeptRaw kept;
  const auto subscription = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All());
  const auto publish = robot->session->Advertise<Vector3>("v");
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  publish(Vector(7));
  ASSERT_TRUE(kept.AwaitSize(1));
  EXPECT_EQ(XOf(*kept.at(0)), 7);
}

}  // namespace
}  // namespace hgros::test::raw_session_test
