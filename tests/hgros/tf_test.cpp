#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <numbers>
#include <optional>
#include <string>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "hgros/session/clock_publisher.hpp"
#include "hgros/tf/transforms.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using testing::_;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::ResultOf;

RigidTransform Shift(double x) { return {RigidTransform::Rotation::Identity(), Eigen::Vector3d(x, 0, 0)}; }

// A robot with the tree map, base, laser, where base turns and moves, and world, dock.
class HgrosTf : public testing::Test {
 protected:
  HgrosTf() {
    transforms_->ToStaticTF("base", "laser", Shift(0.5));
    transforms_->ToStaticTF("world", "dock", Shift(1));
    Move();
    // A session announces its channels a moment after they were made.
    EXPECT_TRUE(test::Await([this] { return LinesOf(Run({"list"}).out).size() == 3; }));
  }
  void Move() {
    const Eigen::AngleAxisd quarter(std::numbers::pi / 2, Eigen::Vector3d::UnitZ());
    timer_ = robot_->session().CreateTimer("base", std::chrono::milliseconds(20), [this, quarter](const Tick&) {
      transforms_->ToTF(WallNow(), "map", "base", {RigidTransform::Rotation(quarter), Eigen::Vector3d(2, 0, 0)});
    });
  }
  [[nodiscard]] CommandEnd Run(std::vector<std::string> arguments) const { return robot_->Run(std::move(arguments)); }

  std::unique_ptr<RobotForCommands> robot_ = std::make_unique<RobotForCommands>("robot");
  std::unique_ptr<Transforms> transforms_ = std::make_unique<Transforms>(robot_->session());
  std::optional<NodeTimer> timer_;
  const test::ScratchFolder folder_;
};

TEST_F(HgrosTf, ShowsAndDrawsTheTreeWithRatesAgesAndPublishers) {
  auto drawn = std::async(std::launch::async, [&] {
    const auto svg = [&](const CommandEnd& /*end*/) { return folder_.Read("frames.svg"); };
    robot_->RunUntil({"tf", "svg", "-o", folder_ / "frames.svg", "--timeout", "1"},
                     AllOf(Ends(0), ResultOf(svg, AllOf(testing::StartsWith("<svg "), HasSubstr(">laser<")))));
  });
  auto listed = std::async(std::launch::async, [&] {
    const std::string laser =
        R"({"frame":"laser","parent":"base","kind":"static","rate_hz":null,"age_ns":null,"publisher":"robot"})";
    robot_->RunUntil({"list", "frames", "--json"}, Prints(ResultOf(LinesOf, ElementsAre(_, _, laser, _, _))));
  });
  // A rate needs two transforms.
  robot_->RunUntil(
      {"tf", "tree"},
      Prints(0,
             ResultOf(LinesOf, ElementsAre(_, "map", MatchesRegex("  base +moving +[0-9.]+ Hz +[0-9.]+ [mu]?s +robot"),
                                           MatchesRegex("    laser +static +robot"), "world", _))));
  drawn.get();
  listed.get();

  const auto clock = SimulatedClock::Paused(Time{5'000'000'000});  // Ages are time of the clock that a robot publishes.
  const ClockPublisher publishes(robot_->session(), clock);
  const NodeTimer moves = robot_->session().CreateTimer("gripper", std::chrono::milliseconds(20), [this](const Tick&) {
    transforms_->ToTF(Time{3'000'000'000}, "dock", "gripper", Shift(1));
  });
  robot_->RunUntil({"tf", "tree", "--json"},
                   Prints(AllOf(HasSubstr(R"("frame":"gripper")"), HasSubstr(R"("age_ns":2000000000)"))));
}

TEST_F(HgrosTf, EchoesThePoseOfOneFrameInAnotherOrSaysWhyThereIsNone) {
  const auto fails = [this](const std::vector<std::string>& words, const testing::Matcher<const std::string&>& why) {
    return std::async(std::launch::async, [=, this] { robot_->RunUntil(words, Ends(1, why)); });
  };
  auto old = fails({"tf", "echo", "map", "base", "--at", "2020-01-01T00:00:00Z"}, HasSubstr("which is too old"));
  auto apart = fails({"tf", "echo", "map", "dock"}, HasSubstr("No edges lead from \"dock\" to \"map\""));
  auto misspelled =
      fails({"tf", "echo", "map", "lasr"}, "hgros: No edge has a frame \"lasr\"; the nearest name is \"laser\".\n");
  EXPECT_THAT(
      Run(Patiently({"tf", "echo", "map", "laser", "--once"})),
      Prints(0, ResultOf(LinesOf, ElementsAre(_, "position: {x: 2.0000, y: 0.5000, z: 0.0000}",
                                              "quaternion: {x: 0.000000, y: 0.000000, z: 0.707107, w: 0.707107}",
                                              "rpy_degrees: {roll: 0.00, pitch: 0.00, yaw: 90.00}", _))));
  EXPECT_THAT(
      LinesOf(Run(Patiently({"tf", "echo", "base", "laser", "-n", "2", "--rate", "50", "--json"})).out),
      ElementsAre(_,
                  R"({"parent":"base","child":"laser","time_ns":null,"age_ns":null,"position":{"x":0.5,"y":0,"z":0},)"
                  R"("quaternion":{"x":0,"y":0,"z":0,"w":1},"rpy_degrees":{"roll":0,"pitch":0,"yaw":0}})"));

  EXPECT_THAT(Run({"tf", "echo", "map", "base", "--at", "now", "--timeout", "40"}), Prints(0, HasSubstr("yaw: 90.00")));
  EXPECT_EQ(Run({"tf", "echo", "map", "base", "--at", "noon"}).status, 2);
  for (auto* failed : {&old, &apart, &misspelled}) failed->get();

  for (const char* command : {"tf tree", "tf echo"}) {
    for (std::vector<std::string> example : ExamplesOf(command)) {
      if (example[1] == "echo") example.emplace_back("--once");
      if (example[1] == "tree") example.insert(example.end(), {"--timeout", "0.5"});
      robot_->RunUntil(example, Prints(0, testing::Not(testing::IsEmpty())));
    }
  }
}

TEST_F(HgrosTf, WatchSaysOnceWhatIsLateAndWhatHasEnded) {
  CommandRun watch({"tf", "watch", "map", "laser"}, robot_->environment());
  EXPECT_TRUE(watch.Prints("map -> base appears: moving, by robot\n"));
  EXPECT_TRUE(watch.Prints("base -> laser appears: static, by robot\n"));
  EXPECT_TRUE(watch.Prints("map -> laser is there\n"));
  const std::uint64_t sent = transforms_->stats().sent_transforms;  // A rate needs several.
  ASSERT_TRUE(test::Await([&] { return transforms_->stats().sent_transforms > sent + 10; }));
  timer_.reset();
  EXPECT_TRUE(watch.Prints("map -> base is late: none for "));
  Move();
  EXPECT_TRUE(watch.Prints("map -> base is back: after "));
  timer_.reset();
  transforms_.reset();
  robot_.reset();
  EXPECT_TRUE(watch.Prints("map -> base disappears: robot has ended or no longer sends transforms\n"));
  watch.End();
  EXPECT_EQ(watch.out().find("world"), std::string::npos);
}

TEST(HgrosTfAlone, ACommandAndAComponentSendAStaticTransform) {
  const RunningRobot robot(
      "components: {mount: {type: hgros/StaticTransform, params: {parent: base, child: mast, z: 1, yaw: -0.5}}}\n",
      test::Path("slam2d_manifests"));
  const auto environment = robot.environment();
  CommandRun sends({"tf", "static", "mast", "camera", "-0.2", "0", "0.1", "0.5", "0", "1e-3"}, environment);
  RunUntil(Patiently({"tf", "echo", "base", "camera", "--once"}), environment,
           Prints(AllOf(HasSubstr("z: 1.1000}\n"), HasSubstr("rpy_degrees: {roll: 0.06, pitch: 0.00, yaw: 0.00}"))));
  sends.End();
  EXPECT_THAT(RunToEnd({"tf", "static", "a", "b", "0", "0", "high", "0", "0", "0"}, environment),
              Ends(2, "hgros: Z: \"high\" is not a number.\n"));
  EXPECT_EQ(RunToEnd({"tf", "static", "a", "a", "0", "0", "0", "0", "0", "0"}, environment).status, 1);
}

TEST(HgrosTfAlone, EndsAtOnceWhenNothingSendsTransforms) {
  const RobotForCommands robot;
  EXPECT_THAT(robot.Run({"tf", "tree"}),
              AllOf(Ends(0, "hgros: No session sends transforms. Sessions of other hosts are met with --connect.\n"),
                    Prints("")));
  EXPECT_THAT(robot.Run({"tf", "echo", "a", "b", "--timeout", "0.1"}),
              Ends(3, "hgros: No session sends transforms.\n"));
  EXPECT_EQ(robot.Run({"tf", "svg"}).status, 1);
  EXPECT_EQ(robot.Run({"tf", "watch", "--timeout", "0.1"}).status, 3);
}

}  // namespace
}  // namespace hgros::cli
