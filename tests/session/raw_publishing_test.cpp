// Publishing bytes of a type that is known only at run time.
#include <google/protobuf/descriptor.pb.h>

#include <atomic>
#include <cstring>

#include <foxglove/PointCloud.pb.h>
#include <foxglove/Vector3.pb.h>

#include "hgros/codec/run_time_type.hpp"
#include "hgros/session/session_parts.hpp"
#include "session/observed_fixture.hpp"

namespace hgros::raw_publishing_test {
namespace {

using foxglove::PointCloud;
using test::Await;
using test::kPatience;
using test::kSerial;
using test::Note;
using Vector = foxglove::Vector3;

/// Keeps received messages, raw or typed.
template <class T>
class Kept {
 public:
  void operator()(const std::shared_ptr<const T>& message, const MessageInfo& info) {
    const std::scoped_lock lock(mutex_);
    messages_.push_back(message);
    remote_ = info.remote;
  }
  [[nodiscard]] std::vector<std::shared_ptr<const T>> messages() const {
    const std::scoped_lock lock(mutex_);
    return messages_;
  }
  [[nodiscard]] std::size_t size() const { return messages().size(); }
  [[nodiscard]] bool remote() const {
    const std::scoped_lock lock(mutex_);
    return remote_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<const T>> messages_;
  bool remote_ = false;
};

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

class RawPublishing : public test::ObservedFixture {};

TEST_P(RawPublishing, ReachesTypedAndRawSubscribersOfAnotherSession) {
  Begin();
  Kept<Vector> typed;
  Kept<RawMessage> raw;
  const auto one = observer->session->FromAny<Vector>("v", kSerial, std::ref(typed), Everything());
  const auto other = observer->session->FromAnyRaw("v", kSerial, std::ref(raw), Everything());
  const RawPublisher publish = robot->session->AdvertiseRaw("v", VectorSchema());
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  for (int i = 0; i < 10; ++i) ASSERT_EQ(publish(VectorBytes(i)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return typed.size() == 10 && raw.size() == 10; }));
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(typed.messages()[i]->x(), static_cast<double>(i));
    EXPECT_EQ(AsText(raw.messages()[i]->data.bytes), AsText(VectorBytes(static_cast<double>(i)).bytes));
  }
  EXPECT_TRUE(typed.remote());
  EXPECT_EQ(raw.messages()[0]->schema->type_name, "foxglove.Vector3");
  EXPECT_FALSE(robot->Said("different types"));
  EXPECT_FALSE(observer->Said("different types"));
}

TEST_P(RawPublishing, ToAnyRawLooksUpTheSchemaEachTime) {
  Begin();
  Kept<Vector> typed;
  const auto subscription = observer->session->FromAny<Vector>("v", kSerial, std::ref(typed), Everything());
  ASSERT_EQ(robot->session->ToAnyRaw("v", VectorSchema(), VectorBytes(0)), PublishStatus::kOk);
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  for (int i = 1; i <= 5; ++i) {
    ASSERT_EQ(robot->session->ToAnyRaw("v", VectorSchema(), VectorBytes(i)), PublishStatus::kOk);
  }
  // Message 0 may also have reached the subscriber.
  ASSERT_TRUE(Await([&] { return typed.size() >= 5 && typed.messages().back()->x() == 5; }));
  EXPECT_LE(typed.size(), 6U);
}

TEST_P(RawPublishing, AnnouncesItsSchemaToOtherSessions) {
  Begin();
  const RawPublisher publish = robot->session->AdvertiseRaw("v", VectorSchema());
  const auto schema = observer->session->AwaitSchema("v", kPatience);
  ASSERT_NE(schema, nullptr);
  EXPECT_EQ(*schema, SchemaOf(TypeOf<Vector>())) << "with the fingerprint of the descriptor set";
  EXPECT_EQ(*schema, *publish.schema());
}

TEST_P(RawPublishing, CarriesAnyNamedEncoding) {
  Begin();
  Kept<RawMessage> raw;
  const auto subscription = observer->session->FromAnyRaw("text", kSerial, std::ref(raw), Everything());
  const RawPublisher publish = robot->session->AdvertiseRaw("text", TextSchema());
  ASSERT_TRUE(robot->session->WaitForSubscribers("text", 1, kPatience));
  ASSERT_EQ(publish(PayloadOf(R"({"x": 1})")), PublishStatus::kOk);
  ASSERT_EQ(publish(Payload{}), PublishStatus::kOk) << "an empty payload is a message, too";
  ASSERT_TRUE(Await([&] { return raw.size() == 2; }));
  EXPECT_EQ(AsText(raw.messages()[0]->data.bytes), R"({"x": 1})");
  EXPECT_TRUE(raw.messages()[1]->data.bytes.empty());
  EXPECT_EQ(raw.messages()[0]->schema->type_name, "json");
  EXPECT_EQ(raw.messages()[0]->schema->encoding, Encoding::kCustom);
}

// Typed and raw ones, in this session and in another, get exactly the vectors with x 2 and 3.
void ExpectThatLateSubscribersGet2And3(Session& here, Session& there) {
  Kept<Vector> typed_there;
  Kept<Vector> typed;
  Kept<RawMessage> raw;
  const auto one = there.FromAny<Vector>("v", kSerial, std::ref(typed_there), Everything());
  const auto two = here.FromAny<Vector>("v", kSerial, std::ref(typed), Everything());
  const auto three = here.FromAnyRaw("v", kSerial, std::ref(raw), Everything());
  ASSERT_TRUE(Await([&] { return typed_there.size() == 2 && typed.size() == 2 && raw.size() == 2; }));
  EXPECT_EQ(typed_there.messages()[0]->x(), 2);
  EXPECT_EQ(typed.messages()[1]->x(), 3);
  EXPECT_EQ(AsText(raw.messages()[1]->data.bytes), AsText(VectorBytes(3).bytes));
}

TEST_P(RawPublishing, LatchedMessagesReachLateSubscribers) {
  Begin();
  const RawPublisher publish = robot->session->AdvertiseRaw("v", VectorSchema(), {.latched = 2});
  for (int i = 1; i <= 3; ++i) ASSERT_EQ(publish(VectorBytes(i)), PublishStatus::kOk);
  ExpectThatLateSubscribersGet2And3(*robot->session, *observer->session);
}

TEST_P(RawPublishing, LatchedMessagesOfAnotherPlaceReachTypedAndRawSubscribers) {
  Begin();
  const RawPublisher publish = robot->session->AdvertiseRaw("v", VectorSchema(), {.latched = 2});
  const SessionParts::LatchedMessage taken_over[] = {{VectorBytes(2), 5}, {VectorBytes(3), 6}};
  SessionParts(*robot->session).KeepLatched("v", taken_over, SessionId{7});
  ExpectThatLateSubscribersGet2And3(*robot->session, *observer->session);
}

TEST_P(RawPublishing, LosslessSubscribersGetEverythingInOrder) {
  Begin();
  Kept<Vector> kept;
  const auto subscription =
      observer->session->FromAny<Vector>("v", kSerial, std::ref(kept), {.queue = Queue::KeepAll(4)});
  const RawPublisher publish = robot->session->AdvertiseRaw("v", VectorSchema());
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(publish.Wait(VectorBytes(i), std::chrono::steady_clock::now() + kPatience), PublishStatus::kOk);
  }
  ASSERT_TRUE(Await([&] { return kept.size() == 200; }));
  for (std::size_t i = 0; i < 200; ++i) ASSERT_EQ(kept.messages()[i]->x(), static_cast<double>(i));
}

TEST_P(RawPublishing, TypeMismatchWithAnotherSessionIsReportedOnBothSides) {
  Begin();
  const auto subscription = observer->session->FromAny<Note>("v", kSerial, [](const Note&) {});
  const RawPublisher publish = robot->session->AdvertiseRaw("v", VectorSchema());
  EXPECT_TRUE(Await([&] { return observer->Said("different types"); }));
  EXPECT_TRUE(Await([&] { return robot->Said("different types"); }));
}

TEST_P(RawPublishing, TwoRawPublishersAndATypedOneCoexist) {
  Begin();
  Kept<Vector> kept;
  const auto subscription = observer->session->FromAny<Vector>("v", kSerial, std::ref(kept), Everything());
  const RawPublisher first = robot->session->AdvertiseRaw("v", VectorSchema());
  const RawPublisher second = robot->session->AdvertiseRaw("v", SchemaOf(TypeOf<Vector>()));
  const auto typed = robot->session->Advertise<Vector>("v");
  ASSERT_TRUE(robot->session->WaitForSubscribers("v", 1, kPatience));
  Vector three;
  three.set_x(3);
  EXPECT_EQ(first(VectorBytes(1)), PublishStatus::kOk);
  EXPECT_EQ(second(VectorBytes(2)), PublishStatus::kOk);
  EXPECT_EQ(typed(three), PublishStatus::kOk);
  EXPECT_EQ(first(VectorBytes(4)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return kept.size() == 4; }));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(kept.messages()[i]->x(), static_cast<double>(i + 1));
}

TEST_P(RawPublishing, LoanedBlocksAreNotCopied) {
  if (GetParam() != "sharedmemory") GTEST_SKIP() << "only for shared memory";
  Begin();
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
  ASSERT_TRUE(Await([&] { return kept.size() == 1; }));
  const ChannelTraffic traffic = robot->session->Snapshot().traffic.at(0);
  EXPECT_EQ(traffic.heap_loans, 0U);
  EXPECT_EQ(traffic.out.copied, 0U);
  EXPECT_EQ(AsText(kept.messages()[0]->data.bytes), bytes);
}

INSTANTIATE_TEST_SUITE_P(Over, RawPublishing, testing::Values("sharedmemory", "ipc", "tcp"), test::TransportName);

class RawPublishingAlone : public testing::Test {
 protected:
  test::Robot robot{"discovery: {local: false}\n"};
};

TEST_F(RawPublishingAlone, RawSubscribersGetTheSameBytesWithoutACopy) {
  Kept<RawMessage> kept;
  const auto subscription = robot->FromAnyRaw("v", kSerial, std::ref(kept), Everything());
  const Payload bytes = VectorBytes(1);
  ASSERT_EQ(robot->ToAnyRaw("v", VectorSchema(), bytes), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return kept.size() == 1; }));
  EXPECT_EQ(kept.messages()[0]->data.bytes.data(), bytes.bytes.data());
  EXPECT_EQ(kept.messages()[0]->schema->fingerprint, TypeOf<Vector>().fingerprint);
  EXPECT_FALSE(kept.remote());
}

TEST_F(RawPublishingAlone, BytesWithoutAnOwnerAreCopied) {
  Kept<RawMessage> kept;
  const auto subscription = robot->FromAnyRaw("t", kSerial, std::ref(kept), Everything());
  std::string text = "one";
  ASSERT_EQ(robot->ToAnyRaw("t", TextSchema(), {AsBytes(text), nullptr}), PublishStatus::kOk);
  text = "two";
  ASSERT_TRUE(Await([&] { return kept.size() == 1; }));
  EXPECT_EQ(AsText(kept.messages()[0]->data.bytes), "one");
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
    EXPECT_EQ(one.messages()[0]->x(), 7);
    EXPECT_EQ(one.messages()[0], two.messages()[0]);
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
  EXPECT_EQ(plain.messages()[0]->data(), "points");
  EXPECT_EQ(AsText(bulk.messages()[0]->bytes()), "points");
  EXPECT_EQ(bulk.messages()[1]->head().frame_id(), "lidar");
}

TEST_F(RawPublishingAlone, CountsBytesThatDoNotDecodeAndDeliversTheNextMessages) {
  Kept<Vector> kept;
  const auto subscription = robot->FromAny<Vector>("v", kSerial, std::ref(kept), Everything());
  const RawPublisher publish = robot->AdvertiseRaw("v", VectorSchema());
  ASSERT_EQ(publish(PayloadOf("\xff\xff\xff")), PublishStatus::kOk);
  ASSERT_EQ(publish(VectorBytes(1)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return kept.size() == 1; }));
  std::uint64_t not_converted = 0;
  for (const ChannelSnapshot& channel : robot->Snapshot().graph.channels) {
    if (channel.name == "v") not_converted = channel.not_converted;
  }
  EXPECT_EQ(not_converted, 1U);
  EXPECT_TRUE(robot.Said("missed a message"));
}

TEST_F(RawPublishingAlone, ReturnsThePayloadToTheCallerWhenASubscriberIsFull) {
  std::mutex door;
  door.lock();
  std::atomic<bool> begun{false};
  Kept<RawMessage> kept;
  const auto subscription =
      robot->FromAnyRaw("t", kSerial,
                        [&](const std::shared_ptr<const RawMessage>& message, const MessageInfo& info) {
                          begun = true;
                          const std::scoped_lock wait(door);
                          kept(message, info);
                        },
                        {.queue = Queue::KeepAll(1)});
  const RawPublisher publish = robot->AdvertiseRaw("t", TextSchema());
  const Payload bytes = PayloadOf("text");
  EXPECT_EQ(publish(bytes), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return begun.load(); }));  // From here on nothing leaves the queue.
  std::size_t taken = 1;
  while (publish(bytes) == PublishStatus::kOk) ++taken;
  EXPECT_EQ(AsText(bytes.bytes), "text");
  EXPECT_EQ(publish(bytes), PublishStatus::kFull);
  door.unlock();
  ASSERT_TRUE(Await([&] { return kept.size() == taken; }));
  EXPECT_EQ(publish(bytes), PublishStatus::kOk);
}

TEST_F(RawPublishingAlone, AdvertisingAnotherTypeThrowsATypeMismatchThatNamesBoth) {
  const auto typed = robot->Advertise<Vector>("v");
  try {
    (void)robot->AdvertiseRaw("v", TextSchema());
    FAIL() << "it was accepted";
  } catch (const TypeMismatch& error) {
    const std::string what = error.what();
    for (const char* part : {"\"v\"", "foxglove.Vector3", "json", "raw_publishing_test.cpp"}) {
      EXPECT_NE(what.find(part), std::string::npos) << what;
    }
  }
  const RawPublisher raw = robot->AdvertiseRaw("t", TextSchema());
  EXPECT_THROW((void)robot->Advertise<Vector>("t"), TypeMismatch);
  EXPECT_THROW((void)robot->FromAny<Vector>("t", kSerial, [](const Vector&) {}), TypeMismatch);
  EXPECT_THROW(robot->ToAnyRaw("t", VectorSchema(), VectorBytes(1)), TypeMismatch);
}

TEST_F(RawPublishingAlone, AnotherLayoutOfOneTypeNameThrowsATypeMismatchWithFingerprints) {
  MessageSchema first{"robot.Pair", Encoding::kPlain, 1, {}};
  MessageSchema second{"robot.Pair", Encoding::kPlain, 0xabc, {}};
  const RawPublisher publish = robot->AdvertiseRaw("p", first);
  try {
    (void)robot->AdvertiseRaw("p", second);
    FAIL() << "it was accepted";
  } catch (const TypeMismatch& error) {
    EXPECT_NE(std::string(error.what()).find("fingerprint 0000000000000abc"), std::string::npos) << error.what();
  }
}

TEST_F(RawPublishingAlone, RefusesSchemasThatDoNotDescribeAType) {
  EXPECT_THROW((void)robot->AdvertiseRaw("v", {}), Error);
  MessageSchema broken = VectorSchema();
  broken.descriptor_set = "no descriptors";
  EXPECT_THROW((void)robot->AdvertiseRaw("v", broken), Error);
  MessageSchema lacking = VectorSchema();
  lacking.type_name = "robot.Missing";
  EXPECT_THROW((void)robot->AdvertiseRaw("v", lacking), Error);
  EXPECT_THROW(robot->ToAnyRaw("hgros/peers", VectorSchema(), VectorBytes(1)), Error);
}

TEST_F(RawPublishingAlone, HandleThatOutlivesItsSessionIsClosed) {
  const RawPublisher publish = robot->AdvertiseRaw("v", VectorSchema());
  robot.session.reset();
  EXPECT_EQ(publish(VectorBytes(1)), PublishStatus::kClosed);
  EXPECT_EQ(RawPublisher()(VectorBytes(1)), PublishStatus::kClosed);
}

}  // namespace
}  // namespace hgros::raw_publishing_test
