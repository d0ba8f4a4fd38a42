#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::HasSubstr;
using testing::Not;

TEST(HgrosList, ShowsChannelsWithTypeUsersAndLatchedMessages) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 2});
  const Subscription heard = robot.session().FromAny<Log>("wish", Invoke::kSerial, [](const Log&) {});
  const CommandEnd end = robot.Run({"list"});
  EXPECT_EQ(end.status, 0);
  EXPECT_EQ(end.err, "");
  EXPECT_THAT(LinesOf(end.out), testing::ElementsAre("CHANNEL  TYPE          PUB  SUB  RATE  LATCHED",
                                                     "status   foxglove.Log    1    0     -        2",
                                                     "wish     foxglove.Log    0    1              -"));
  const std::vector<std::string> json = LinesOf(robot.Run({"list", "--json"}).out);
  ASSERT_EQ(json.size(), 2U);
  EXPECT_EQ(json[0],
            "{\"channel\":\"status\",\"type\":\"foxglove.Log\",\"publishers\":1,\"subscribers\":0,\"rate_hz\":0,"
            "\"latched\":2}");
}

TEST(HgrosList, ShowsTheRateThatThePublisherCounts) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("tick");
  const NodeTimer timer = robot.session().CreateTimer("tick", std::chrono::milliseconds(20),
                                                      [&](const Tick&) { publish(std::make_unique<Log>()); });
  const auto rate = [&] {
    const std::string out = robot.Run({"list", "--json"}).out;
    const std::size_t at = out.find("\"rate_hz\":");
    return at == std::string::npos ? 0 : std::strtod(out.c_str() + at + 10, nullptr);
  };
  EXPECT_TRUE(test::Await([&] { return rate() > 40 && rate() < 60; })) << rate();
}

TEST(HgrosList, ShowsSessionsNodesAndServices) {
  RobotForCommands robot("patrol");
  const Subscription heard =
      robot.session().FromAny<Log>("wish", Invoke::kSerial, [](const Log&) {}, {.name = "granting"});
  const Service service = robot.session().Serve<Log, Log>("ask", [](const Log& log) { return log; });
  EXPECT_THAT(robot.Run({"list", "sessions"}).out, HasSubstr("patrol"));
  EXPECT_THAT(robot.Run({"list", "nodes"}).out, HasSubstr("granting"));
  EXPECT_THAT(robot.Run({"list", "services"}).out, HasSubstr("ask      foxglove.Log  patrol:"));
  EXPECT_THAT(robot.Run({"list"}).out, Not(HasSubstr("hgros/")));
  EXPECT_THAT(robot.Run({"list", "--all"}).out, HasSubstr("hgros/snapshots"));
}

TEST(HgrosList, WritesNothingWhenNothingRuns) {
  for (const char* what : {"channels", "sessions", "nodes", "services", "params"}) {
    const CommandEnd end = RunToEnd({"list", what}, {{"HGROS_DOMAIN", "cli" + std::to_string(RandomId())}});
    EXPECT_EQ(end.status, 0) << what;
    EXPECT_EQ(end.out, "") << what;
    EXPECT_EQ(end.err, "") << what;
  }
}

TEST(HgrosList, EndsWithAnErrorWhenNothingAnswersAtAnEndpoint) {
  const CommandEnd end = RunToEnd({"list", "--connect", "127.0.0.1:1", "--timeout", "0.2"});
  EXPECT_EQ(end.status, 1);
  EXPECT_THAT(end.err, HasSubstr("No session answers at tcp://127.0.0.1:1."));
}

}  // namespace
}  // namespace hgros::cli
