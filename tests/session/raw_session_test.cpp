// Subscriptions of programs that do not know the type of the channel.
#include <google/protobuf/descriptor.pb.h>

#include <foxglove/PointCloud.pb.h>
#include <foxglove/Vector3.pb.h>

#include "session/observed_fixture.hpp"

namespace hgros::raw_session_test {
namespace {

using foxglove::PointCloud;
using foxglove::Vector3;
using test::Await;
using test::kPatience;
using test::kSerial;
using test::Note;

/// Keeps received messages.
class KeptRaw {
 public:
  void operator()(const std::shared_ptr<const RawMessage>& message, const MessageInfo& info) {
    const std::scoped_lock lock(mutex_);
    messages_.push_back(message);
    infos_.push_back(info);
  }
  [[nodiscard]] std::vector<std::shared_ptr<const RawMessage>> messages() const {
    const std::scoped_lock lock(mutex_);
    return messages_;
  }
  [[nodiscard]] std::vector<MessageInfo> infos() const {
    const std::scoped_lock lock(mutex_);
    return infos_;
  }
  [[nodiscard]] std::size_t size() const { return messages().size(); }

 private:
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<const RawMessage>> messages_;
  std::vector<MessageInfo> infos_;
};

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

class RawSubscription : public test::ObservedFixture {
 protected:
  /// One more publishing session that the observer reaches.
  [[nodiscard]] std::unique_ptr<test::Robot> Second() {
    auto second = std::make_unique<test::Robot>(
        GetParam() == "sharedmemory" ? ""
                                     : "network: {publisher: {ip: 'tcp://127.0.0.1:*'}}\ndiscovery: {local: false}\n",
        "second");
    Connect(*observer->session, *second->session);
    return second;
  }
};

TEST_P(RawSubscription, ReceivesBytesSenderAndSchema) {
  Begin();
  KeptRaw kept;
  const auto subscription = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All());
  const auto publish = robot->session->Advertise<Vector3>("v");
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  for (int i = 0; i < 10; ++i) ASSERT_EQ(publish(std::make_unique<Vector3>(Vector(i))), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return kept.size() == 10; }));
  for (int i = 0; i < 10; ++i) {
    const auto at = static_cast<std::size_t>(i);
    EXPECT_EQ(XOf(*kept.messages()[at]), i);
    EXPECT_EQ(kept.infos()[at].id.publisher, robot->session->id().value);
    EXPECT_EQ(kept.infos()[at].id.sequence, at + 1);
    EXPECT_TRUE(kept.infos()[at].remote);
  }
  EXPECT_EQ(*kept.messages()[0]->schema, SchemaOf(TypeOf<Vector3>()));
  EXPECT_EQ(kept.messages()[0]->schema, kept.messages()[9]->schema);
  EXPECT_FALSE(robot->Said("different types"));
  EXPECT_FALSE(observer->Said("different types"));
}

TEST_P(RawSubscription, SchemaContainsAllImports) {
  Begin();
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

TEST_P(RawSubscription, HasNoSchemaWithoutAPublisher) {
  Begin();
  EXPECT_EQ(observer->session->AwaitSchema("nothing", std::chrono::milliseconds(50)), nullptr);
}

TEST_P(RawSubscription, ForgetsTheSchemaOfAPublisherThatIsGone) {
  Begin();
  KeptRaw kept;
  const auto subscription = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All());
  const auto vectors = robot->session->Advertise<Vector3>("v");
  ASSERT_NE(observer->session->AwaitSchema("v", kPatience), nullptr);
  robot.reset();
  EXPECT_TRUE(Await([&] { return observer->session->AwaitSchema("v", std::chrono::milliseconds(1)) == nullptr; }))
      << "there is no publisher any more";
}

TEST_P(RawSubscription, ForgetsTheSchemaOfAPublisherThatIsGoneWhileAnotherStays) {
  Begin();
  std::unique_ptr<test::Robot> second = Second();
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
}

TEST_P(RawSubscription, LeavesPublishersOfOtherTypesWhenATypedOneTakesItsPlace) {
  for (const bool raw_first : {true, false}) {
    Begin();
    std::unique_ptr<test::Robot> second = Second();
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
    EXPECT_TRUE(
        Await([&] { return vectors(std::make_unique<Vector3>(Vector(1))) == PublishStatus::kOk && typed > 0; }));
    observer.reset();
  }
}

TEST_P(RawSubscription, LosesNoMessageOfALosslessTypedOneWhenItEnds) {
  Begin();
  KeptRaw kept;
  // Lossless, too, so that the link is lossless from its start.
  Subscription raw = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All());
  std::vector<double> typed;
  std::atomic<std::size_t> count{0};
  const auto subscription = observer->session->FromAny<Vector3>(
      "v", kSerial,
      [&](const Vector3& vector) {
        typed.push_back(vector.x());
        ++count;
      },
      All());
  const auto publish = robot->session->Advertise<Vector3>("v");
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(publish.Wait(std::make_unique<Vector3>(Vector(i)), std::chrono::steady_clock::now() + kPatience),
              PublishStatus::kOk);
    if (i == 50) raw.Reset();
  }
  ASSERT_TRUE(Await([&] { return count == 200; })) << count;
  for (int i = 0; i < 200; ++i) EXPECT_EQ(typed[static_cast<std::size_t>(i)], i);
}

TEST_P(RawSubscription, AndATypedSubscriptionOfOneChannelBothReceiveEveryMessage) {
  for (const bool raw_first : {true, false}) {
    Begin();
    KeptRaw kept;
    std::vector<double> typed;
    std::atomic<std::size_t> count{0};
    std::optional<Subscription> raw, other;
    const auto add_raw = [&] { raw = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All()); };
    const auto add_typed = [&] {
      other = observer->session->FromAny<Vector3>(
          "v", kSerial,
          [&](const Vector3& vector) {
            typed.push_back(vector.x());
            ++count;
          },
          All());
    };
    raw_first ? add_raw() : add_typed();
    const auto publish = robot->session->Advertise<Vector3>("v", {.latched = 1});
    ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
    publish(std::make_unique<Vector3>(Vector(1)));
    ASSERT_TRUE(Await([&] { return kept.size() + count == 1; }));
    raw_first ? add_typed() : add_raw();
    ASSERT_TRUE(Await([&] { return kept.size() == 1 && count == 1; })) << "the latched one";
    for (int i = 2; i <= 20; ++i) ASSERT_EQ(publish(std::make_unique<Vector3>(Vector(i))), PublishStatus::kOk);
    ASSERT_TRUE(Await([&] { return kept.size() == 20 && count == 20; }));
    for (int i = 1; i <= 20; ++i) {
      EXPECT_EQ(XOf(*kept.messages()[static_cast<std::size_t>(i - 1)]), i);
      EXPECT_EQ(typed[static_cast<std::size_t>(i - 1)], i);
    }
    EXPECT_FALSE(observer->Said("different types"));
    EXPECT_EQ(kept.messages().back()->schema->type_name, "foxglove.Vector3");
    EXPECT_FALSE(kept.messages().back()->schema->descriptor_set.empty());
  }
}

TEST_P(RawSubscription, ReceivesFromPublishersOfDifferentTypes) {
  Begin();
  std::unique_ptr<test::Robot> second = Second();
  KeptRaw kept;
  const auto raw = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All());
  const auto vectors = robot->session->Advertise<Vector3>("v");
  const auto notes = second->session->Advertise<Note>("v");
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  ASSERT_TRUE(second->session->WaitForSubscribers("v", 1, kPatience));
  vectors(std::make_unique<Vector3>(Vector(1)));
  ASSERT_TRUE(Await([&] { return kept.size() == 1; }));
  notes(std::make_unique<Note>("text"));
  ASSERT_TRUE(Await([&] { return kept.size() == 2; }));
  EXPECT_EQ(kept.messages()[0]->schema->type_name, "foxglove.Vector3");
  EXPECT_EQ(kept.messages()[1]->schema->encoding, Encoding::kCustom);
  EXPECT_EQ(AsText(kept.messages()[1]->data.bytes), "text");

  // Now this session has a type, and it differs from what the second session sends.
  std::atomic<int> typed{0};
  const auto subscription = observer->session->FromAny<Vector3>("v", kSerial, [&](const Vector3&) { ++typed; });
  ASSERT_TRUE(Await([&] { return observer->Said(" and session " + second->session->id().ToString()); }));
  vectors(std::make_unique<Vector3>(Vector(2)));
  notes(std::make_unique<Note>("more"));
  ASSERT_TRUE(Await([&] { return kept.size() == 4 && typed == 1; }));
}

TEST_P(RawSubscription, ReceivesFromAChannelThatIsAdvertisedLater) {
  robot.emplace(PublisherYaml(), "robot");
  observer.emplace(ObserverYaml(), "observer");
  Connect(*observer->session, *robot->session);
  KeptRaw kept;
  const auto subscription = observer->session->FromAnyRaw("late", kSerial, std::ref(kept), All());
  const auto other = robot->session->Advertise<Vector3>("other");
  ASSERT_TRUE(Await([&] { return IsPublished("other"); }));
  const auto publish = robot->session->Advertise<Vector3>("late");
  ASSERT_TRUE(robot->session->WaitForSubscribers("late", 1, kPatience));
  publish(std::make_unique<Vector3>(Vector(1)));
  EXPECT_TRUE(Await([&] { return kept.size() == 1; }));
}

TEST_P(RawSubscription, ReceivesLargeMessagesWithoutACopy) {
  if (GetParam() != "sharedmemory") GTEST_SKIP() << "only for shared memory";
  Begin();
  KeptRaw kept;
  const auto subscription = observer->session->FromAnyRaw("cloud", kSerial, std::ref(kept), All());
  const auto publish = robot->session->Advertise<Bulk<PointCloud>>("cloud");
  ASSERT_TRUE(robot->session->WaitForSubscribers("cloud", 1, kPatience));
  auto cloud = robot->session->Loan<Bulk<PointCloud>>("cloud", 1 << 20);
  cloud->writable()[0] = std::byte{42};
  ASSERT_EQ(publish(std::move(cloud)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return kept.size() == 1; }));
  EXPECT_EQ(robot->session->Snapshot().traffic.at(0).out.copied, 0U);
  PointCloud parsed;
  const auto text = AsText(kept.messages()[0]->data.bytes);
  ASSERT_TRUE(parsed.ParseFromArray(text.data(), static_cast<int>(text.size())));
  EXPECT_EQ(parsed.data().size(), 1U << 20);
  EXPECT_EQ(parsed.data()[0], 42);
}

INSTANTIATE_TEST_SUITE_P(Over, RawSubscription, testing::Values("sharedmemory", "ipc", "tcp"), test::TransportName);

TEST_P(RawSubscription, ReceivesRemoteMessagesOnAChannelThatHasALocalType) {
  struct Local {
    std::string text;  // Not a plain struct, so it has no wire form.
  };
  Begin();
  const auto local = observer->session->FromGraph<Local>("v", kSerial, [](const Local&) {});
  KeptRaw kept;
  const auto subscription = observer->session->FromAnyRaw("v", kSerial, std::ref(kept), All());
  const auto publish = robot->session->Advertise<Vector3>("v");
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  publish(std::make_unique<Vector3>(Vector(7)));
  ASSERT_TRUE(Await([&] { return kept.size() == 1; }));
  EXPECT_EQ(XOf(*kept.messages()[0]), 7);
}

TEST(RawSubscriptionAlone, ReceivesMessagesOfItsOwnSession) {
  test::Robot robot("discovery: {local: false}\n");
  KeptRaw kept;
  const auto subscription = robot->FromAnyRaw("v", kSerial, std::ref(kept), All());
  robot->ToAny("v", Vector(5));
  ASSERT_TRUE(Await([&] { return kept.size() == 1; }));
  EXPECT_EQ(XOf(*kept.messages()[0]), 5);
  EXPECT_FALSE(kept.infos()[0].remote);
}

}  // namespace
}  // namespace hgros::raw_session_test
