#include "hgros/testing/harness.hpp"

#include <gmock/gmock.h>

#include <stdexcept>

#include <foxglove/FrameTransform.pb.h>
#include <foxglove/PoseInFrame.pb.h>

#include "hgros/base/error.hpp"

namespace hgros {
namespace {

using foxglove::PoseInFrame;
using hgros::testing::Harness;
using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

PoseInFrame PoseIn(const std::string& frame) {
  PoseInFrame pose;
  pose.set_frame_id(frame);
  return pose;
}

// Publishes each pose twice, and a note every 100 ms and every 250 ms.
class Doubler {
 public:
  explicit Doubler(Context& its_context)
      : context(its_context),
        suffix_(context.Declare("suffix", std::string("!"))),
        poses_(context.Advertise<PoseInFrame>("twice")),
        notes_(context.Advertise<PoseInFrame>("notes")),
        hello_(context.Advertise<PoseInFrame>("hello", {.latched = 1})) {
    (void)hello_(PoseIn("hello"));
    context.FromAny<PoseInFrame>("pose", Invoke::kSerial, [this](const PoseInFrame& pose) { Take(pose); });
    context.FromAny<PoseInFrame>("twice", Invoke::kSerial, [this](const PoseInFrame&) { ++heard; });
    context.Serve<PoseInFrame, PoseInFrame>("reverse", [](const PoseInFrame& request) {
      return PoseIn({request.frame_id().rbegin(), request.frame_id().rend()});
    });
    context.CreateTimer("fast", 100ms, [this](const Tick& tick) { Note("fast", tick); });
    context.CreateTimer("slow", 250ms, [this](const Tick& tick) { Note("slow", tick); });
  }
  PoseInFrame Save() { return PoseIn(std::to_string(heard)); }
  void Restore(const PoseInFrame& state) { heard = std::stoi(state.frame_id()); }

  Context& context;
  int heard = 0;

 private:
  void Take(const PoseInFrame& pose) {
    if (pose.frame_id().empty()) throw std::runtime_error("a pose without a frame");
    for (int i = 0; i < 2; ++i) (void)poses_(PoseIn(pose.frame_id() + suffix_));
  }
  void Note(const std::string& name, const Tick& tick) {
    const auto at = std::chrono::duration_cast<std::chrono::milliseconds>(context.clock()->Now() - Time{});
    (void)notes_(PoseIn(name + "@" + std::to_string(at.count()) + (tick.missed > 0 ? " late" : "")));
  }
  std::string suffix_;
  Publisher<PoseInFrame> poses_;
  Publisher<PoseInFrame> notes_;
  Publisher<PoseInFrame> hello_;
};

struct NeedsAMap {
  explicit NeedsAMap(Context&) { throw std::runtime_error("there is no map"); }
};

std::vector<std::string> Frames(const std::vector<std::shared_ptr<const PoseInFrame>>& poses) {
  std::vector<std::string> frames;
  for (const auto& one : poses) frames.push_back(one->frame_id());
  return frames;
}

TEST(Harness, RunsACallbackBeforeFeedReturnsAndHasLatchedMessages) {
  Harness<Doubler> doubler;
  doubler.Feed("pose", PoseIn("map"));
  EXPECT_EQ(doubler->heard, 2);
  EXPECT_THAT(Frames(doubler.Take<PoseInFrame>("twice")), ElementsAre("map!", "map!"));
  EXPECT_THAT(doubler.Take<PoseInFrame>("twice"), IsEmpty());
  EXPECT_THAT(Frames(doubler.Take<PoseInFrame>("hello")), ElementsAre("hello")) << "the constructor has latched it";
  doubler.Feed("pose", std::make_unique<PoseInFrame>(PoseIn("map")));
  EXPECT_EQ(doubler.Take<PoseInFrame>("twice").size(), 2U);
}

TEST(Harness, FiresEachTimerAtItsMomentFromTheGivenTimeOn) {
  Harness<Doubler> doubler;
  doubler.Step(500ms);
  EXPECT_THAT(Frames(doubler.Take<PoseInFrame>("notes")),
              ElementsAre("fast@100", "fast@200", "slow@250", "fast@300", "fast@400", "fast@500", "slow@500"));
  EXPECT_EQ(doubler.now(), Time{} + Duration(500ms));
  doubler.Step(99ms);
  EXPECT_THAT(doubler.Take<PoseInFrame>("notes"), IsEmpty());
  Harness<Doubler> later({.start = Time{} + Duration(10s)});
  later.Step(100ms);
  EXPECT_THAT(Frames(later.Take<PoseInFrame>("notes")), ElementsAre("fast@10100"));
}

TEST(Harness, SetsParameters) {
  Harness<Doubler> doubler({.params = "suffix: '?'"});
  doubler.Feed("pose", PoseIn("map"));
  EXPECT_THAT(Frames(doubler.Take<PoseInFrame>("twice")), ElementsAre("map?", "map?"));
  EXPECT_EQ(doubler.params().Get<std::string>("suffix"), "?");
  EXPECT_THAT([] { Harness<Doubler> refused({.params = "sufix: '?'"}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("no parameter \"sufix\""), HasSubstr("Did you mean \"suffix\"?"))));
  EXPECT_THAT([] { Harness<Doubler> refused({.params = "[1"}); },
              ThrowsMessage<Error>(HasSubstr("HarnessOptions::params")));
}

TEST(Harness, ShowsExceptionsAndLines) {
  Harness<Doubler> doubler;
  doubler.Feed("pose", PoseIn(""));
  EXPECT_EQ(doubler.status().exceptions, 1U);
  EXPECT_EQ(doubler.status().exception, "a pose without a frame");
  doubler->context.log().Write(LogLevel::kInfo, "Something else.");
  EXPECT_EQ(doubler.lines().back(), "Something else.");
}

TEST(Harness, CallsServicesAndGoesOnFromAState) {
  Harness<Doubler> first;
  first.Feed("pose", PoseIn("map"));
  const auto reply = first.Call<PoseInFrame, PoseInFrame>("reverse", PoseIn("abc"));
  ASSERT_TRUE(bool(reply));
  EXPECT_EQ(reply->frame_id(), "cba");
  Harness<Doubler> second({.state = first.Save()});
  EXPECT_EQ(second->heard, 2);
}

TEST(Harness, RefusesWhatTheComponentDoesNotHave) {
  Harness<Doubler> doubler;
  EXPECT_THAT([&] { doubler.Feed("poes", PoseIn("map")); },
              ThrowsMessage<Error>(AllOf(HasSubstr("does not subscribe to \"poes\""), HasSubstr("\"pose\"?"))));
  EXPECT_THAT([&] { (void)doubler.Take<PoseInFrame>("thrice"); },
              ThrowsMessage<Error>(HasSubstr("does not advertise")));
  EXPECT_THAT(([&] { (void)doubler.Call<PoseInFrame, PoseInFrame>("x", PoseIn("")); }),
              ThrowsMessage<Error>(AllOf(HasSubstr("does not serve"), HasSubstr("reverse"))));
  EXPECT_THAT([&] { doubler.Feed("pose", foxglove::FrameTransform()); },
              ThrowsMessage<TypeMismatch>(HasSubstr("foxglove.FrameTransform")));
  EXPECT_THAT([] { Harness<NeedsAMap> refused; }, ThrowsMessage<Error>(HasSubstr("there is no map")));
}

}  // namespace
}  // namespace hgros
