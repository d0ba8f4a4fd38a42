#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <foxglove/CompressedImage.pb.h>
#include <foxglove/LaserScan.pb.h>
#include <foxglove/PoseInFrame.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"

namespace hgros::cli {
namespace {

TEST(HgrosExamples, RunBesideARobot) {
  RobotForCommands robot("talker");
  const auto scan = robot.session().Advertise<foxglove::LaserScan>("scan");
  const auto odometry = robot.session().Advertise<foxglove::PoseInFrame>("odometry");
  const auto camera = robot.session().Advertise<foxglove::CompressedImage>("camera");
  const Subscription heard =
      robot.session().FromAny<foxglove::LaserScan>("scan", Invoke::kSerial, [](const foxglove::LaserScan&) {});
  const NodeTimer timer = robot.session().CreateTimer("all", std::chrono::milliseconds(5), [&](const Tick&) {
    scan(std::make_unique<foxglove::LaserScan>());
    odometry(std::make_unique<foxglove::PoseInFrame>());
    camera(std::make_unique<foxglove::CompressedImage>());
  });
  robot.AwaitAnnounced();
  std::map<std::string, std::unique_ptr<CommandRun>> runs;  // By line; all at the same time.
  for (const char* command : {"bw", "delay", "echo", "help", "hz", "info", "list"}) {
    const auto examples = ExamplesOf(command);
    EXPECT_GE(examples.size(), 2U) << command;
    for (const std::vector<std::string>& words : examples) {
      EXPECT_EQ(words.front(), command);
      runs[testing::PrintToString(words)] = std::make_unique<CommandRun>(words, robot.environment());
    }
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(2500);
  for (const auto& [line, run] : runs) {
    EXPECT_TRUE(test::Await([&run = *run] { return !run.out().empty(); })) << line << run->err();
    const int status = run->Wait(std::max(end - std::chrono::steady_clock::now(), std::chrono::nanoseconds(1)));
    if (status == -1) {  // Such as hz, which goes on until Ctrl-C.
      run->Signal(SIGINT);
      EXPECT_THAT(run->Wait(), testing::AnyOf(0, 128 + SIGINT)) << line << " may just have ended by itself.";
    } else {
      EXPECT_EQ(status, 0) << line << run->err();
    }
  }
}

}  // namespace
}  // namespace hgros::cli
