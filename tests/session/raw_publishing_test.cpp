// Publishing bytes of a type that is known only at run time.
#include <gmock/gmock.h>

#include <cstring>

#include <foxglove/PointCloud.pb.h>
#include <foxglove/Vector3.pb.h>

#include "hgros/session/session_parts.hpp"
#include "session/observed_fixture.hpp"

namespace hgros::test::raw_publishing_test {
namespace {

using foxglove::PointCloud;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Vector = foxglove::Vector3;

NodeOptions Everything() { return {.queue = Queue::KeepAll(100)}; }

/// A schema without a fingerprint, as recordings have it.
MessageSchema VectorSchema() {
  MessageSchema schema = SchemaOf(TypeOf<Vector>());
  schema.fingerprint = 0;
  return schema;
}

MessageSchema TextSchema() { return {"json", Encoding::kCustom, 0, {}}; }

Payload PayloadOf(const std::string& text) {
  auto owned = std::make_shared<const std::string>(text);
  const Bytes bytes = AsBytes(*owned);
  return {bytes, std::move(owned)};
}

Payload VectorBytes(double x) {
  Vector vector;
  vector.set_x(x);
  return PayloadOf(vector.SerializeAsString());
}

class RawPublishing : public ObservedFixture {
 protected:
  RawPublishing() { Begin(); }
};

TEST_P(RawPublishing, AnnouncesItsSchemaAndReachesTypedAndRawSubscribersOfAnotherSession) {
  const RawPublisher publish = robot->session->AdvertiseRaw("v", VectorSchema());
  const auto schema = observer->session->AwaitSchema("v", kPatience);
  ASSERT_NE(schema, nullptr);
  EXPECT_EQ(*schema, SchemaOf(TypeOf<Vector>())) << "with the fingerprint of the descriptor set";
  EXPECT_EQ(*schema, *publish.schema());
  const auto forgotten = [&] { return !robot->session->WaitForSubscribers("v", 1, std::chrono::nanoseconds(0)); };
  ASSERT_TRUE(Await(forgotten)) << "what asked for the schema is no longer a subscriber";
  Kept<Vector> typed;
  Kept<RawMessage> raw;
  const auto one = observer->session->FromAny<Vector>("v", kSerial, std::ref(typed), Everything());
  const auto other = observer->session->FromAnyRaw("v", kSerial, std::ref(raw), Everything());
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  const RawPublisher second = robot->session->AdvertiseRaw("v", SchemaOf(TypeOf<Vector>()));
  const auto third = robot->session->Advertise<Vector>("v");
  for (int i = 0; i < 10; ++i) {  // Two raw publishers and a typed one coexist.
    Vector vector;
    vector.set_x(i);
    const PublishStatus status = i % 3 == 2 ? third(vector) : (i % 3 == 1 ? second : publish)(VectorBytes(i));
    ASSERT_EQ(status, PublishStatus::kOk);
  }
  ASSERT_TRUE(typed.AwaitSize(10) && raw.AwaitSize(10));
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(typed.at(i)->x(), static_cast<double>(i));
    EXPECT_EQ(AsText(raw.at(i)->data.bytes), AsText(VectorBytes(static_cast<double>(i)).bytes));
  }
  EXPECT_TRUE(typed.info(0).remote);
  EXPECT_EQ(raw.at(0)->schema->type_name, "foxglove.Vector3");
  EXPECT_FALSE(robot->Said("Use one type in both programs"));
  EXPECT_FALSE(observer->Said("Use one type in both programs"));
}

TEST_P(RawPublishing, ToAnyRawLooksUpTheSchemaEachTime) {
  Kept<Vector> typed;
  const auto subscription = observer->session->FromAny<Vector>("v", kSerial, std::ref(typed), Everything());
  ASSERT_EQ(robot->session->ToAnyRaw("v", VectorSchema(), VectorBytes(0)), PublishStatus::kOk);
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  for (int i = 1; i <= 5; ++i) {
    ASSERT_EQ(robot->session->ToAnyRaw("v", VectorSchema(), VectorBytes(i)), PublishStatus::kOk);
  }
  // Message 0 may also have reached the subscriber.
  ASSERT_TRUE(Await([&] { return typed.size() >= 5 && typed.at(typed.size() - 1)->x() == 5; }));
  EXPECT_LE(typed.size(), 6U);
}

TEST_P(RawPublishing, CarriesAnyNamedEncoding) {
  Kept<RawMessage> raw;
  const auto subscription = observer->session->FromAnyRaw("text", kSerial, std::ref(raw), Everything());
  const RawPublisher publish = robot->session->AdvertiseRaw("text", TextSchema());
  ASSERT_TRUE(robot->session->WaitForSubscribers("text", 1, kPatience));
  ASSERT_EQ(publish(PayloadOf(R"({"x": 1})")), PublishStatus::kOk);
  ASSERT_EQ(publish(Payload{}), PublishStatus::kOk) << "an empty payload is a message, too";
  ASSERT_TRUE(raw.AwaitSize(2));
  EXPECT_EQ(AsText(raw.at(0)->data.bytes), R"({"x": 1})");
  EXPECT_TRUE(raw.at(1)->data.bytes.empty());
  EXPECT_EQ(raw.at(0)->schema->type_name, "json");
  EXPECT_EQ(raw.at(0)->schema->encoding, Encoding::kCustom);
}

// Typed and raw ones, in this session and in another, get exactly the vectors with x 2 and 3.
TEST_P(RawPublishing, LatchedMessagesAlsoOfAnotherPlaceReachLateSubscribers) {
  for (const bool taken_over : {false, true}) {
    SCOPED_TRACE(taken_over);
    const std::string channel = taken_over ? "taken" : "own";
    const RawPublisher publish = robot->session->AdvertiseRaw(channel, VectorSchema(), {.latched = 2});
    if (taken_over) {
      const SessionParts::LatchedMessage latched[] = {{VectorBytes(2), 5}, {VectorBytes(3), 6}};
      SessionParts(*robot->session).KeepLatched(channel, latched, SessionId{7});
    } else {
      for (int i = 1; i <= 3; ++i) ASSERT_EQ(publish(VectorBytes(i)), PublishStatus::kOk);
    }
    Kept<Vector> typed_there;
    Kept<Vector> typed;
    Kept<RawMessage> raw;
    const auto one = observer->session->FromAny<Vector>(channel, kSerial, std::ref(typed_there), Everything());
    const auto two = robot->session->FromAny<Vector>(channel, kSerial, std::ref(typed), Everything());
    const auto three = robot->session->FromAnyRaw(channel, kSerial, std::ref(raw), Everything());
    ASSERT_TRUE(typed_there.AwaitSize(2) && typed.AwaitSize(2) && raw.AwaitSize(2));
    EXPECT_EQ(typed_there.at(0)->x(), 2);
    EXPECT_EQ(typed.at(1)->x(), 3);
    EXPECT_EQ(AsText(raw.at(1)->data.bytes), AsText(VectorBytes(3).bytes));
  }
}

TEST_P(RawPublishing, LosslessSubscribersGetEverythingInOrder) {
  Kept<Vector> kept;
  const auto subscription =
      observer->session->FromAny<Vector>("v", kSerial, std::ref(kept), {.queue = Queue::KeepAll(4)});
  const RawPublisher publish = robot->session->AdvertiseRaw("v", VectorSchema());
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(publish.Wait(VectorBytes(i), std::chrono::steady_clock::now() + kPatience), PublishStatus::kOk);
  }
  ASSERT_TRUE(kept.AwaitSize(200));
  for (std::size_t i = 0; i < 200; ++i) ASSERT_EQ(kept.at(i)->x(), static_cast<double>(i));
}

TEST_P(RawPublishing, LoanedBlocksAreNotCopied) {
  if (GetParam() != "sharedmemory") GTEST_SKIP() << "only for shared memory";
  Kept<RawMessage> kept;
  const auto subscription = observer->session->FromAnyRaw("cloud", kSerial, std::ref(kept), Everything());
  const RawPublisher publish = robot->session->AdvertiseRaw("cloud", SchemaOf(TypeOf<PointCloud>()));
  ASSERT_TRUE(robot->session->WaitForSubscribers("cloud", 1, kPatience));
  PointCloud cloud;
  cloud.set_data(std::string(1 << 20, 'x'));
  const std::string bytes = cloud.SerializeAsString();
  const auto block = robot->session->Loan<Block>("cloud", bytes.size());
  std::memcpy(block->writable().data(), bytes.data(), bytes.size());
  ASSERT_EQ(publish(block->payload()), PublishStatus::kOk);
  ASSERT_TRUE(kept.AwaitSize(1));
  const ChannelTraffic traffic = robot->session->Snapshot().traffic.at(0);
  EXPECT_EQ(traffic.heap_loans, 0U);
  EXPECT_EQ(traffic.out.copied, 0U);
  EXPECT_EQ(AsText(kept.at(0)->data.bytes), bytes);
}

INSTANTIATE_TEST_SUITE_P(Over, RawPublishing, testing::Values("sharedmemory", "ipc", "tcp"), TransportName);

class RawPublishingAlone : public testing::Test {
 protected:
  Robot robot{"discovery: {local: false}\n"};
};

TEST_F(RawPublishingAlone, RawSubscribersGetTheSameBytesWithoutACopy) {
  Kept<RawMessage> kept;
  const auto subscription = robot->FromAnyRaw("v", kSerial, std::ref(kept), Everything());
  const Payload bytes = VectorBytes(1);
  ASSERT_EQ(robot->ToAnyRaw("v", VectorSchema(), bytes), PublishStatus::kOk);
  ASSERT_TRUE(kept.AwaitSize(1));
  EXPECT_EQ(kept.at(0)->data.bytes.data(), bytes.bytes.data());
  EXPECT_EQ(kept.at(0)->schema->fingerprint, TypeOf<Vector>().fingerprint);
  EXPECT_FALSE(kept.info(0).remote);
}

TEST_F(RawPublishingAlone, BytesWithoutAnOwnerAreCopied) {
  Kept<RawMessage> kept;
  const auto subscription = robot->FromAnyRaw("t", kSerial, std::ref(kept), Everything());
  std::string text = "one";
  ASSERT_EQ(robot->ToAnyRaw("t", TextSchema(), {AsBytes(text), nullptr}), PublishStatus::kOk);
  text = "two";
  ASSERT_TRUE(kept.AwaitSize(1));
  EXPECT_EQ(AsText(kept.at(0)->data.bytes), "one");
}

TEST_F(RawPublishingAlone, TypedSubscribersShareOneDecodedMessage) {
  for (const bool subscribed_first : {true, false}) {
    const std::string channel = subscribed_first ? "first" : "later";
    Kept<Vector> one;
    Kept<Vector> two;
    std::optional<Subscription> a, b;
    const auto subscribe = [&] {
      a = robot->FromAny<Vector>(channel, kSerial, std::ref(one), Everything());
      b = robot->FromAny<Vector>(channel, kSerial, std::ref(two), Everything());
    };
    if (subscribed_first) subscribe();
    const RawPublisher publish = robot->AdvertiseRaw(channel, VectorSchema());
    if (!subscribed_first) subscribe();
    ASSERT_EQ(publish(VectorBytes(7)), PublishStatus::kOk);
    ASSERT_TRUE(Await([&] { return one.size() == 1 && two.size() == 1; }));
    EXPECT_EQ(one.at(0)->x(), 7);
    EXPECT_EQ(one.at(0), two.at(0));
  }
}

TEST_F(RawPublishingAlone, BulkAndPlainSubscribersEachGetTheirForm) {
  Kept<PointCloud> plain;
  Kept<Bulk<PointCloud>> bulk;
  const auto one = robot->FromAny<PointCloud>("c", kSerial, std::ref(plain), Everything());
  const auto two = robot->FromAny<Bulk<PointCloud>>("c", kSerial, std::ref(bulk), Everything());
  PointCloud cloud;
  cloud.set_frame_id("lidar");
  cloud.set_data("points");
  const RawPublisher publish = robot->AdvertiseRaw("c", SchemaOf(TypeOf<PointCloud>()));
  ASSERT_EQ(publish(PayloadOf(cloud.SerializeAsString())), PublishStatus::kOk);
  ASSERT_EQ(robot->ToAny("c", cloud), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return plain.size() == 2 && bulk.size() == 2; }));
  EXPECT_EQ(plain.at(0)->data(), "points");
  EXPECT_EQ(AsText(bulk.at(0)->bytes()), "points");
  EXPECT_EQ(bulk.at(1)->head().frame_id(), "lidar");
}

TEST_F(RawPublishingAlone, CountsBytesThatDoNotDecodeAndDeliversTheNextMessages) {
  Kept<Vector> kept;
  const auto subscription = robot->FromAny<Vector>("v", kSerial, std::ref(kept), Everything());
  const RawPublisher publish = robot->AdvertiseRaw("v", VectorSchema());
  ASSERT_EQ(publish(PayloadOf("\xff\xff\xff")), PublishStatus::kOk);
  ASSERT_EQ(publish(VectorBytes(1)), PublishStatus::kOk);
  ASSERT_TRUE(kept.AwaitSize(1));
  std::uint64_t not_converted = 0;
  for (const ChannelSnapshot& channel : robot->Snapshot().graph.channels) {
    if (channel.name == "v") not_converted = channel.not_converted;
  }
  EXPECT_EQ(not_converted, 1U);
  EXPECT_TRUE(robot.Said("missed a message"));
}

TEST_F(RawPublishingAlone, ReturnsThePayloadToTheCallerWhenASubscriberIsFull) {
  Door door;
  std::atomic<bool> begun{false};
  Kept<RawMessage> kept;
  const auto hold = [&](const std::shared_ptr<const RawMessage>& message, const MessageInfo& info) {
    begun = true;
    door.Pass();
    kept(message, info);
  };
  const auto subscription = robot->FromAnyRaw("t", kSerial, hold, {.queue = Queue::KeepAll(1)});
  const RawPublisher publish = robot->AdvertiseRaw("t", TextSchema());
  const Payload bytes = PayloadOf("text");
  EXPECT_EQ(publish(bytes), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return begun.load(); }));  // From here on nothing leaves the queue.
  std::size_t taken = 1;
  while (publish(bytes) == PublishStatus::kOk) ++taken;
  EXPECT_EQ(AsText(bytes.bytes), "text");
  EXPECT_EQ(publish(bytes), PublishStatus::kFull);
  door.Open();
  ASSERT_TRUE(kept.AwaitSize(taken));
  EXPECT_EQ(publish(bytes), PublishStatus::kOk);
}

TEST_F(RawPublishingAlone, AdvertisingAnotherTypeThrowsATypeMismatchThatNamesBoth) {
  const auto typed = robot->Advertise<Vector>("v");
  EXPECT_THAT([&] { (void)robot->AdvertiseRaw("v", TextSchema()); },
              ThrowsMessage<TypeMismatch>(AllOf(HasSubstr("\"v\""), HasSubstr("foxglove.Vector3"), HasSubstr("json"),
                                                HasSubstr("raw_publishing_test.cpp"))));
  const RawPublisher raw = robot->AdvertiseRaw("t", TextSchema());
  EXPECT_THROW((void)robot->Advertise<Vector>("t"), TypeMismatch);
  EXPECT_THROW((void)robot->FromAny<Vector>("t", kSerial, [](const Vector&) {}), TypeMismatch);
  EXPECT_THROW(robot->ToAnyRaw("t", VectorSchema(), VectorBytes(1)), TypeMismatch);
  const RawPublisher pair = robot->AdvertiseRaw("p", {"robot.Pair", Encoding::kPlain, 1, {}});
  EXPECT_THAT(
      [&] {
        (void)robot->AdvertiseRaw("p", {"robot.Pair", Encoding::kPlain, 0xabc, {}});
      },
      ThrowsMessage<TypeMismatch>(HasSubstr("fingerprint 0000000000000abc")))
      << "another layout";
}

TEST_F(RawPublishingAlone, RefusesSchemasThatDescribeNoTypeAndEverythingAfterTheEndOfTheSession) {
  EXPECT_THROW((void)robot->AdvertiseRaw("v", {}), Error);
  MessageSchema broken = VectorSchema();
  broken.descriptor_set = "no descriptors";
  EXPECT_THROW((void)robot->AdvertiseRaw("v", broken), Error);
  MessageSchema lacking = VectorSchema();
  lacking.type_name = "robot.Missing";
  EXPECT_THROW((void)robot->AdvertiseRaw("v", lacking), Error);
  EXPECT_THROW(robot->ToAnyRaw("hgros/peers", VectorSchema(), VectorBytes(1)), Error);
  const RawPublisher publish = robot->AdvertiseRaw("v", VectorSchema());
  robot.session.reset();
  EXPECT_EQ(publish(VectorBytes(1)), PublishStatus::kClosed);
  EXPECT_EQ(RawPublisher()(VectorBytes(1)), PublishStatus::kClosed);
}

}  // namespace
}  // namespace hgros::test::raw_publishing_test
