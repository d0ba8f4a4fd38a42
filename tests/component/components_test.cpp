#include "hgros/component/components.hpp"

#include <gmock/gmock.h>

#include <stdexcept>

#include <foxglove/FrameTransform.pb.h>

#include "component/components_fixture.hpp"
#include "support/error_of.hpp"

namespace hgros::test {
namespace {

using foxglove::PoseInFrame;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

// What components of these tests did, in order.
std::vector<std::string>& Deeds() {
  static std::vector<std::string> deeds;
  return deeds;
}

PoseInFrame PoseIn(const std::string& frame) {
  PoseInFrame pose;
  pose.set_frame_id(frame);
  return pose;
}

// Counts poses, publishes each again with the number, and can go on elsewhere.
class Counter {
 public:
  explicit Counter(Context& context)
      : context_(context),
        step_(context.Declare("step", 1, {.least = 1, .most = 100})),
        counted_(context.Advertise<PoseInFrame>("counted")) {
    context.FromAny<PoseInFrame>("pose", Invoke::kSerial, [this](const PoseInFrame& pose) { Take(pose); });
  }
  ~Counter() { Deeds().push_back(context_.name() + " ends"); }
  Counter(const Counter&) = delete;
  Counter& operator=(const Counter&) = delete;

  void Activate() { Deeds().push_back(context_.name() + " is active"); }
  void Deactivate() { Deeds().push_back(context_.name() + " is not active"); }
  PoseInFrame Save() {
    if (count < 0) throw count;
    return PoseIn(std::to_string(count));
  }
  void Restore(const PoseInFrame& state) { count = std::stoi(state.frame_id()); }

  int count = 0;
  Door door;

 private:
  void Take(const PoseInFrame& pose) {
    if (pose.frame_id() == "throw") throw std::runtime_error("no such pose");
    if (pose.frame_id() == "slow") Linger(std::chrono::milliseconds(300));
    if (pose.frame_id() == "door") door.Pass();
    if (pose.frame_id() == "finish") context_.Finish("counted " + std::to_string(count));
    if (pose.frame_id() == "fail") context_.Fail("it does not like this pose");
    count += step_;
    (void)counted_(std::make_unique<PoseInFrame>(PoseIn(std::to_string(count))));
  }
  Context& context_;
  const int step_;
  Publisher<PoseInFrame> counted_;
};
HGROS_COMPONENT(Counter, "test/Counter")

struct Broken {
  explicit Broken(Context&) { throw std::runtime_error("there is no camera"); }
};
HGROS_COMPONENT(Broken, "test/Broken")

struct WillNotStart {
  explicit WillNotStart(Context&) {}
  static void Activate() { throw std::runtime_error("the motor does not answer"); }
  static void Deactivate() { Deeds().push_back("what was not active is not active"); }
};
HGROS_COMPONENT(WillNotStart, "test/WillNotStart")

struct FailsAtOnce {
  explicit FailsAtOnce(Context& context) { context.Fail("it lacks a battery"); }
};
HGROS_COMPONENT(FailsAtOnce, "test/FailsAtOnce")

// Its Deactivate() returns a while after two others have been deactivated.
std::atomic<int> deactivated{0};
struct EndsLast {
  explicit EndsLast(Context&) {}
  static void Deactivate() {
    EXPECT_TRUE(Await([] { return deactivated == 2; }));
    Linger(std::chrono::milliseconds(50));
  }
};
HGROS_COMPONENT(EndsLast, "test/EndsLast")

// Its Activate(), too.
std::atomic<bool> begins{false};
struct BeginsLong {
  explicit BeginsLong(Context&) {}
  static void Activate() {
    begins = true;
    EndsLast::Deactivate();
  }
};
HGROS_COMPONENT(BeginsLong, "test/BeginsLong")

std::atomic<int> late_commands{0};
class Motor {
 public:
  explicit Motor(Context& context) {
    context.CreateTimer("command", std::chrono::milliseconds(1),
                        [this](const Tick&) { late_commands += off_ ? 1 : 0; });
  }
  void Deactivate() {
    off_ = true;
    ++deactivated;
  }

 private:
  std::atomic<bool> off_{false};
};
HGROS_COMPONENT(Motor, "test/Motor")

struct Timed {
  explicit Timed(Context& context) : time(context.Declare("time", 1)) {}
  int time;
};
HGROS_COMPONENT(Timed, "test/Timed")

ComponentSetup CounterNamed(const std::string& name) { return {.name = name, .type = "test/Counter"}; }

ComponentSetup WithParam(const std::string& path, const std::string& value) {
  ComponentSetup setup = CounterNamed("counter");
  setup.params.overrides = {{path, value, "robot.yaml:7:3"}};
  return setup;
}

// It runs one Counter.
struct CountingProcess : Process {
  explicit CountingProcess(const ComponentSetup& setup = CounterNamed("counter"))
      : description(components->Add(setup)), counter(*components->Find<Counter>(setup.name)) {
    Run();
  }
  void Publish(const std::string& frame) { (void)session.ToAny("pose", PoseIn(frame)); }
  const ComponentDescription& description;
  Counter& counter;
};

TEST(Components, ReceiveOnlyOnceTheyHaveJoined) {
  Process process;
  process.components->Add(CounterNamed("counter"));
  const auto& counter = *process.components->Find<Counter>("counter");
  (void)process.session.ToAny("pose", PoseIn("a"));
  EXPECT_EQ(counter.count, 0);
  process.components->Join();
  (void)process.session.ToAny("pose", PoseIn("b"));
  EXPECT_EQ(counter.count, 1);
}

TEST(Components, AreActivatedInOrderAndEndInReverseOrder) {
  for (const bool started : {true, false}) {
    SCOPED_TRACE(started);
    Deeds().clear();
    Process process;
    for (const char* name : {"a", "b"}) process.components->Add(CounterNamed(name));
    process.components->Join();
    EXPECT_TRUE(Deeds().empty());
    if (started) {
      process.components->Start();
      EXPECT_EQ(process.Status("b").state, ComponentState::kRunning);
    }
    process.components.reset();
    if (started) {
      EXPECT_THAT(Deeds(),
                  ElementsAre("a is active", "b is active", "b is not active", "b ends", "a is not active", "a ends"));
    } else {
      EXPECT_THAT(Deeds(), ElementsAre("b ends", "a ends"));
    }
  }
}

TEST(Components, AreDeactivatedWhileOthersDoNotEnd) {
  deactivated = late_commands = 0;
  Process process;
  process.components->Add({.name = "left", .type = "test/Motor"});
  process.components->Add({.name = "hangs_too", .type = "test/EndsLast"});
  process.components->Add({.name = "right", .type = "test/Motor"});
  process.components->Add({.name = "hangs", .type = "test/EndsLast"});
  process.Run();
  process.components.reset();
  EXPECT_EQ(deactivated, 2) << "once each";
  EXPECT_LE(late_commands, 2) << "one that runs at that moment";
  EXPECT_THAT(process.lines(),
              ElementsAre("hangs|It holds up the end of its process. The others are deactivated meanwhile."));
}

TEST(Components, AreDeactivatedWhileOneIsActivated) {
  deactivated = late_commands = 0;
  Process process;
  process.components->Add({.name = "left", .type = "test/Motor"});
  process.components->Add({.name = "right", .type = "test/Motor"});
  process.components->Add({.name = "begins", .type = "test/BeginsLong"});
  process.components->Add(CounterNamed("not_begun"));
  process.components->Join();
  const std::jthread end([&] {
    EXPECT_TRUE(Await([] { return begins.load(); }));
    process.components->BeginEnd();
  });
  process.components->Start();
  EXPECT_EQ(deactivated, 2);
  EXPECT_EQ(process.Status("not_begun").state, ComponentState::kJoined);
}

// What Deactivate() has cleared is no state for the next instance.
TEST(Components, AreNotSavedOnceTheyAreDeactivated) {
  CountingProcess process;
  EXPECT_NE(process.components->Save("counter"), nullptr);
  process.components->BeginEnd();
  EXPECT_TRUE(Await([&] {
    const std::string fault = ErrorOf([&] { return process.components->Save("counter"); });
    return fault.find("it has been deactivated already") != std::string::npos;
  }));
}

TEST(Components, EndOneByOne) {
  Process process;
  process.components->Add(CounterNamed("a"));
  process.components->Add(CounterNamed("b"));
  process.Run();
  process.components->End("a");
  (void)process.session.ToAny("pose", PoseIn("x"));
  EXPECT_EQ(process.components->Find<Counter>("a"), nullptr);
  EXPECT_EQ(process.components->Find<Counter>("b")->count, 1);
  EXPECT_THAT([&] { (void)process.components->description("a"); },
              ThrowsMessage<Error>(HasSubstr("no component named \"a\"")));
}

TEST(Components, RenameChannels) {
  ComponentSetup setup = CounterNamed("counter");
  setup.remap = {{"pose", "front/pose"}};
  CountingProcess process(setup);
  (void)process.session.ToAny("front/pose", PoseIn("x"));
  EXPECT_EQ(process.counter.count, 1);
  ASSERT_EQ(process.description.inputs.size(), 1U);
  EXPECT_EQ(process.description.inputs[0].name, "pose");
  EXPECT_EQ(process.description.inputs[0].channel, "front/pose");
  EXPECT_EQ(process.description.inputs[0].node, "counter/pose");
}

TEST(Components, SayWhatTheyUse) {
  Process process;
  const ComponentDescription& description = process.components->Add(CounterNamed("counter"));
  EXPECT_EQ(description.type, "test/Counter");
  ASSERT_EQ(description.outputs.size(), 1U);
  EXPECT_EQ(description.outputs[0].channel, "counted");
  EXPECT_EQ(description.outputs[0].type, "foxglove.PoseInFrame");
  ASSERT_EQ(description.params.size(), 1U);
  EXPECT_EQ(description.params[0].path, "step");
  EXPECT_EQ(description.state, "foxglove.PoseInFrame");
  EXPECT_EQ(
      description.fingerprints,
      (std::map<std::string, std::uint64_t>{{"foxglove.PoseInFrame", TypeOf<foxglove::PoseInFrame>().fingerprint}}));
}

TEST(Components, GetTheirParameters) {
  CountingProcess process(WithParam("step", "5"));
  process.Publish("x");
  EXPECT_EQ(process.counter.count, 5);
}

TEST(Components, MayNameAParameterAsASectionOfTheSession) {
  Process process;
  ComponentSetup setup{.name = "clock", .type = "test/Timed"};
  setup.params.section = std::make_shared<const ParamNode>(ParamNode::Map({{"time", ParamNode::Text("2", false)}}));
  process.components->Add(setup);
  EXPECT_EQ(process.components->Find<Timed>("clock")->time, 2);
}

TEST(Components, TellAllFaultsOfASetup) {
  Process process;
  EXPECT_THAT([&] { process.components->Add(WithParam("stop", "5")); },
              ThrowsMessage<Error>(AllOf(HasSubstr("Component \"counter\" (test/Counter)"), HasSubstr("robot.yaml:7:3"),
                                         HasSubstr("no parameter \"stop\""), HasSubstr("Did you mean \"step\"?"))));
  ComponentSetup setup = WithParam("step", "500");
  setup.params.overrides.push_back({"half", "1", "robot.yaml:8:3"});
  setup.remap = {{"pos", "front/pose"}};
  setup.nodes["poses"].queue = Queue::KeepAll(3);
  try {
    process.components->Add(setup);
    FAIL();
  } catch (const ComponentError& error) {
    std::vector<std::string> places;
    std::vector<std::string> sentences;
    for (const Error& fault : error.faults()) {
      EXPECT_THAT(fault.what(), HasSubstr("Component \"counter\" (test/Counter): "));
      EXPECT_THAT(error.what(), HasSubstr(fault.what()));
      places.push_back(fault.where());
      sentences.emplace_back(fault.what());
    }
    EXPECT_THAT(places, ElementsAre("robot.yaml:7:3", "", "", "robot.yaml:8:3"));
    const auto mend = HasSubstr("Did you mean \"pose\"?");
    EXPECT_THAT(sentences.at(0), HasSubstr("step"));
    EXPECT_THAT(sentences, Contains(AllOf(HasSubstr("\"pos\""), mend)));
    EXPECT_THAT(sentences, Contains(AllOf(HasSubstr("\"poses\""), mend)));
  }
  EXPECT_TRUE(process.components->statuses().empty());
}

TEST(Components, RefuseATypeThatIsUnknownAndANameThatIsTaken) {
  Process process;
  EXPECT_THAT([&] { process.components->Add({.name = "counter", .type = "test/Conter"}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("\"counter\""), HasSubstr("Did you mean \"test/Counter\"?"))));
  process.components->Add(CounterNamed("counter"));
  EXPECT_THAT([&] { process.components->Add(CounterNamed("counter")); },
              ThrowsMessage<Error>(HasSubstr("two components")));
  EXPECT_THAT([&] { process.components->Add(CounterNamed("a b")); },
              ThrowsMessage<Error>(HasSubstr("cannot be named")));
}

TEST(Components, WhoseConstructorThrowsLeaveNothing) {
  Process process;
  EXPECT_THAT([&] { process.components->Add({.name = "eye", .type = "test/Broken"}); },
              ThrowsMessage<Error>(HasSubstr("Component \"eye\" (test/Broken): there is no camera")));
  EXPECT_THAT([&] { process.components->Add({.name = "eye", .type = "test/FailsAtOnce"}); },
              ThrowsMessage<Error>(HasSubstr("Component \"eye\" (test/FailsAtOnce): it lacks a battery")));
  EXPECT_TRUE(process.components->statuses().empty());
}

TEST(Components, WhoseActivateThrowsHaveFailed) {
  Deeds().clear();
  Process process;
  process.components->Add({.name = "motor", .type = "test/WillNotStart"});
  process.components->Add(CounterNamed("counter"));
  process.Run();
  EXPECT_EQ(process.Status("motor").state, ComponentState::kFailed);
  EXPECT_EQ(process.Status("motor").sentence, "the motor does not answer");
  EXPECT_EQ(process.Status("counter").state, ComponentState::kRunning);
  EXPECT_THAT(process.lines(), ElementsAre(HasSubstr("motor|It has failed: the motor does not answer")));
  process.components->End("motor");
  EXPECT_THAT(Deeds(), ElementsAre("counter is active"));
}

// Fails as soon as it is active.
struct FailsWhenActive {
  explicit FailsWhenActive(Context& its_context) : context(its_context) {
    context.CreateTimer("tick", std::chrono::milliseconds(1), [this](const Tick&) { ++ticks; });
  }
  void Activate() {
    for (int i = 0; i < 100; ++i) context.Fail("it has had enough");
  }
  Context& context;
  std::atomic<int> ticks{0};
};
HGROS_COMPONENT(FailsWhenActive, "test/FailsWhenActive")

TEST(Components, ThatFailWhenActiveSaySoOnceAndGetNoTimers) {
  Process process;
  process.components->Add({.name = "short", .type = "test/FailsWhenActive"});
  process.Run();
  EXPECT_EQ(process.Status("short").state, ComponentState::kFailed);
  Linger(std::chrono::milliseconds(20));
  EXPECT_EQ(process.components->Find<FailsWhenActive>("short")->ticks, 0);
  EXPECT_THAT(process.lines(), ElementsAre(HasSubstr("short|It has failed: it has had enough")));
}

TEST(Components, ThatCannotJoinHaveFailed) {
  Process process;
  const auto other = process.session.Advertise<foxglove::FrameTransform>("pose");
  process.components->Add(CounterNamed("counter"));
  EXPECT_THAT([&] { process.components->Join(); },
              ThrowsMessage<Error>(AllOf(HasSubstr("Component \"counter\""), HasSubstr("foxglove.FrameTransform"))));
  EXPECT_EQ(process.Status("counter").state, ComponentState::kFailed);
  process.components->Join();
  process.components->Start();
  EXPECT_EQ(process.Status("counter").state, ComponentState::kFailed);
}

TEST(Components, FinishOnceAndSayTheResult) {
  CountingProcess process;
  process.Publish("finish");
  process.Publish("fail");
  EXPECT_EQ(process.Status("counter").state, ComponentState::kFinished);
  EXPECT_EQ(process.Status("counter").sentence, "counted 0");
  EXPECT_THAT(process.states(),
              ElementsAre(ComponentState::kJoined, ComponentState::kRunning, ComponentState::kFinished));
}

TEST(Components, TellCallbacksThatTakeTooLongOnceEach) {
  ComponentSetup setup = CounterNamed("counter");
  setup.deadline = std::chrono::milliseconds(200);
  CountingProcess process(setup);
  process.Publish("x");
  EXPECT_EQ(process.Status("counter").late, 0U);
  process.Publish("slow");
  EXPECT_EQ(process.Status("counter").late, 1U);
  process.components->NoteHanging("counter");
  EXPECT_EQ(process.Status("counter").late, 1U) << "None hangs.";
  std::thread publisher([&] { process.Publish("door"); });
  EXPECT_TRUE(Await([&] {
    process.components->NoteHanging("counter");
    return process.Status("counter").late == 2;
  }));
  process.counter.door.Open();
  publisher.join();
  EXPECT_EQ(process.Status("counter").late, 2U);
}

TEST(Components, TellExceptionsOfCallbacksAndOfSaveAndGoOn) {
  CountingProcess process;
  process.Publish("throw");
  process.Publish("x");
  EXPECT_EQ(process.Status("counter").exceptions, 1U);
  EXPECT_EQ(process.Status("counter").exception, "no such pose");
  EXPECT_EQ(process.Status("counter").state, ComponentState::kRunning);
  EXPECT_EQ(process.counter.count, 1);
  EXPECT_EQ(process.session.Snapshot().graph.channels.empty(), false);
  process.counter.count = -1;
  EXPECT_THAT([&] { (void)process.components->Save("counter"); },
              ThrowsMessage<Error>(HasSubstr("something that is no std::exception")));
}

TEST(Components, GoOnFromASavedState) {
  ComponentSetup setup = CounterNamed("counter");
  {
    CountingProcess process;
    for (int i = 0; i < 3; ++i) process.Publish("x");
    setup.state = process.components->Save("counter");
  }
  EXPECT_EQ(CountingProcess(setup).counter.count, 3);
}

// Its callback runs until the test says so.
class Slow {
 public:
  explicit Slow(Context& context) {
    context.FromAny<PoseInFrame>("pose", Invoke::kSerial, [this](const PoseInFrame&) {
      ++begun;
      Await([this] { return !held; });
      ++ended;
    });
  }
  [[nodiscard]] PoseInFrame Save() const { return PoseIn(std::to_string(begun - ended)); }
  void Restore(const PoseInFrame& state) { restored = state.frame_id(); }

  std::string restored;
  std::atomic<bool> held = true;
  std::atomic<int> begun = 0;
  std::atomic<int> ended = 0;
};
HGROS_COMPONENT(Slow, "test/Slow")

TEST(Components, AreSavedBetweenTheirCallbacks) {
  Process process({}, false);
  process.components->Add({.name = "slow", .type = "test/Slow"});
  process.Run();
  Slow& slow = *process.components->Find<Slow>("slow");
  for (int i = 0; i < 10; ++i) (void)process.session.ToAny("pose", PoseIn("x"));
  ASSERT_TRUE(Await([&] { return slow.begun == 1; }));
  EXPECT_THAT([&] { (void)process.components->Save("slow", std::chrono::milliseconds(20)); },
              ThrowsMessage<Error>(AllOf(HasSubstr("slow"), HasSubstr("callback"))));
  slow.held = false;
  process.components->Add({.name = "next", .type = "test/Slow", .state = process.components->Save("slow")});
  EXPECT_EQ(process.components->Find<Slow>("next")->restored, "0") << "It was saved inside a callback.";
  EXPECT_TRUE(Await([&] { return slow.ended == 10; })) << "Callbacks that waited run on.";
}

TEST(Components, RefuseAStateOfAnotherTypeOrWithoutRestore) {
  Process process;
  auto schema = std::make_shared<const MessageSchema>(SchemaOf(TypeOf<foxglove::FrameTransform>()));
  ComponentSetup setup = CounterNamed("counter");
  setup.state = std::make_shared<const RawMessage>(RawMessage{schema, {}});
  EXPECT_THAT([&] { process.components->Add(setup); }, ThrowsMessage<Error>(HasSubstr("cannot be restored")));
  setup.type = "test/WillNotStart";
  EXPECT_THAT([&] { process.components->Add(setup); }, ThrowsMessage<Error>(HasSubstr("has no Restore")));
}

// Subscribes again with each pose.
class Curious {
 public:
  explicit Curious(Context& context) {
    const auto subscribe_again = [this, &context](const PoseInFrame&) {
      const std::string more = "more/" + std::to_string(++asked_);
      context.FromAny<PoseInFrame>(more, Invoke::kSerial, [this](const PoseInFrame&) { ++heard_; });
      (void)context.Advertise<PoseInFrame>(more)(std::make_unique<PoseInFrame>());
    };
    context.FromAny<PoseInFrame>("pose", Invoke::kConcurrent, subscribe_again, {.queue = Queue::KeepAll(1000)});
  }

 private:
  std::atomic<int> asked_{0};
  std::atomic<int> heard_{0};
};
HGROS_COMPONENT(Curious, "test/Curious")

TEST(Components, EndWhileTheySubscribe) {
  for (int round = 0; round < 20; ++round) {
    Process process("", false);
    process.components->Add({.name = "curious", .type = "test/Curious"});
    process.Run();
    for (int i = 0; i < 50; ++i) (void)process.session.ToAny("pose", PoseIn("x"));
    process.components->End("curious");
    for (int i = 1; i <= 50; ++i) (void)process.session.ToAny("more/" + std::to_string(i), PoseIn("x"));
    EXPECT_TRUE(process.session.WaitIdle(std::chrono::seconds(10)));
  }
}

}  // namespace
}  // namespace hgros::test
