// A component that runs is constructed again in its place.
#include <gmock/gmock.h>

#include <cstdint>
#include <random>
#include <stdexcept>

#include "component/components_fixture.hpp"
#include "hgros/base/error.hpp"
#include "hgros/component/component.hpp"
#include "hgros/component/component_error.hpp"

namespace hgros::test {
namespace {

using foxglove::PoseInFrame;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

std::atomic<int> instances = 0;

// Adds up the numbers that it gets, publishes them again, and serves the sum.
class Summing {
 public:
  explicit Summing(Context& context) : context_(context), passed_(context.Advertise<PoseInFrame>("passed")) {
    if (context.Declare("broken", false)) throw std::runtime_error("there is no abacus");
    slow_ = context.Declare("slow", false);
    (void)context.Declare("step", 0);
    set_at_end_ = context.Declare("set_at_end", 0);
    const auto depth = static_cast<std::size_t>(context.Declare("depth", 100'000));
    context.FromAny<PoseInFrame>("number", Invoke::kSerial, [this](const PoseInFrame& pose) { Take(pose); },
                                 {.queue = Queue::KeepAll(depth)});
    if (context.Declare("beside", true)) {
      context.FromAny<PoseInFrame>("beside", Invoke::kSerial, [this](const PoseInFrame&) { ++besides; });
    }
    context.Serve<PoseInFrame, PoseInFrame>("sum", [this](const PoseInFrame&) { return Numbered(sum_); });
    context.CreateTimer("tick", std::chrono::milliseconds(1), [this](const Tick&) { ++ticks; });
    ++instances;
  }
  ~Summing() { --instances; }
  Summing(const Summing&) = delete;
  Summing& operator=(const Summing&) = delete;

  void Activate() { active = true; }
  void Deactivate() {
    if (set_at_end_ > 0) (void)context_.params().Set("step", set_at_end_);
  }
  [[nodiscard]] PoseInFrame Save() const { return Numbered(sum_); }
  void Restore(const PoseInFrame& state) { sum_ = std::stoll(state.frame_id()); }

  static constexpr int kHang = -1;
  static constexpr int kHearMore = -2;
  std::atomic<bool> active = false;
  std::atomic<int> ticks = 0;
  std::atomic<int> besides = 0;
  std::atomic<int> more = 0;
  std::atomic<bool> hangs = false;
  Door door;

 private:
  void Take(const PoseInFrame& pose) {
    const int number = std::stoi(pose.frame_id());
    if (number == kHang) {
      hangs = true;
      return door.Pass();
    }
    if (number == kHearMore) {
      return context_.FromAny<PoseInFrame>("more", Invoke::kSerial, [this](const PoseInFrame&) { ++more; });
    }
    sum_ += number;
    if (slow_) Linger(std::chrono::microseconds(300));
    (void)passed_(std::make_unique<PoseInFrame>(pose));
  }
  Context& context_;
  Publisher<PoseInFrame> passed_;
  std::int64_t sum_ = 0;
  bool slow_ = false;
  int set_at_end_ = 0;
};
HGROS_COMPONENT(Summing, "test/Summing")

struct NoState {
  explicit NoState(Context&) {}
};
HGROS_COMPONENT(NoState, "test/UnsavedAgain")

constexpr std::chrono::seconds kCallbacks{2};

ComponentSetup SummingSetup(std::vector<ParamOverride> params = {}) {
  ComponentSetup setup{.name = "summing", .type = "test/Summing"};
  setup.params.overrides = std::move(params);
  return setup;
}

class ConstructAgainTest : public NumbersFixture {
 protected:
  ConstructAgainTest() {
    components_.Add(SummingSetup());
    components_.Add({.name = "unsaved", .type = "test/UnsavedAgain"});
    components_.Join();
    components_.Start();
  }
  void SetUp() override {
    ASSERT_TRUE(outside_.WaitForSubscribers("number", 1, kPatience));
    ASSERT_TRUE(session_.WaitForSubscribers("passed", 1, kPatience));
  }
  void Again(const std::vector<ParamOverride>& params = {}, std::chrono::nanoseconds patience = kCallbacks) {
    components_.ConstructAgain("summing", patience, [&] { return SummingSetup(params); });
  }
  [[nodiscard]] bool Sees(std::size_t count) {
    return Await([&] { return seen_count() >= count; });
  }
  [[nodiscard]] Summing& summing() const { return *components_.Find<Summing>("summing"); }
  // A call that waits when the object ends fails, and can be repeated.
  [[nodiscard]] std::string Sum() {
    for (const auto end = std::chrono::steady_clock::now() + kPatience;;) {
      const auto sum = outside_.Call<PoseInFrame, PoseInFrame>("sum", PoseInFrame(), std::chrono::seconds(5)).Wait();
      if (sum) return sum->frame_id();
      if (std::chrono::steady_clock::now() > end) return sum.failure().reason;
    }
  }

  Session session_{Config::Parse("discovery: {lan: false}"), {.name = "place"}};
  std::vector<std::string> changes_;  // Of parameters.
  Components components_{
      session_, {.on_params = [this](std::string_view component, const ParamEvent& event) {
        const std::scoped_lock lock(mutex_);
        for (const ParamPath& path : event.paths) {
          changes_.push_back(std::string(component) + " " + path.ToString() + " " + event.after.At(path).ToYaml());
        }
      }}};
  const Publisher<PoseInFrame> beside_ = outside_.Advertise<PoseInFrame>("beside");
  const Publisher<PoseInFrame> more_ = outside_.Advertise<PoseInFrame>("more");
};

class ConstructAgainFlow : public ConstructAgainTest, public testing::WithParamInterface<bool> {};

TEST_P(ConstructAgainFlow, NothingIsLostDoubledOrOvertaken) {
  constexpr int kBetween = 1000;
  constexpr int kTimes = 12;
  constexpr int kMostWaiting = 20'000;  // With a sanitizer, the callback might not catch up with more.
  const bool inside = GetParam();       // Published in the same session, or in another one.
  const auto here = session_.Advertise<PoseInFrame>("number");
  std::atomic<bool> enough = false;
  int last = 0;
  std::thread publisher([&] {
    std::mt19937 random(7);
    while (!enough) {
      Publish(inside ? here : number_, ++last);
      if (random() % 64 == 0) Linger(std::chrono::microseconds(random() % 3000));
      while (!enough && last > static_cast<int>(seen_count()) + kMostWaiting) Linger(std::chrono::milliseconds(1));
    }
  });
  int times = 0;
  for (; times < kTimes && Sees(seen_count() + kBetween); ++times) {
    std::string saved;
    components_.ConstructAgain(
        "summing", kCallbacks,
        [&] {
          EXPECT_EQ(instances, 0);
          EXPECT_FALSE(saved.empty());
          return SummingSetup();
        },
        [&](const auto& state) {
          EXPECT_EQ(instances, 1);
          saved = state->schema->type_name;
        });
    EXPECT_EQ(saved, "foxglove.PoseInFrame");
    EXPECT_EQ(instances, 1);
    EXPECT_TRUE(summing().active);
  }
  EXPECT_EQ(times, kTimes);
  enough = true;
  publisher.join();
  (void)Sees(static_cast<std::size_t>(last));
  EXPECT_EQ(seen(), UpTo(last));
  EXPECT_EQ(Sum(), std::to_string(std::int64_t{last} * (last + 1) / 2));
  EXPECT_TRUE(Await([&] { return summing().ticks > 3; }));
}
INSTANTIATE_TEST_SUITE_P(Places, ConstructAgainFlow, testing::Bool(),
                         [](const auto& one) { return one.param ? "SameSession" : "OtherSession"; });

TEST_F(ConstructAgainTest, APublisherThatIsFasterThanItsCallbackDoesNotKeepItWaiting) {
  const auto here = session_.Advertise<PoseInFrame>("number");
  std::atomic<bool> constructed = false;
  int last = 0;
  std::thread publisher([&] {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!constructed && std::chrono::steady_clock::now() < end) Publish(here, ++last);
    constructed = true;
  });
  ASSERT_TRUE(Sees(10));
  Again({{"slow", "true", "test"}});
  EXPECT_FALSE(constructed.exchange(true)) << "It was constructed only when the publisher gave up.";
  publisher.join();
  EXPECT_LT(seen().size(), static_cast<std::size_t>(last)) << "The publisher has not been faster.";
  Again();
  EXPECT_TRUE(Sees(static_cast<std::size_t>(last)));
  EXPECT_EQ(seen(), UpTo(last));
}

TEST_F(ConstructAgainTest, CallsAreAnsweredBeforeAndAfterwards) {
  Publish(4);
  ASSERT_TRUE(Sees(1));
  std::atomic<bool> ends = false;
  std::atomic<int> answers = 0;
  std::thread caller([&] {
    while (!ends) {
      EXPECT_EQ(Sum(), "4");
      ++answers;
    }
  });
  for (int i = 1; i <= 5; ++i) {
    ASSERT_TRUE(Await([&] { return answers >= i; }));
    Again();
  }
  const int before = answers;
  EXPECT_TRUE(Await([&] { return answers > before + 2; }));
  ends = true;
  caller.join();
}

// The next instance may subscribe otherwise, because its parameters have changed.
TEST_F(ConstructAgainTest, InputsThatTheNextInstanceDoesNotWantEnd) {
  ASSERT_TRUE(outside_.WaitForSubscribers("beside", 1, kPatience));
  Publish(1);
  Publish(beside_, 1);
  ASSERT_TRUE(Await([&] { return summing().besides == 1; }));
  ASSERT_TRUE(Sees(1));
  Again({{"beside", "false", "test"}, {"depth", "50", "test"}});
  EXPECT_TRUE(Await([&] { return !outside_.WaitForSubscribers("beside", 1, std::chrono::nanoseconds(0)); }));
  ASSERT_TRUE(outside_.WaitForSubscribers("number", 1, kPatience));
  Publish(2);
  EXPECT_TRUE(Sees(2)) << "Subscribed with another queue.";
  Again();
  ASSERT_TRUE(outside_.WaitForSubscribers("beside", 1, kPatience));
  Publish(beside_, 1);
  EXPECT_TRUE(Await([&] { return summing().besides == 1; }));
  Publish(3);
  EXPECT_TRUE(Sees(3));
  EXPECT_THAT(seen(), ElementsAre(1, 2, 3));
  EXPECT_EQ(Sum(), "6");
}

TEST_F(ConstructAgainTest, ASubscriptionOfACallbackEndsWithItsObject) {
  Publish(Summing::kHearMore);
  ASSERT_TRUE(outside_.WaitForSubscribers("more", 1, kPatience));
  Publish(more_, 1);
  ASSERT_TRUE(Await([&] { return summing().more == 1; }));
  Again();
  EXPECT_TRUE(Await([&] { return !outside_.WaitForSubscribers("more", 1, std::chrono::nanoseconds(0)); }));
  Publish(Summing::kHearMore);
  ASSERT_TRUE(outside_.WaitForSubscribers("more", 1, kPatience));
  Publish(more_, 1);
  EXPECT_TRUE(Await([&] { return summing().more == 1; }));
}

TEST_F(ConstructAgainTest, ItsSetupIsAskedForWhenAllChangesOfParametersAreKnown) {
  Again({{"set_at_end", "3", "test"}});
  EXPECT_THAT(changes_, ElementsAre());
  (void)components_.params("summing").Set("step", 2);
  components_.ConstructAgain("summing", kCallbacks, [&] {
    EXPECT_THAT(changes_, ElementsAre("summing step 2", "summing step 3"));
    return SummingSetup({{"step", "3", "test"}});
  });
  EXPECT_EQ(components_.params("summing").Get<int>("step"), 3);
  (void)components_.params("summing").Set("step", 4);
  EXPECT_THAT(changes_, ElementsAre("summing step 2", "summing step 3", "summing step 4"));
}

TEST_F(ConstructAgainTest, WhatCannotBeSavedRunsOn) {
  EXPECT_THAT([&] { components_.ConstructAgain("unsaved", kCallbacks, [] { return ComponentSetup(); }); },
              ThrowsMessage<Error>(HasSubstr("Give it Save() and Restore()")));
  EXPECT_THROW(components_.ConstructAgain("nobody", kCallbacks, [] { return ComponentSetup(); }), Error);
  Publish(Summing::kHang);
  ASSERT_TRUE(Await([&] { return summing().hangs.load(); }));
  const Summing* const before = &summing();
  EXPECT_THAT([&] { Again({}, std::chrono::milliseconds(20)); },
              ThrowsMessage<Error>(HasSubstr("a callback of it has not returned")));
  EXPECT_EQ(&summing(), before);
  summing().door.Open();
  Publish(1);
  EXPECT_TRUE(Sees(1));
}

TEST_F(ConstructAgainTest, NothingIsLeftOfOneThatCannotBeConstructed) {
  Publish(1);
  ASSERT_TRUE(Sees(1));
  EXPECT_THAT(
      [&] {
        Again({{"broken", "true", "test"}});
      },
      ThrowsMessage<ComponentError>(HasSubstr("there is no abacus")));
  EXPECT_EQ(components_.Find<Summing>("summing"), nullptr);
  EXPECT_EQ(instances, 0);
  EXPECT_TRUE(Await([&] { return !outside_.WaitForSubscribers("number", 1, std::chrono::nanoseconds(0)); }));
  components_.Add(SummingSetup());
  components_.Join();
  components_.Start();
  ASSERT_TRUE(outside_.WaitForSubscribers("number", 1, kPatience));
  Publish(2);
  EXPECT_TRUE(Sees(2));
}

}  // namespace
}  // namespace hgros::test
