#include <array>

#include <foxglove/Point3.pb.h>
#include <foxglove/RawImage.pb.h>
#include <foxglove/Vector3.pb.h>

#include "graph/graph_core.hpp"
#include "graph/graph_fixture.hpp"
#include "hgros/base/error.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/codec/raw_message.hpp"

namespace hgros::test::raw_forms_test {
namespace {

using foxglove::Point3;
using foxglove::Vector3;

constexpr Invoke kSerial = Invoke::kSerial;

using KeptRaw = KeptMessages<RawMessage>;

Subscription Raw(DataGraph& graph, std::string_view channel, KeptRaw& kept, NodeOptions options = {}) {
  return graph.Subscribe(graph.Open(channel, AnyType(), CallSite::Current()), AnyType(), kSerial,
                         EraseCallback<RawMessage>(std::ref(kept)), std::move(options));
}

std::shared_ptr<const MessageSchema> VectorSchema() {
  static const auto schema = std::make_shared<const MessageSchema>(SchemaOf(TypeOf<Vector3>()));
  return schema;
}

Vector3 Vector(double x) {
  Vector3 vector;
  vector.set_x(x);
  return vector;
}

std::unique_ptr<Vector3> Sent(double x) { return std::make_unique<Vector3>(Vector(x)); }

double XOf(const RawMessage& message) {
  Vector3 vector;
  EXPECT_TRUE(vector.ParseFromString(std::string(AsText(message.data.bytes))));
  return vector.x();
}

/// A message as it comes from a transport.
AnyMessage Arrived(std::shared_ptr<const MessageSchema> schema, const std::string& bytes) {
  auto owner = std::make_shared<const std::string>(bytes);
  const Bytes view = AsBytes(*owner);
  return std::make_shared<const RawMessage>(RawMessage{std::move(schema), {view, std::move(owner)}});
}

bool Inject(DataGraph& graph, std::string_view channel, AnyMessage message, std::size_t latched = 0) {
  MessageInfo info;
  info.id = {7, 1, 1};
  return DataGraph::Inject(graph.Open(channel, AnyType(), CallSite::Current()), message, AnyType(), info, nullptr,
                           latched);
}

TEST(RawForms, RawNodesGetTheBytesThatWouldBeSentEncodedOnceForAll) {
  for (const Executor& executor : AllExecutors()) {
    DataGraph graph;
    std::array<KeptRaw, 3> kept;
    KeptMessages<Vector3> typed;
    std::vector<Subscription> subscriptions;
    for (KeptRaw& one : kept) subscriptions.push_back(Raw(graph, "v", one, Options(executor)));
    subscriptions.push_back(graph.FromGraph<Vector3>("v", kSerial, std::ref(typed), Options(executor)));
    for (int i = 0; i < 5; ++i) graph.ToGraph("v", Sent(i));
    ASSERT_TRUE(WaitIdle(graph));
    EXPECT_EQ(graph.Snapshot().channels.at(0).converted, 5U);
    const auto raw = kept[0].messages();
    for (const KeptRaw& one : kept) {
      ASSERT_EQ(one.messages().size(), 5U);
      EXPECT_EQ(one.messages()[4], raw[4]) << "the same object";
      EXPECT_EQ(XOf(*one.messages()[4]), 4);
    }
    EXPECT_EQ(XOf(*raw[1]), 1);
    EXPECT_EQ(*raw[0]->schema, SchemaOf(TypeOf<Vector3>()));
    EXPECT_EQ(raw[0]->schema, raw[1]->schema) << "one object for all";
    ASSERT_EQ(typed.messages().size(), 5U);
    EXPECT_EQ(typed.messages()[4]->x(), 4);
  }
}

TEST(RawForms, NodesExpectOneFormAgainWhenTheLastObserverHasGone) {
  const auto core = std::make_shared<GraphCore>(GraphOptions{}, std::make_shared<hgros::Log>());
  Channel& channel = core->Open("v", TypeOf<Vector3>(), CallSite::Current());
  const auto add = [&](const TypeInfo& type) {
    return core->Subscribe(
        channel, type, kSerial, [](const AnyMessage&, const MessageInfo&) {}, Options(Executor::Inline()));
  };
  const auto publish = [&] {
    Publish(channel, OfferOf<Vector3>(std::make_shared<const Vector3>(Vector(1))), Reach::kGraph);
  };
  const auto typed = add(TypeOf<Vector3>());
  for (int round = 0; round < 3; ++round) {
    EXPECT_FALSE(typed->expects_two_forms());
    const auto raw = add(AnyType());
    EXPECT_TRUE(typed->expects_two_forms());
    AnyMessage arrived = Arrived(VectorSchema(), Vector(2).SerializeAsString());
    (void)channel.Inject(arrived, AnyType(), MessageInfo{}, nullptr, 0, UserCode::kAllowed);
    publish();
    EXPECT_TRUE(typed->expects_two_forms()) << "an observer is there";
    channel.Remove(*raw);
    publish();
    EXPECT_FALSE(typed->expects_two_forms());
    // A message that a transport has taken in raw before.
    (void)channel.Inject(std::move(arrived), AnyType(), MessageInfo{}, nullptr, 0, UserCode::kAllowed);
    EXPECT_TRUE(typed->expects_two_forms());
    publish();
  }
  core->Shutdown();
}

TEST(RawForms, TypedNodesReadRawMessagesWhileObserversComeAndGo) {
  for (const Executor& executor : AllExecutors()) {
    DataGraph graph;
    std::atomic<int> wrong{0};
    std::atomic<int> typed{0};
    const auto check_x = [&](const Vector3& vector) {
      wrong += vector.x() == 7 ? 0 : 1;
      ++typed;
    };
    const auto subscription =
        graph.FromGraph<Vector3>("v", kSerial, check_x, Options(executor, Queue::KeepAll(100'000)));
    std::atomic<bool> stop{false};
    std::jthread arriving([&] {
      const std::string bytes = Vector(7).SerializeAsString();
      while (!stop) Inject(graph, "v", Arrived(VectorSchema(), bytes));
    });
    std::jthread publishing([&] {
      while (!stop) graph.ToGraph("v", Sent(7));
    });
    const auto more_arrive = [&] {
      const int before = typed;
      return Await([&] { return typed > before + 10; });
    };
    for (int round = 0; round < 50; ++round) {
      KeptRaw first, second;
      {
        const auto one = Raw(graph, "v", first, Options(Executor::Inline()));
        const auto two = Raw(graph, "v", second, Options(Executor::Inline()));
        EXPECT_TRUE(more_arrive());
      }
      EXPECT_TRUE(more_arrive());
    }
    stop = true;
    arriving.join();
    publishing.join();
    ASSERT_TRUE(WaitIdle(graph));
    EXPECT_EQ(wrong, 0);
  }
}

TEST(RawForms, RawNodeDoesNotFixTheTypeOfTheChannel) {
  DataGraph graph;
  KeptRaw raw;
  const auto subscription = Raw(graph, "v", raw);
  EXPECT_EQ(graph.Snapshot().channels.at(0).type, "");
  graph.ToGraph("v", Sent(1));
  EXPECT_EQ(graph.Snapshot().channels.at(0).type, "foxglove.Vector3");
  EXPECT_THROW((void)graph.Advertise<Point3>("v"), TypeMismatch);
  ASSERT_TRUE(WaitIdle(graph));
  EXPECT_EQ(raw.messages().size(), 1U);
}

TEST(RawForms, TypedNodesGetRemoteBytesDecoded) {
  DataGraph graph;
  KeptRaw raw;
  KeptMessages<Vector3> typed;
  const auto one = Raw(graph, "v", raw);
  const AnyMessage first = Arrived(VectorSchema(), Vector(1).SerializeAsString());
  ASSERT_TRUE(Inject(graph, "v", first));
  const auto two = graph.FromGraph<Vector3>("v", kSerial, std::ref(typed));
  EXPECT_TRUE(IsAnyType(DataGraph::InboundType(graph.Open("v", AnyType(), CallSite::Current()))));
  ASSERT_TRUE(Inject(graph, "v", Arrived(VectorSchema(), Vector(2).SerializeAsString())));
  ASSERT_TRUE(WaitIdle(graph));
  ASSERT_EQ(raw.messages().size(), 2U);
  EXPECT_EQ(raw.messages()[0].get(), first.get()) << "the message was copied";
  ASSERT_EQ(typed.messages().size(), 1U);
  EXPECT_EQ(typed.messages()[0]->x(), 2);
}

TEST(RawForms, TypedNodesGetNoMessagesOfAnotherType) {
  Heard heard;
  DataGraph graph({}, heard.MakeLog());
  KeptRaw raw;
  KeptMessages<Vector3> typed;
  const auto one = Raw(graph, "v", raw);
  const auto two = graph.FromGraph<Vector3>("v", kSerial, std::ref(typed), {.name = "typed"});
  ASSERT_TRUE(Inject(graph, "v", Arrived(std::make_shared<const MessageSchema>(SchemaOf(TypeOf<Point3>())), "")));
  ASSERT_TRUE(Inject(graph, "v", Arrived(VectorSchema(), "\xff")));
  ASSERT_TRUE(WaitIdle(graph));
  EXPECT_EQ(raw.messages().size(), 2U);
  EXPECT_TRUE(typed.messages().empty());
  EXPECT_EQ(graph.Snapshot().channels.at(0).not_converted, 2U);
  EXPECT_TRUE(heard.Contains("Node \"typed\" on channel \"v\" missed a message"));
}

TEST(RawForms, LateRawNodeGetsLatchedRemoteBytesAndLocalMessages) {
  DataGraph graph;
  KeptRaw raw, late;
  KeptMessages<Vector3> typed;
  const auto one = Raw(graph, "v", raw);
  ASSERT_TRUE(Inject(graph, "v", Arrived(VectorSchema(), Vector(3).SerializeAsString()), 1));
  const auto two = graph.FromGraph<Vector3>("v", kSerial, std::ref(typed));
  const auto three = Raw(graph, "v", late);
  ASSERT_TRUE(WaitIdle(graph));
  ASSERT_EQ(typed.messages().size(), 1U);
  EXPECT_EQ(typed.messages()[0]->x(), 3);
  EXPECT_EQ(late.messages(), raw.messages());
  const auto publish = graph.Advertise<Vector3>("local", 1);
  publish(Sent(4));
  KeptRaw local;
  const auto four = Raw(graph, "local", local);
  ASSERT_TRUE(WaitIdle(graph));
  ASSERT_EQ(local.messages().size(), 1U);
  EXPECT_EQ(XOf(*local.messages()[0]), 4);
}

TEST(RawForms, PlainBulkAndRawSubscribersShareOneChannel) {
  using Image = foxglove::RawImage;
  DataGraph graph;
  KeptRaw raw;
  KeptMessages<Image> plain;
  KeptMessages<Bulk<Image>> bulk;
  const auto one = Raw(graph, "image", raw);
  const auto two = graph.FromGraph<Image>("image", kSerial, std::ref(plain));
  const auto three = graph.FromGraph<Bulk<Image>>("image", kSerial, std::ref(bulk));
  Image image;
  image.set_data("abc");
  graph.ToGraph("image", std::make_unique<Image>(image));
  const auto of_image = std::make_shared<const MessageSchema>(SchemaOf(TypeOf<Image>()));
  ASSERT_TRUE(Inject(graph, "image", Arrived(of_image, image.SerializeAsString())));
  ASSERT_TRUE(WaitIdle(graph));
  ASSERT_EQ(raw.messages().size(), 2U);
  ASSERT_EQ(plain.messages().size(), 2U);
  ASSERT_EQ(bulk.messages().size(), 2U);
  for (const auto& one_plain : plain.messages()) EXPECT_EQ(one_plain->data(), "abc");
  for (const auto& one_bulk : bulk.messages()) EXPECT_EQ(AsText(one_bulk->bytes()), "abc");
}

TEST(RawForms, LocalTypesHaveNoBytes) {
  struct Local {
    std::vector<int> values;
  };
  DataGraph graph;
  KeptRaw raw;
  const auto one = Raw(graph, "local", raw);
  graph.ToGraph("local", std::make_unique<Local>());
  ASSERT_TRUE(WaitIdle(graph));
  EXPECT_TRUE(raw.messages().empty());
  EXPECT_EQ(graph.Snapshot().channels.at(0).not_converted, 1U);
}

// Typed and raw nodes are added while messages are published and arrive.
TEST(RawForms, NodesCanBeAddedDuringPublishing) {
  for (int round = 0; round < 20; ++round) {
    DataGraph graph;
    KeptRaw first;
    const auto raw = Raw(graph, "v", first, Options(Executor::Tbb(), Queue::KeepAll(2000)));
    std::jthread arrives([&] {
      for (int i = 0; i < 200; ++i)
        ASSERT_TRUE(Inject(graph, "v", Arrived(VectorSchema(), Vector(1).SerializeAsString())));
    });
    std::jthread publishes([&] {
      for (int i = 0; i < 200; ++i) ASSERT_EQ(graph.ToGraph("v", Sent(1)), PublishStatus::kOk);
    });
    std::vector<KeptMessages<Vector3>> typed(5);
    std::vector<Subscription> subscriptions;
    for (auto& one : typed) {
      subscriptions.push_back(
          graph.FromGraph<Vector3>("v", kSerial, std::ref(one), Options(Executor::Tbb(), Queue::KeepAll(2000))));
    }
    arrives.join();
    publishes.join();
    ASSERT_TRUE(WaitIdle(graph));
    EXPECT_EQ(first.messages().size(), 400U);
    for (const auto& one : typed) {
      for (const auto& message : one.messages()) ASSERT_EQ(message->x(), 1);
    }
  }
}

}  // namespace
}  // namespace hgros::test::raw_forms_test
