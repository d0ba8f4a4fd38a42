#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <functional>
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

using testing::HasSubstr;
using testing::MatchesRegex;

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
  // As soon as it shows that: a command listens for a second only, and the machine may be busy.
  [[nodiscard]] CommandEnd RunUntil(const std::vector<std::string>& arguments,
                                    const std::function<bool(const CommandEnd&)>& shows) const {
    CommandEnd end;
    EXPECT_TRUE(test::Await([&] {
      end = Run(arguments);
      return shows(end);
    })) << end.out
        << end.err;
    return end;
  }

  std::unique_ptr<RobotForCommands> robot_ = std::make_unique<RobotForCommands>("robot");
  std::unique_ptr<Transforms> transforms_ = std::make_unique<Transforms>(robot_->session());
  std::optional<NodeTimer> timer_;
  const test::ScratchFolder folder_;
};

TEST_F(HgrosTf, ShowsAndDrawsTheTreeWithRatesAgesAndPublishers) {
  // A rate needs two transforms.
  const auto shows_rate = [](const CommandEnd& end) {
    return LinesOf(end.out).size() == 6 && end.out.find(" Hz ") != std::string::npos;
  };
  const std::string file = folder_ / "frames.svg";
  std::string svg;
  auto drawn = std::async(std::launch::async, [&] {
    return RunUntil({"tf", "svg", "-o", file, "--timeout", "1"}, [&](const CommandEnd& /*end*/) {
      svg = folder_.Read("frames.svg");
      return svg.find(">laser<") != std::string::npos;
    });
  });
  auto listed = std::async(std::launch::async, [&] {
    return RunUntil({"list", "frames", "--json"}, [](const CommandEnd& one) { return LinesOf(one.out).size() == 5; });
  });
  const CommandEnd end = RunUntil({"tf", "tree"}, shows_rate);
  EXPECT_EQ(end.status, 0) << end.err;
  const std::vector<std::string> lines = LinesOf(end.out);
  ASSERT_EQ(lines.size(), 6U) << end.out;
  EXPECT_EQ(lines[1], "map");
  EXPECT_THAT(lines[2], MatchesRegex("  base +moving +[0-9.]+ Hz +[0-9.]+ [mu]?s +robot"));
  EXPECT_THAT(lines[3], MatchesRegex("    laser +static +robot"));
  EXPECT_EQ(lines[4], "world");
  const std::vector<std::string> json = LinesOf(listed.get().out);
  ASSERT_EQ(json.size(), 5U);
  EXPECT_EQ(json[2],
            R"({"frame":"laser","parent":"base","kind":"static","rate_hz":null,"age_ns":null,"publisher":"robot"})");

  const CommandEnd drawing = drawn.get();
  EXPECT_EQ(drawing.status, 0) << drawing.err;
  EXPECT_THAT(svg, testing::StartsWith("<svg "));

  const auto clock = SimulatedClock::Paused(Time{5'000'000'000});  // Ages are time of the clock that a robot publishes.
  const ClockPublisher publishes(robot_->session(), clock);
  const NodeTimer moves = robot_->session().CreateTimer("gripper", std::chrono::milliseconds(20), [this](const Tick&) {
    transforms_->ToTF(Time{3'000'000'000}, "dock", "gripper", Shift(1));
  });
  const CommandEnd ages = RunUntil({"tf", "tree", "--json"}, [](const CommandEnd& one) {
    return one.out.find(R"("frame":"gripper")") != std::string::npos;
  });
  EXPECT_THAT(ages.out, HasSubstr(R"("age_ns":2000000000)"));
}

TEST_F(HgrosTf, EchoesThePoseOfOneFrameInAnotherOrSaysWhyThereIsNone) {
  const auto fails = [this](const std::vector<std::string>& words, const std::string& why) {
    return std::async(std::launch::async, [=, this] {
      const CommandEnd one =
          RunUntil(words, [&](const CommandEnd& all) { return all.err.find(why) != std::string::npos; });
      EXPECT_EQ(one.status, 1);
      return one.err;
    });
  };
  auto old = fails({"tf", "echo", "map", "base", "--at", "2020-01-01T00:00:00Z"}, "which is too old");
  auto apart = fails({"tf", "echo", "map", "dock"}, "No edges lead from \"dock\" to \"map\"");
  auto misspelled = fails({"tf", "echo", "map", "lasr"}, "the nearest name is");
  const CommandEnd end = Run(Patiently({"tf", "echo", "map", "laser", "--once"}));
  EXPECT_EQ(end.status, 0) << end.err;
  const std::vector<std::string> lines = LinesOf(end.out);
  ASSERT_EQ(lines.size(), 5U) << end.out;
  EXPECT_EQ(lines[1], "position: {x: 2.0000, y: 0.5000, z: 0.0000}");
  EXPECT_EQ(lines[2], "quaternion: {x: 0.000000, y: 0.000000, z: 0.707107, w: 0.707107}");
  EXPECT_EQ(lines[3], "rpy_degrees: {roll: 0.00, pitch: 0.00, yaw: 90.00}");
  const std::vector<std::string> json =
      LinesOf(Run(Patiently({"tf", "echo", "base", "laser", "-n", "2", "--rate", "50", "--json"})).out);
  ASSERT_EQ(json.size(), 2U);
  EXPECT_EQ(json[1],
            R"({"parent":"base","child":"laser","time_ns":null,"age_ns":null,"position":{"x":0.5,"y":0,"z":0},)"
            R"("quaternion":{"x":0,"y":0,"z":0,"w":1},"rpy_degrees":{"roll":0,"pitch":0,"yaw":0}})");

  const CommandEnd now = Run({"tf", "echo", "map", "base", "--at", "now", "--timeout", "40"});
  EXPECT_EQ(now.status, 0) << now.err;
  EXPECT_THAT(now.out, HasSubstr("yaw: 90.00"));
  EXPECT_EQ(Run({"tf", "echo", "map", "base", "--at", "noon"}).status, 2);
  EXPECT_THAT(old.get(), HasSubstr("which is too old"));
  EXPECT_THAT(apart.get(), HasSubstr("No edges lead from"));
  EXPECT_EQ(misspelled.get(), "hgros: No edge has a frame \"lasr\"; the nearest name is \"laser\".\n");

  for (const char* command : {"tf tree", "tf echo"}) {
    for (std::vector<std::string> example : ExamplesOf(command)) {
      if (example[1] == "echo") example.emplace_back("--once");
      if (example[1] == "tree") example.insert(example.end(), {"--timeout", "0.5"});
      (void)RunUntil(example, [](const CommandEnd& one) { return one.status == 0 && !one.out.empty(); });
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
  watch.Signal(SIGINT);
  EXPECT_EQ(watch.Wait(), 128 + SIGINT);
  EXPECT_EQ(watch.out().find("world"), std::string::npos);
}

TEST(HgrosTfAlone, ACommandAndAComponentSendAStaticTransform) {
  const RunningRobot robot(
      "components: {mount: {type: hgros/StaticTransform, params: {parent: base, child: mast, z: 1, yaw: -0.5}}}\n",
      test::Path("slam2d_manifests"));
  const auto environment = robot.environment();
  CommandRun sends({"tf", "static", "mast", "camera", "-0.2", "0", "0.1", "0.5", "0", "1e-3"}, environment);
  EXPECT_TRUE(test::Await([&] {
    const CommandEnd end = RunToEnd(Patiently({"tf", "echo", "base", "camera", "--once"}), environment);
    return end.out.find("z: 1.1000}\n") != std::string::npos &&
           end.out.find("rpy_degrees: {roll: 0.06, pitch: 0.00, yaw: 0.00}") != std::string::npos;
  })) << sends.err()
      << robot.out() << robot.err();
  sends.Signal(SIGINT);
  EXPECT_EQ(sends.Wait(), 128 + SIGINT);
  EXPECT_THAT(RunToEnd({"tf", "static", "a", "b", "0", "0", "high", "0", "0", "0"}, environment),
              Ends(2, "hgros: Z: \"high\" is not a number.\n"));
  EXPECT_EQ(RunToEnd({"tf", "static", "a", "a", "0", "0", "0", "0", "0", "0"}, environment).status, 1);
}

TEST(HgrosTfAlone, EndsAtOnceWhenNothingSendsTransforms) {
  const RobotForCommands robot;
  const CommandEnd tree = robot.Run({"tf", "tree"});
  EXPECT_THAT(tree, Ends(0, "hgros: No session sends transforms. Sessions of other hosts are met with --connect.\n"));
  EXPECT_EQ(tree.out, "");
  EXPECT_THAT(robot.Run({"tf", "echo", "a", "b", "--timeout", "0.1"}),
              Ends(3, "hgros: No session sends transforms.\n"));
  EXPECT_EQ(robot.Run({"tf", "svg"}).status, 1);
  EXPECT_EQ(robot.Run({"tf", "watch", "--timeout", "0.1"}).status, 3);
}

}  // namespace
}  // namespace hgros::cli
