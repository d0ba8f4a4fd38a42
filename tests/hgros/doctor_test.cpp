#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <future>

#include <foxglove/LaserScan.pb.h>
#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/tf/transforms.hpp"

namespace hgros::cli {
namespace {

using foxglove::LaserScan;
using foxglove::Log;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

TEST(HgrosDoctor, SaysThatNothingIsWrongOrNobodyIsThere) {
  RobotForCommands robot("patrol");
  const auto publish = robot.session().Advertise<Log>("status");
  CommandRun alone({"doctor"}, OwnDomain());
  EXPECT_THAT(robot.Run(Patiently({"doctor"})), Writes(StartsWith("Nothing is wrong. Sessions: 1, channels: 1.")));
  EXPECT_EQ(alone.Wait(), 0);
  EXPECT_THAT(alone.out(), StartsWith("No sessions in domain "));
}

TEST(HgrosDoctor, FindsFaultsOfChannelsNodesAndThreads) {
  RobotForCommands robot("patrol");
  RobotForCommands other("desk", robot.domain());
  Session& session = robot.session();
  const auto publish = session.Advertise<Log>("status");
  const auto front = session.Advertise<Log>("scan_front");
  const auto odd = session.Advertise<Log>("odd");
  const Subscription wrong = other.session().FromAny<LaserScan>("odd", Invoke::kSerial, [](const LaserScan&) {});
  const auto odder = session.Advertise<Log>("odder");
  const Subscription named =
      other.session().FromAnyRaw("odder", MessageSchema{"foxglove.LaserScan", Encoding::kProtobuf, 0, {}},
                                 Invoke::kSerial, [](const RawMessage&) {});
  const Subscription misspelled = session.FromAny<Log>("scan_frotn", Invoke::kSerial, [](const Log&) {});
  const Subscription slow =
      session.FromAny<Log>("status", Invoke::kSerial, [](const Log&) { test::Linger(std::chrono::milliseconds(40)); },
                           {.name = "slow", .queue = Queue::KeepLast(3), .executor = Executor::Dedicated()});
  std::atomic<bool> lowered{false};
  const Subscription control =
      session.FromAny<Log>("status", Invoke::kSerial,
                           [&](const Log&) {  // As if the system had refused it.
                             const sched_param none{};
                             lowered = sched_setscheduler(0, SCHED_OTHER, &none) == 0;
                           },
                           {.name = "control_of_the_arm", .executor = Executor::Dedicated({}, 10)});
  const NodeTimer timer = session.CreateTimer("tick", std::chrono::milliseconds(10),
                                              [&](const Tick&) { publish(std::make_unique<Log>()); });
  ASSERT_TRUE(test::Await([&] { return lowered.load(); }));
  other.AwaitAnnounced();
  // On a busy machine, not every two seconds show all.
  auto texts = std::async(std::launch::async, [&robot] {
    robot.RunUntil(Patiently({"doctor"}),
                   Prints(1, AllOf(HasSubstr("Node control_of_the_arm of patrol:"),
                                   HasSubstr("should have the real-time priority 10, but its thread has none."),
                                   HasSubstr("ulimit -r 10"), HasSubstr("publishes foxglove.Log on \"odd\", but desk:"),
                                   HasSubstr("publishes foxglove.Log on \"odder\", but desk:"))));
  });
  robot.RunUntil(
      Patiently({"doctor", "--json"}),
      Prints(1, AllOf(HasSubstr("\"check\":\"name\""), HasSubstr("\\\"scan_frotn\\\", which nobody publishes."),
                      HasSubstr("\"check\":\"queue\""), HasSubstr("because its queue of 3 is full"))));
  texts.get();
}

TEST(HgrosDoctor, NamesTheNodeForWhichOthersWait) {
  RobotForCommands robot("patrol", {}, "data_graph: {threads: 1}");
  Session& session = robot.session();
  const auto publish = session.Advertise<Log>("image");
  const Subscription slow =
      session.FromAny<Log>("image", Invoke::kSerial, [](const Log&) { test::Linger(std::chrono::milliseconds(30)); },
                           {.name = "detect", .queue = Queue::Latest()});
  const NodeTimer timer = session.CreateTimer("control", std::chrono::milliseconds(10),
                                              [&](const Tick&) { publish(std::make_unique<Log>()); });
  robot.RunUntil(Patiently({"doctor"}),
                 Prints(testing::ContainsRegex("patrol:[0-9]+ control waits for its turn, because patrol:[0-9]+ detect "
                                               "keeps a worker of the session for ")));
}

TEST(HgrosDoctor, NamesAChannelInAFrameThatNoTransformHas) {
  RobotForCommands robot("lidar");
  Transforms transforms(robot.session());
  ASSERT_TRUE(transforms.ToStaticTF("base", "laser", RigidTransform()));
  const auto right = robot.session().Advertise<LaserScan>("right", {.latched = 1});
  const auto wrong = robot.session().Advertise<LaserScan>("wrong", {.latched = 1});
  LaserScan scan;
  scan.set_frame_id("laser");
  ASSERT_EQ(right(scan), PublishStatus::kOk);
  scan.set_frame_id("lasr");
  ASSERT_EQ(wrong(scan), PublishStatus::kOk);
  const CommandEnd end = robot.RunUntil(Patiently({"doctor"}), Prints(HasSubstr("\"wrong\" of lidar:")));
  EXPECT_THAT(end,
              Prints(1, AllOf(HasSubstr("The nearest frame is \"laser\"."), testing::Not(HasSubstr("\"right\" of")))));
}

}  // namespace
}  // namespace hgros::cli
