#include "hgros/component/component_move.hpp"

#include <gmock/gmock.h>

#include <stdexcept>

#include "component/components_fixture.hpp"
#include "hgros/base/error.hpp"
#include "hgros/component/component.hpp"

namespace hgros::test {
namespace {

using foxglove::PoseInFrame;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing::UnorderedElementsAreArray;

// Adds up the numbers that it gets, publishes them again, and serves the sum.
class Adder {
 public:
  explicit Adder(Context& context)
      : passed_(context.Advertise<PoseInFrame>("passed")),
        latest_(context.Advertise<PoseInFrame>("latest", {.latched = 1})) {
    context.FromAny<PoseInFrame>("number", Invoke::kSerial, [this](const PoseInFrame& pose) { Take(pose); },
                                 {.queue = Queue::KeepAll(100'000)});
    context.Serve<PoseInFrame, PoseInFrame>("sum", [this](const PoseInFrame&) { return Numbered(sum_); });
    context.CreateTimer("tick", std::chrono::milliseconds(1), [this](const Tick&) { ++ticks; });
  }
  void Activate() { active = true; }
  void Deactivate() { active = false; }
  [[nodiscard]] PoseInFrame Save() const {
    if (sum_ == kUnsaved) throw std::runtime_error("it has lost its notes");
    return Numbered(sum_);
  }
  void Restore(const PoseInFrame& state) {
    sum_ = std::stoi(state.frame_id());
    if (sum_ == kUnrestored) throw std::runtime_error("it cannot read this");
  }

  static constexpr int kUnsaved = 1'000'000'001;
  static constexpr int kUnrestored = 1'000'000'002;
  std::atomic<bool> active = false;
  std::atomic<int> ticks = 0;

 private:
  void Take(const PoseInFrame& pose) {
    sum_ += std::stoi(pose.frame_id());
    (void)passed_(std::make_unique<PoseInFrame>(pose));
    (void)latest_(std::make_unique<PoseInFrame>(Numbered(sum_)));
  }
  Publisher<PoseInFrame> passed_;
  Publisher<PoseInFrame> latest_;  // Sums.
  std::atomic<int> sum_ = 0;       // A service reads it on another thread.
};
HGROS_COMPONENT(Adder, "test/Adder")

struct Unsaved {
  explicit Unsaved(Context&) {}
};
HGROS_COMPONENT(Unsaved, "test/Unsaved")

ComponentSetup AdderSetup() { return {.name = "adder", .type = "test/Adder"}; }

// A place of the component: a session of its own.
struct Place {
  explicit Place(const std::string& config = "discovery: {lan: false}")
      : session(Config::Parse(config), {.name = "place"}), components(session) {}

  void Start() {
    components.Add(AdderSetup());
    components.Join();
    components.Start();
  }
  [[nodiscard]] const Adder* adder() { return components.Find<Adder>("adder"); }

  Session session;
  Components components;
};

class ComponentMoveTest : public NumbersFixture {
 protected:
  [[nodiscard]] bool SeesUpTo(int number) {
    return Await([&] { return !seen().empty() && seen().back() == number; });
  }
  // A session that has not heard yet that the old place is left still calls it, and one that has not heard yet of the
  // new place calls nobody. As docs/decisions/0037 says, such a call fails and can be repeated.
  [[nodiscard]] std::string SumOf(Session& session) {
    for (const auto end = std::chrono::steady_clock::now() + kPatience;;) {
      const auto sum = session.Call<PoseInFrame, PoseInFrame>("sum", PoseInFrame(), kPatience).Wait();
      if (sum) return sum->frame_id();
      const CallFailure::Kind kind = sum.failure().kind;
      const bool again = kind == CallFailure::Kind::kServerGone || kind == CallFailure::Kind::kNoServer;
      if (!again || std::chrono::steady_clock::now() > end) return sum.failure().reason;
    }
  }
  // What hgros run does, in one thread.
  static void Move(Place& from, Place& to, std::chrono::milliseconds most = std::chrono::seconds(2)) {
    ArrivingComponent arriving(to.components, AdderSetup(), [] {});
    LeavingComponent leaving(from.components, "adder", [] {});
    ASSERT_TRUE(to.session.WaitForSubscribers("passed", 1, kPatience));
    Cross(leaving, arriving, leaving.Hold(kPatience, to.session.id()));
    (void)Await(
        [&] {
          Exchange(leaving, arriving);
          return leaving.all_passed();
        },
        most);
    Exchange(leaving, arriving);
  }
  static void Cross(LeavingComponent& leaving, ArrivingComponent& arriving, const MovingState& state) {
    arriving.Restore(state);
    arriving.Begin();
    leaving.Leave();
  }
  static void Exchange(LeavingComponent& leaving, ArrivingComponent& arriving) {
    arriving.Work();
    while (const auto message = leaving.Next()) arriving.Hand(*message);
    for (const InputPosition& position : arriving.FirstOwn()) leaving.Passed(position);
  }
};

class AdderMoveTest : public ComponentMoveTest {
 protected:
  void SetUp() override {
    one.Start();
    ASSERT_TRUE(outside_.WaitForSubscribers("number", 1, kPatience));
  }
  Place one;
  Place other;
};

// Otherwise an old place that is behind never ends under load: messages come as fast as it hands them over.
TEST_F(AdderMoveTest, TheOldPlaceHandsOverNothingThatTheNewOneHasItself) {
  Publish(1);
  ASSERT_TRUE(SeesUpTo(1));
  std::atomic<int> waiting = 0;
  LeavingComponent leaving(one.components, "adder", [&] { ++waiting; });
  const MovingState moving = leaving.Hold(kPatience);
  for (int number = 2; number <= 10; ++number) Publish(number);  // The new place does not know them.
  ASSERT_TRUE(Await([&] { return waiting == 9; }));
  ArrivingComponent arriving(other.components, AdderSetup(), [] {});
  ASSERT_TRUE(outside_.WaitForSubscribers("number", 2, kPatience));
  ASSERT_TRUE(other.session.WaitForSubscribers("passed", 1, kPatience));
  Cross(leaving, arriving, moving);
  std::vector<InputPosition> own;
  int number = 10;
  ASSERT_TRUE(Await([&] {  // The first ones may come over a link that is not there yet.
    Publish(++number);
    arriving.Work();
    own = arriving.FirstOwn();
    return !own.empty();
  }));
  EXPECT_THAT(seen(), ElementsAre(1)) << "The others are too early.";
  leaving.Passed(own.front());
  for (int more = 0; more < 100; ++more) Publish(++number);
  ASSERT_TRUE(Await([&] { return waiting == number - 1; }));
  std::uint64_t last = 0;
  while (const auto message = leaving.Next()) {
    arriving.Hand(*message);
    last = message->info.number;
  }
  EXPECT_EQ(last, own.front().number);
  EXPECT_TRUE(leaving.all_passed());
  (void)Await([&] {
    arriving.Work();
    return seen().size() == static_cast<std::size_t>(number);
  });
  EXPECT_EQ(seen(), UpTo(number));
}

// As if a thread that brings a message were held up until a later one was handled.
TEST_F(AdderMoveTest, HandlesWhatWasOvertakenInTheOldPlaceOnce) {
  for (int number = 1; number <= 5; ++number) Publish(number);
  ASSERT_TRUE(SeesUpTo(5));
  std::atomic<int> waiting = 0;
  LeavingComponent leaving(one.components, "adder", [&] { ++waiting; });
  ArrivingComponent arriving(other.components, AdderSetup(), [] {});
  ASSERT_TRUE(outside_.WaitForSubscribers("number", 2, kPatience));
  ASSERT_TRUE(other.session.WaitForSubscribers("passed", 1, kPatience));
  Cross(leaving, arriving, leaving.Hold(std::chrono::seconds(1)));
  for (int number = 6; number <= 9; ++number) Publish(number);
  ASSERT_TRUE(Await([&] { return waiting == 4; }));
  std::vector<MovingMessage> handed;
  while (auto message = leaving.Next()) handed.push_back(std::move(*message));
  ASSERT_EQ(handed.size(), 4U);
  MovingMessage overtaken = handed.front();  // Published before the last one that was handled in the old place.
  overtaken.info.number -= 2;
  overtaken.info.id.sequence -= 2;
  overtaken.message = RawMessage{handed.front().message.schema, {}};
  for (const std::size_t i : {1U, 0U, 3U, 2U}) arriving.Hand(handed.at(i));
  EXPECT_TRUE(Await([&] { return seen().size() == 9; }));
  EXPECT_THAT(seen(), UnorderedElementsAreArray(UpTo(9)));
  arriving.Hand(handed.front());
  arriving.Hand(handed.back());
  arriving.Hand(overtaken);
  EXPECT_TRUE(Await([&] { return other.components.statuses().front().exceptions == 1; }))
      << "Its empty text is no number.";
  EXPECT_EQ(SumOf(outside_), "45");
}

TEST_F(AdderMoveTest, AnArrivingComponentHoldsUpNoOther) {
  constexpr int kMany = 3000;  // More than wait in it.
  std::atomic<int> pings = 0;
  std::vector<Subscription> others;  // As many as threads, and more.
  for (unsigned i = 0; i <= std::thread::hardware_concurrency(); ++i) {
    others.push_back(other.session.FromAny<PoseInFrame>("ping", Invoke::kSerial, [&](const PoseInFrame&) { ++pings; }));
  }
  const auto ping = outside_.Advertise<PoseInFrame>("ping");
  ArrivingComponent arriving(other.components, AdderSetup(), [] {});
  ASSERT_TRUE(outside_.WaitForSubscribers("number", 2, kPatience));
  ASSERT_TRUE(outside_.WaitForSubscribers("ping", 1, kPatience));
  ASSERT_TRUE(other.session.WaitForSubscribers("passed", 1, kPatience));
  for (int number = 1; number <= kMany; ++number) Publish(number);
  ASSERT_TRUE(SeesUpTo(kMany));
  EXPECT_EQ(ping(Numbered(1)), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return pings == static_cast<int>(others.size()); }));
  LeavingComponent leaving(one.components, "adder", [] {});
  Cross(leaving, arriving, leaving.Hold(kPatience));
  Publish(kMany + 1);
  EXPECT_TRUE(Await([&] {
    Exchange(leaving, arriving);
    return leaving.all_passed() && seen().size() > kMany;
  }));
  EXPECT_EQ(seen(), UpTo(kMany + 1));
}

TEST_F(ComponentMoveTest, AComponentThatIsHeldHoldsUpNoOther) {
  constexpr int kMany = 3000;
  constexpr int kFull = 1024;  // From then on they wait in the queue.
  Place one("{discovery: {lan: false}, data_graph: {threads: 1}}");
  one.Start();
  std::atomic<int> pings = 0;
  const Subscription other =
      one.session.FromAny<PoseInFrame>("ping", Invoke::kSerial, [&](const PoseInFrame&) { ++pings; });
  const auto ping = outside_.Advertise<PoseInFrame>("ping");
  ASSERT_TRUE(outside_.WaitForSubscribers("number", 1, kPatience));
  ASSERT_TRUE(outside_.WaitForSubscribers("ping", 1, kPatience));
  std::atomic<int> waiting = 0;
  LeavingComponent leaving(one.components, "adder", [&] { ++waiting; });
  (void)leaving.Hold(kPatience);
  for (int number = 1; number <= kMany; ++number) Publish(number);
  ASSERT_TRUE(Await([&] { return waiting >= kFull; }));
  EXPECT_EQ(ping(Numbered(1)), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return pings == 1; }));
  leaving.Resume();
  EXPECT_TRUE(SeesUpTo(kMany));
  EXPECT_EQ(seen(), UpTo(kMany));
}

// It may be the same component in another place.
TEST_F(AdderMoveTest, ANewPublisherOvertakesNothingThatWaitsInTheOldPlace) {
  LeavingComponent leaving(one.components, "adder", [] {});
  const MovingState moving = leaving.Hold(kPatience, other.session.id());
  for (int number = 1; number <= 3; ++number) Publish(number);
  std::atomic<int> arrived = 0;
  ArrivingComponent arriving(other.components, AdderSetup(), [&] { ++arrived; });
  ASSERT_TRUE(other.session.WaitForSubscribers("passed", 1, kPatience));
  Session elsewhere(Config::Parse("discovery: {lan: false}"), {.name = "elsewhere"});
  auto moved = elsewhere.Advertise<PoseInFrame>("number");
  ASSERT_TRUE(elsewhere.WaitForSubscribers("number", 2, kPatience));
  ASSERT_EQ(moved(Numbered(4)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return arrived == 1; }));
  Cross(leaving, arriving, moving);
  ASSERT_TRUE(Await([&] {
    Exchange(leaving, arriving);
    return seen().size() == 4;
  }));
  EXPECT_THAT(seen(), ElementsAre(1, 2, 3, 4));
}

// Some wait in the queue of the subscription, and come a moment after others were taken.
TEST_F(ComponentMoveTest, TellsWhetherMoreIsToBeHandedOver) {
  constexpr int kMany = 5000;
  Place one;
  one.Start();
  auto here = one.session.Advertise<PoseInFrame>("number");
  LeavingComponent leaving(one.components, "adder", [] {});
  (void)leaving.Hold(kPatience);
  EXPECT_FALSE(leaving.has_more());
  for (int number = 1; number <= kMany; ++number) ASSERT_EQ(here(Numbered(number)), PublishStatus::kOk);
  leaving.Leave();
  std::vector<int> handed;
  while (leaving.has_more()) {
    while (const auto message = leaving.Next()) {
      PoseInFrame pose;
      const auto bytes = message->message.data.bytes;
      ASSERT_TRUE(pose.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
      handed.push_back(std::stoi(pose.frame_id()));
    }
  }
  EXPECT_EQ(handed, UpTo(kMany));
}

TEST_F(AdderMoveTest, TakesItsStateServicesAndTimersWithIt) {
  for (int number = 1; number <= 4; ++number) Publish(number);
  ASSERT_TRUE(SeesUpTo(4));
  EXPECT_EQ(SumOf(outside_), "10");
  Move(one, other, std::chrono::milliseconds(50));  // Quiet.
  EXPECT_EQ(one.adder(), nullptr);
  EXPECT_TRUE(other.adder()->active);
  EXPECT_TRUE(Await([&] { return other.adder()->ticks > 3; }));
  EXPECT_EQ(SumOf(outside_), "10");
  ASSERT_TRUE(other.session.WaitForPublishers("number", 1, kPatience));  // The move was over before.
  Publish(5);
  EXPECT_TRUE(SeesUpTo(5));
  EXPECT_EQ(SumOf(outside_), "15");
}

// What comes on a latched channel, in a session of its own.
struct Watcher {
  explicit Watcher(Session& session)
      : latest(session.FromAny<PoseInFrame>("latest", Invoke::kSerial,
                                            [this](const PoseInFrame& pose) {
                                              const std::scoped_lock lock(mutex);
                                              sums.push_back(std::stoi(pose.frame_id()));
                                            },
                                            {.queue = Queue::KeepAll(1000)})) {}
  [[nodiscard]] bool Sees(const std::vector<int>& wanted) {
    (void)Await([&] { return seen().size() >= wanted.size(); });
    EXPECT_EQ(seen(), wanted);
    return seen() == wanted;
  }
  [[nodiscard]] std::vector<int> seen() {
    const std::scoped_lock lock(mutex);
    return sums;
  }

  std::mutex mutex;
  std::vector<int> sums;
  Subscription latest;
};

TEST_F(AdderMoveTest, WhatItHasLatchedMovesAlong) {
  Watcher early(outside_);
  ASSERT_TRUE(one.session.WaitForSubscribers("latest", 1, kPatience));
  for (const int number : {1, 2}) Publish(number);
  ASSERT_TRUE(early.Sees({1, 3}));
  Move(one, other, std::chrono::milliseconds(50));
  Session late_session(Config::Parse("discovery: {lan: false}"));
  Watcher late(late_session);
  Watcher late_there(other.session);
  Watcher late_here(one.session);
  ASSERT_TRUE(late_session.WaitForPublishers("latest", 2, kPatience));  // Of both places.
  EXPECT_TRUE(late.Sees({3}) && late_there.Sees({3}) && late_here.Sees({3}));
  ASSERT_TRUE(other.session.WaitForSubscribers("latest", 3, kPatience));
  Publish(3);
  EXPECT_TRUE(late.Sees({3, 6}) && late_there.Sees({3, 6}) && late_here.Sees({3, 6}));
  EXPECT_TRUE(early.Sees({1, 3, 6}));
  // And back.
  Move(other, one, std::chrono::milliseconds(50));
  Session last_session(Config::Parse("discovery: {lan: false}"));
  Watcher last(last_session);
  ASSERT_TRUE(last_session.WaitForPublishers("latest", 2, kPatience));
  EXPECT_TRUE(last.Sees({6}));
  Publish(4);
  EXPECT_TRUE(last.Sees({6, 10}));
  EXPECT_TRUE(late.Sees({3, 6, 10}) && late_there.Sees({3, 6, 10}) && late_here.Sees({3, 6, 10}));
  EXPECT_TRUE(early.Sees({1, 3, 6, 10}));
}

TEST_F(AdderMoveTest, WhoHasHeardThePlaceBeforeGetsWhatItHasLatchedSince) {
  Session listener(Config::Parse("discovery: {lan: false}"));
  const auto hears = [&](const std::vector<int>& wanted) { return Watcher(listener).Sees(wanted); };
  Publish(1);
  EXPECT_TRUE(SeesUpTo(1) && hears({1}));
  Move(one, other, std::chrono::milliseconds(50));
  Publish(2);
  EXPECT_TRUE(SeesUpTo(2));
  Move(other, one, std::chrono::milliseconds(50));
  EXPECT_TRUE(hears({3}));
  EXPECT_TRUE(hears({3}));
}

TEST_F(AdderMoveTest, AnAbandonedMoveHandlesWhatHasWaitedAndKeepsWhatItHasLatched) {
  Publish(1);
  ASSERT_TRUE(SeesUpTo(1));
  {
    const ArrivingComponent arriving(other.components, AdderSetup(), [] {});
    std::atomic<int> waiting = 0;
    LeavingComponent leaving(one.components, "adder", [&] { ++waiting; });
    (void)leaving.Hold(kPatience);
    const int ticks = one.adder()->ticks;
    Publish(2);
    Publish(3);
    ASSERT_TRUE(Await([&] { return waiting == 2; }));
    EXPECT_THAT(seen(), ElementsAre(1));
    EXPECT_EQ(one.adder()->ticks, ticks);
    EXPECT_FALSE(one.adder()->active);
  }
  EXPECT_EQ(other.adder(), nullptr);
  EXPECT_TRUE(one.adder()->active);
  EXPECT_TRUE(SeesUpTo(3));
  Publish(4);
  EXPECT_TRUE(SeesUpTo(4));
  EXPECT_THAT(seen(), ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(SumOf(outside_), "10");
  {
    ArrivingComponent arriving(other.components, AdderSetup(), [] {});
    LeavingComponent leaving(one.components, "adder", [] {});
    arriving.Restore(leaving.Hold(kPatience, other.session.id()));
  }
  Watcher late(outside_);
  EXPECT_TRUE(late.Sees({10}));
  ASSERT_TRUE(one.session.WaitForSubscribers("latest", 1, kPatience));
  Publish(1);
  EXPECT_TRUE(late.Sees({10, 11}));
}

TEST_F(AdderMoveTest, WhatCannotBeSavedOrRestoredStays) {
  one.components.Add({.name = "unsaved", .type = "test/Unsaved"});
  EXPECT_THAT([&] { const LeavingComponent leaving(one.components, "unsaved", [] {}); },
              ThrowsMessage<Error>(HasSubstr("Give it Save() and Restore().")));
  EXPECT_THAT([&] { const LeavingComponent leaving(one.components, "nobody", [] {}); },
              ThrowsMessage<Error>(HasSubstr("no component named \"nobody\"")));
  Publish(Adder::kUnsaved);
  ASSERT_TRUE(SeesUpTo(Adder::kUnsaved));
  EXPECT_THROW(Move(one, other), std::runtime_error);
  Publish(1);
  ASSERT_TRUE(SeesUpTo(1));
  EXPECT_THROW(Move(one, other), std::runtime_error) << "Restore throws.";
  EXPECT_EQ(other.adder(), nullptr);
  EXPECT_EQ(SumOf(outside_), std::to_string(Adder::kUnrestored));
}

}  // namespace
}  // namespace hgros::test
