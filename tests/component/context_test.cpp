#include "hgros/component/context.hpp"

#include <gmock/gmock.h>

#include <stdexcept>

#include <foxglove/Vector3.pb.h>

#include "component/components_fixture.hpp"
#include "hgros/base/error.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/component/raw_context.hpp"
#include "hgros/params/remote_params.hpp"
#include "hgros/session/clock_publisher.hpp"
#include "hgros/tf/transforms.hpp"

namespace hgros::test {
namespace {

using foxglove::PoseInFrame;
using namespace std::chrono_literals;
using testing::ElementsAre;

// One of each thing that a context gives.
class Everything {
 public:
  explicit Everything(Context& its_context) : context(its_context) {
    context.FromAnyRaw("bytes", Invoke::kSerial, [this](const RawMessage&) { ++raw; });
    context.FromAny<PoseInFrame>("pose", Invoke::kSerial, [this](const PoseInFrame&) { ++first; });
    context.FromAny<PoseInFrame>("pose", Invoke::kSerial, [this](const PoseInFrame&) { ++second; });
    context.FromAny<PoseInFrame>("pose", Invoke::kSerial, [this](const PoseInFrame&) { ++named; }, {.name = "third"});
    context.Serve<PoseInFrame, PoseInFrame>("echo", [](const PoseInFrame& request) {
      if (request.frame_id() == "throw") throw std::runtime_error("no echo");
      return request;
    });
    echo = context.Client<PoseInFrame, PoseInFrame>("echo");
    context.CreateTimer("tick", 1ms, [this](const Tick&) { ++ticks; });
    context.CreateTimer("fails", 1ms, [](const Tick&) { throw std::runtime_error("no tick"); });
  }

  Context& context;
  std::optional<ServiceClient<PoseInFrame, PoseInFrame>> echo;
  std::atomic<int> raw{0};
  std::atomic<int> first{0};
  std::atomic<int> second{0};
  std::atomic<int> named{0};
  std::atomic<int> ticks{0};
};
HGROS_COMPONENT(Everything, "test/Everything")

struct OneParam {
  explicit OneParam(Context& context) { gain = context.Declare("gain", 0.5, {.least = 0, .most = 1}); }
  double gain = 0;
};
HGROS_COMPONENT(OneParam, "test/OneParam")

// A component of another language.
struct Reader {
  explicit Reader(Context& context) {
    RawContext(context).FromAny(
        "pose", SchemaOf(TypeOf<PoseInFrame>()), Invoke::kSerial, [this](const RawMessage& raw) {
          PoseInFrame pose;
          if (raw.schema && raw.schema->type_name == "foxglove.PoseInFrame" &&
              pose.ParseFromArray(raw.data.bytes.data(), static_cast<int>(raw.data.bytes.size()))) {
            frames += pose.frame_id();
          }
          ++read;
        });
  }
  std::string frames;  // Up to `read`.
  std::atomic<int> read{0};
};
HGROS_COMPONENT(Reader, "test/Reader")

struct Simulation {
  explicit Simulation(Context& context) : published(context.PublishClock(clock)) {}
  std::shared_ptr<SimulatedClock> clock = SimulatedClock::Paused();
  std::unique_ptr<ClockPublisher> published;
};
HGROS_COMPONENT(Simulation, "test/Simulation")

struct Declares {
  explicit Declares(Context& its_context) : context(its_context) { (void)context.transforms(); }
  Context& context;
};
HGROS_COMPONENT(Declares, "test/Declares")

Everything& AddTo(Process& process, const ComponentSetup& setup = {.name = "all", .type = "test/Everything"}) {
  process.components->Add(setup);
  return *process.components->Find<Everything>("all");
}

TEST(Context, NamesNodesAfterTheComponent) {
  Process process;
  (void)AddTo(process);
  const ComponentDescription& description = process.components->description("all");
  std::vector<std::string> nodes;
  for (const ComponentChannel& one : description.inputs) nodes.push_back(one.node);
  EXPECT_THAT(nodes, ElementsAre("all/bytes", "all/pose", "all/pose#2", "all/third"));
  EXPECT_EQ(description.inputs[0].type, "") << "any";
  ASSERT_EQ(description.services.size(), 1U);
  EXPECT_EQ(description.services[0].request, "foxglove.PoseInFrame");
  ASSERT_EQ(description.timers.size(), 2U);
  EXPECT_EQ(description.timers[0].period, Duration(1ms));
}

// In either order, and from this session as from another one.
TEST(Context, ATypeKnownAtRunTimeMeetsTheSameTypeInCpp) {
  for (const bool first : {true, false}) {
    Session other(Config::Parse(
        "{discovery: {domain: none}, network: {publisher: {ip: 'tcp://127.0.0.1:*', channels: [pose]}}}"));
    Process process("network: {subscribers: [{ip: '" + other.PublisherEndpoints().at(0) + "', channels: [pose]}]}");
    if (first) process.components->Add({.name = "reader", .type = "test/Reader"});
    const Everything& all = AddTo(process);
    if (!first) process.components->Add({.name = "reader", .type = "test/Reader"});
    process.Run();
    const Reader& reader = *process.components->Find<Reader>("reader");
    PoseInFrame pose;
    pose.set_frame_id("a");
    EXPECT_EQ(process.session.ToAny("pose", pose), PublishStatus::kOk);
    pose.set_frame_id("b");
    (void)other.Advertise<PoseInFrame>("pose");
    ASSERT_TRUE(other.WaitForSubscribers("pose", 1, kPatience));
    EXPECT_EQ(other.ToAny("pose", pose), PublishStatus::kOk);
    EXPECT_TRUE(Await([&] { return all.first == 2 && all.named == 2 && reader.read == 2; }));
    EXPECT_EQ(reader.frames, "ab") << first;
    EXPECT_EQ(all.raw, 0);
  }
}

TEST(Context, MessagesOfAnotherTypeComeToNoTypeKnownAtRunTime) {
  Session other(
      Config::Parse("{discovery: {domain: none}, network: {publisher: {ip: 'tcp://127.0.0.1:*', channels: [pose]}}}"));
  Process process("network: {subscribers: [{ip: '" + other.PublisherEndpoints().at(0) + "', channels: [pose]}]}");
  process.components->Add({.name = "reader", .type = "test/Reader"});
  process.Run();
  const auto seen = std::make_shared<std::atomic<int>>(0);
  const auto all = process.session.FromAnyRaw("pose", Invoke::kSerial, [seen](const RawMessage&) { ++*seen; });
  const auto publisher = other.Advertise<foxglove::Vector3>("pose");
  ASSERT_TRUE(other.WaitForSubscribers("pose", 1, kPatience));
  EXPECT_EQ(publisher(foxglove::Vector3()), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return *seen == 1; }));
  EXPECT_TRUE(process.session.WaitIdle(kPatience));
  EXPECT_EQ(process.components->Find<Reader>("reader")->read, 0);
  EXPECT_EQ(process.Status("reader").exceptions, 0U);
}

TEST(Context, RunsTimersOnlyOnceTheComponentRuns) {
  Process process;
  Everything& all = AddTo(process);
  process.components->Join();
  Linger(20ms);
  EXPECT_EQ(all.ticks, 0);
  process.components->Start();
  EXPECT_TRUE(Await([&] { return all.ticks > 3; }));
}

TEST(Context, TellsExceptionsOfTimersAndHandlers) {
  Process process;
  (void)AddTo(process);
  process.components->Join();
  PoseInFrame request;
  request.set_frame_id("throw");
  EXPECT_FALSE((process.session.Call<PoseInFrame, PoseInFrame>("echo", request, 5s).Wait()));
  EXPECT_EQ(process.Status("all").exception, "no echo");
  process.components->Start();
  EXPECT_TRUE(Await([&] { return process.Status("all").exception == "no tick"; }));
}

TEST(Context, RenamesServices) {
  Process process;
  Everything& all = AddTo(process, {.name = "all", .type = "test/Everything", .remap = {{"echo", "cave/echo"}}});
  process.Run();
  EXPECT_TRUE(bool(process.session.Call<PoseInFrame, PoseInFrame>("cave/echo", PoseInFrame(), 5s).Wait()));
  EXPECT_TRUE(bool(all.echo->Call(PoseInFrame(), 5s).Wait()));
  EXPECT_EQ(process.components->description("all").calls.at(0).service, "cave/echo");
}

TEST(Context, TakesQueueAndExecutorFromTheSetup) {
  Process process("", false);
  ComponentSetup setup{.name = "all", .type = "test/Everything"};
  setup.nodes["pose#2"] = {.queue = Queue::KeepAll(7), .executor = Executor::Dedicated()};
  (void)AddTo(process, setup);
  process.components->Join();
  const SessionSnapshot snapshot = process.session.Snapshot();
  bool found = false;
  for (const ChannelSnapshot& channel : snapshot.graph.channels) {
    for (const NodeSnapshot& node : channel.nodes) {
      if (node.name != "all/pose#2") continue;
      found = true;
      EXPECT_EQ(node.queue.depth(), 7U);
    }
  }
  EXPECT_TRUE(found);
}

TEST(Context, SubscribesAtOnceInACallback) {
  Process process;
  Everything& all = AddTo(process);
  process.Run();
  std::atomic<int> late{0};
  all.context.FromAny<PoseInFrame>("late", Invoke::kSerial, [&](const PoseInFrame&) { ++late; });
  (void)process.session.ToAny("late", PoseInFrame());
  EXPECT_EQ(late, 1);
  process.components->End("all");
}

TEST(Context, SharesOneTransformTree) {
  Process process;
  Everything& all = AddTo(process);
  process.components->Add({.name = "other", .type = "test/Everything"});
  Everything& other = *process.components->Find<Everything>("other");
  (void)all.context.transforms().ToStaticTF("map", "base", RigidTransform());
  EXPECT_TRUE(other.context.transforms().FromTF("map", "base"));
}

TEST(Context, KnowsWhetherTransformsAreDeclared) {
  std::vector<std::string> undeclared;  // Each report.
  Robot robot("");
  Components components(*robot.session, {.on_change = [&](const ComponentStatus& status) {
    if (status.undeclared_transforms) undeclared.push_back(status.name);
  }});
  EXPECT_TRUE(components.Add({.name = "declares", .type = "test/Declares"}).transforms);
  EXPECT_FALSE(components.Add({.name = "all", .type = "test/Everything"}).transforms);
  (void)components.Find<Declares>("declares")->context.transforms();
  EXPECT_THAT(undeclared, ElementsAre());
  for (int i = 0; i < 2; ++i) (void)components.Find<Everything>("all")->context.transforms();
  EXPECT_THAT(undeclared, ElementsAre("all"));
  EXPECT_FALSE(components.description("all").transforms);
}

TEST(Context, OffersParametersUnderTheComponentsName) {
  Process process("", false);
  process.components->Add({.name = "controller", .type = "test/OneParam"});
  process.Run();
  RemoteParams remote(process.session, "controller", 10s);
  EXPECT_TRUE(remote.Set("gain", 0.75).ok());
  EXPECT_FALSE(remote.Set("gain", 75.0).ok());
}

TEST(Context, PublishesAClockThatTheSessionFollows) {
  Process process("time: simulated");
  const ComponentDescription& used = process.components->Add({.name = "simulation", .type = "test/Simulation"});
  ASSERT_EQ(used.outputs.size(), 1U);
  EXPECT_EQ(used.outputs.front().channel, kClockChannel);
  process.Run();
  process.components->Find<Simulation>("simulation")->clock->JumpTo(Time{42});
  EXPECT_TRUE(Await([&] { return process.session.clock()->Now() == Time{42}; }));
  EXPECT_THROW(
      (void)process.components->Add({.name = "other", .type = "test/Simulation", .remap = {{"clock", "time"}}}), Error);
}

TEST(Context, WritesLinesWithTheComponentsName) {
  Process process;
  AddTo(process).context.log().Write(LogLevel::kInfo, "Hello.");
  EXPECT_THAT(process.lines(), ElementsAre("all|Hello."));
}

}  // namespace
}  // namespace hgros::test
