// Services and callers whose types are known only at run time.
#include <future>
#include <stdexcept>

#include <foxglove/Vector3.pb.h>

#include "hgros/codec/run_time_type.hpp"
#include "services/services_fixture.hpp"

namespace hgros::test {
namespace {

using foxglove::Vector3;

MessageSchema SchemaOfVector() { return SchemaOf(TypeOf<Vector3>()); }
MessageSchema SchemaOfNote() { return SchemaOf(TypeOf<Note>()); }

Vector3 At(double x) {
  Vector3 vector;
  vector.set_x(x);
  return vector;
}

Payload Owned(std::string text) { return OwnedPayload({AsBytes(text), nullptr}); }

Vector3 Twice(const Vector3& vector) { return At(2 * vector.x()); }

Payload TwiceRaw(const RawMessage& request) {
  Vector3 vector;
  if (!vector.ParseFromString(std::string(AsText(request.data.bytes)))) throw std::runtime_error("no vector");
  return Owned(Twice(vector).SerializeAsString());
}

double XOfReply(const CallResult<RawMessage>& result) {
  Vector3 vector;
  EXPECT_TRUE(result) << result.failure().reason;
  if (result) {
    EXPECT_TRUE(vector.ParseFromString(std::string(AsText(result->data.bytes))));
  }
  return vector.x();
}

class RawServices : public PairFixture {};

TEST_P(RawServices, TypedAndRawClientsCallARawServer) {
  std::atomic<bool> schema_fits{false};
  const Service service =
      pair->server().ServeRaw("twice", SchemaOfVector(), SchemaOfVector(), [&](const RawMessage& request) {
        schema_fits = request.schema && *request.schema == SchemaOfVector();
        return TwiceRaw(request);
      });
  for (int i = 0; i < 3; ++i) {
    const auto result = pair->caller().Call<Vector3, Vector3>("twice", At(i), kLong).Wait();
    ASSERT_TRUE(result) << result.failure().reason;
    EXPECT_EQ(result->x(), 2 * i);
  }
  EXPECT_TRUE(schema_fits);
  std::atomic<double> x{0};
  const auto ticket =
      pair->caller().CallRaw("twice", SchemaOfVector(), Owned(At(5).SerializeAsString()), SchemaOfVector(), kLong,
                             [&](const CallResult<RawMessage>& result) { x = XOfReply(result); });
  EXPECT_TRUE(Await([&] { return x == 10; }));
}

// The only worker waits, as one does in a callback that waits for something of this program.
TEST(RawCalls, AnInlineCallbackNeedsNoWorker) {
  Session robot(Config::Parse("{discovery: {domain: none}, data_graph: {threads: 1}}"));
  const Service service = robot.ServeRaw("twice", SchemaOfVector(), SchemaOfVector(), TwiceRaw, Invoke::kConcurrent,
                                         {.executor = Executor::Dedicated()});
  std::promise<void> go;
  std::atomic<bool> waits{false};
  const auto node = robot.FromGraph<Vector3>("stop", Invoke::kSerial, [&](const Vector3&) {
    waits = true;
    go.get_future().wait();
  });
  ASSERT_EQ(robot.ToGraph("stop", std::make_unique<Vector3>(At(0))), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return waits.load(); }));
  std::promise<double> answered;
  std::promise<CallFailure::Kind> late;
  const Payload request = Owned(At(5).SerializeAsString());
  const auto ticket = robot.CallRaw(
      "twice", SchemaOfVector(), request, SchemaOfVector(), kLong,
      [&](const CallResult<RawMessage>& result) { answered.set_value(XOfReply(result)); }, Executor::Inline());
  EXPECT_EQ(answered.get_future().get(), 10);
  const auto other = robot.CallRaw(
      "nobody", SchemaOfVector(), request, {}, std::chrono::milliseconds(1),
      [&](const CallResult<RawMessage>& result) { late.set_value(result.failure().kind); }, Executor::Inline());
  EXPECT_EQ(late.get_future().get(), CallFailure::Kind::kNoServer);
  EXPECT_THROW(
      (void)robot.CallRaw(
          "twice", SchemaOfVector(), request, {}, kLong, [](const CallResult<RawMessage>&) {}, Executor::Dedicated()),
      Error);
  go.set_value();
}

TEST_P(RawServices, RawAndTypedCallsOfOneSessionUseOneTypedService) {
  const Service service = pair->server().Serve<Vector3, Vector3>("twice", Twice);
  const Payload request = Owned(At(4).SerializeAsString());
  const auto call_typed = [&](double x) {
    const auto result = pair->caller().Call<Vector3, Vector3>("twice", At(x), kLong).Wait();
    return result ? result->x() : -1;
  };
  EXPECT_EQ(call_typed(1), 2);
  for (const MessageSchema& wanted : {MessageSchema(), SchemaOfVector()}) {  // Any, or this one.
    const auto result = pair->caller().CallRaw("twice", SchemaOfVector(), request, wanted, kLong).Wait();
    ASSERT_EQ(XOfReply(result), 8);
    EXPECT_EQ(result->schema->type_name, "foxglove.Vector3");
    EXPECT_FALSE(result->schema->descriptor_set.empty());
    if (wanted == SchemaOfVector()) {
      EXPECT_EQ(*result->schema, SchemaOfVector());
    }
  }
  EXPECT_EQ(call_typed(2), 4);
}

TEST_P(RawServices, TypedCallsGoThroughAClientThatWasRawFirst) {
  const Service twice = pair->server().Serve<Vector3, Vector3>("twice", Twice);
  const Payload request = Owned(At(4).SerializeAsString());
  ASSERT_EQ(XOfReply(pair->caller().CallRaw("twice", SchemaOfVector(), request, SchemaOfVector(), kLong).Wait()), 8);
  EXPECT_EQ((pair->caller().Call<Vector3, Vector3>("twice", At(1), kLong).Wait()->x()), 2);
  const Service service = pair->server().Serve<Note, Note>("echo", [](const Note& note) { return note; });
  const auto raw = pair->caller().CallRaw("echo", SchemaOfNote(), Owned("one"), {}, kLong).Wait();
  ASSERT_TRUE(raw) << raw.failure().reason;
  EXPECT_EQ(AsText(raw->data.bytes), "one");
  const auto typed = pair->caller().Call<Note, Note>("echo", Note("two"), kLong).Wait();
  ASSERT_TRUE(typed) << typed.failure().reason;
  EXPECT_EQ(typed->text, "two");
}

TEST_P(RawServices, ReportWhatTheHandlerThrewOtherTypesAndBytesThatDoNotParse) {
  const Service fail = pair->server().ServeRaw(
      "fail", SchemaOfNote(), SchemaOfNote(), [](const RawMessage&) -> Payload { throw std::runtime_error("no way"); });
  const Service twice = pair->server().Serve<Vector3, Vector3>("twice", Twice);
  const Service other = pair->server().Serve<Vector3, Vector3>("other", Twice);  // A session calls each with one type.
  const Service broken = pair->server().ServeRaw("broken", SchemaOfVector(), SchemaOfVector(),
                                                 [](const RawMessage&) { return Owned("\xff\xff"); });
  const auto failure = [&](const char* service, const MessageSchema& schema, const char* bytes) {
    const auto result = pair->caller().CallRaw(service, schema, Owned(bytes), {}, kLong).Wait();
    EXPECT_FALSE(result) << service;
    return result.failure();
  };
  const CallFailure thrown = failure("fail", SchemaOfNote(), "x");
  EXPECT_EQ(thrown.kind, Kind::kHandlerFailed);
  EXPECT_EQ(thrown.reason, "no way");
  EXPECT_EQ(failure("twice", SchemaOfNote(), "x").kind, Kind::kTypeMismatch);
  EXPECT_EQ(failure("other", SchemaOfVector(), "\xff\xff").kind, Kind::kNotWritable);
  const auto reply = pair->caller().Call<Vector3, Vector3>("broken", At(1), kLong).Wait();
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.failure().kind, Kind::kNotWritable) << reply.failure().reason;
}

INSTANTIATE_TEST_SUITE_P(Over, RawServices, testing::Values("pointer", "sharedmemory", "ipc", "tcp"), TransportName);

TEST(RawServicesAlone, CallWithoutAServerFailsLikeATypedCall) {
  Robot robot("discovery: {local: false}\n");
  const auto result = robot->CallRaw("nobody", SchemaOfVector(), {}, {}, kLong).Wait();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.failure().kind, Kind::kNoServer);
  EXPECT_THROW((void)robot->CallRaw("nobody", {}, {}, {}, kLong), Error);
}

}  // namespace
}  // namespace hgros::test
