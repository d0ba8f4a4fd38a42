#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::HasSubstr;

TEST(HgrosGraph, DrawsProcessesNodesAndChannels) {
  RobotForCommands robot("patrol");
  const auto publish = robot.session().Advertise<Log>("status");
  const Subscription heard =
      robot.session().FromAny<Log>("status", Invoke::kSerial, [](const Log&) {}, {.name = "hear"});
  const std::string process = "patrol:" + std::to_string(getpid());
  const CommandEnd text = robot.Run({"graph"});
  EXPECT_EQ(text.status, 0);
  EXPECT_THAT(text.out, HasSubstr("  " + process + "\n"));
  EXPECT_THAT(text.out, HasSubstr("status        - \xE2\x94\x80\xE2\x96\xB6 " + process + " hear  process\n"));
  EXPECT_THAT(robot.Run({"graph", "--json"}).out, HasSubstr("\"kind\":\"channel\",\"channel\":\"status\""));
  EXPECT_THAT(robot.Run({"graph", "--dot"}).out, HasSubstr("digraph hypergraph {"));
  EXPECT_THAT(robot.Run({"graph", "--svg", "--around", "hear"}).out, HasSubstr(">hear</text>"));
}

TEST(HgrosGraph, NamesTheNearestName) {
  RobotForCommands robot("patrol");
  const auto publish = robot.session().Advertise<Log>("status");
  const CommandEnd end = robot.Run({"graph", "--around", "patrl"});
  EXPECT_EQ(end.status, 1);
  EXPECT_EQ(end.err, "hgros: No process, node or channel has the name \"patrl\". Did you mean patrol?\n");
  EXPECT_EQ(robot.Run({"graph", "--depth", "2"}).status, 2);
  EXPECT_EQ(robot.Run({"graph", "--svg", "--dot"}).status, 2);
}

}  // namespace
}  // namespace hgros::cli
