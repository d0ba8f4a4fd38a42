#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::AllOf;
using testing::HasSubstr;

// A session that publishes on "status", receives it and serves "ask".
struct PatrolRobot {
  RobotForCommands robot{"patrol"};
  Publisher<Log> publish = robot.session().Advertise<Log>("status", {.latched = 2});
  Subscription heard = robot.session().FromAny<Log>("status", Invoke::kSerial, [](const Log&) {},
                                                    {.name = "hearing", .queue = Queue::KeepLast(3)});
  Service service = robot.session().Serve<Log, Log>("ask", [](const Log& log) { return log; });
};

// As all commands write a session.
std::string OneSession(RobotForCommands& robot) {
  for (const KnownChannel& channel : robot.session().Channels()) {
    for (const ChannelUser& user : channel.publishers) {
      if (user.session != robot.session().id()) continue;
      return "{\"process\":\"" + user.process + "\",\"pid\":" + std::to_string(user.pid) + ",\"host\":\"" + user.host +
             "\",\"session\":\"" + user.session.ToString() + "\"}";
    }
  }
  return "no session";
}

TEST(HgrosInfo, DescribesChannelsSessionsNodesAndServices) {
  PatrolRobot patrol;
  patrol.publish(Log());
  EXPECT_THAT(patrol.robot.Run(Patiently({"info", "status"})),
              Writes(AllOf(HasSubstr("channel status\n  Type         foxglove.Log\n"), HasSubstr("  Latched      2\n"),
                           HasSubstr("\nPUBLISHER "), HasSubstr("\nSUBSCRIBER "), HasSubstr("\nhearing  patrol:"),
                           HasSubstr("  keep last 3  "), HasSubstr("  process\n"))));
  const std::string json = patrol.robot.Run(Patiently({"info", "status", "--json"})).out;
  EXPECT_EQ(LinesOf(json).size(), 1U);
  EXPECT_THAT(
      json, AllOf(HasSubstr("{\"kind\":\"channel\",\"name\":\"status\",\"type\":\"foxglove.Log\","),
                  HasSubstr("\"publishers\":[{\"process\":\"patrol\",\"pid\":" + std::to_string(getpid())),
                  HasSubstr("\"node\":\"hearing\""), HasSubstr("\"queue_depth\":3"), HasSubstr("\"via\":\"process\"")));
  const std::string self = OneSession(patrol.robot);
  EXPECT_THAT(json, HasSubstr("\"pairs\":[{\"from\":" + self + ",\"to\":" + self + ",\"via\":\"process\""));

  for (const std::string& name :
       {std::string("patrol"), "patrol:" + std::to_string(getpid()), patrol.robot.session().id().ToString()}) {
    EXPECT_THAT(patrol.robot.Run(Patiently({"info", name})),
                Prints(0, AllOf(HasSubstr("session patrol\n"), HasSubstr("  Memory "), HasSubstr("\nSERVES\nask\n"),
                                HasSubstr("\nhearing  status "))))
        << name;
  }

  ASSERT_TRUE(patrol.robot.session().WaitIdle(test::kPatience));
  EXPECT_THAT(patrol.robot.Run(Patiently({"info", "hearing"})).out,
              AllOf(HasSubstr("node hearing\n"), HasSubstr("  Queue        keep last 3\n"),
                    HasSubstr("\nDATA SINCE  MESSAGES  AGE P50 "), HasSubstr("\nstatus             1 ")));
  EXPECT_THAT(patrol.robot.Run(Patiently({"info", "ask"})).out,
              AllOf(HasSubstr("service ask\n  Request  foxglove.Log\n"), HasSubstr("\nSERVED BY\npatrol:")));

  EXPECT_THAT(patrol.robot.Run(Patiently({"info", "statsu", "patrol"})),
              AllOf(Ends(1, "hgros: No channel, session, node or service is called statsu. Did you mean status?\n"),
                    Prints(HasSubstr("session patrol\n"))));
  EXPECT_THAT(RunToEnd({"info", "x"}, OwnDomain()),
              Ends(1, "hgros: No channel, session, node or service is called x. `hgros list` shows what there is.\n"));
  EXPECT_THAT(patrol.robot.Run({"info", ""}), Prints(2, ""));
}

TEST(HgrosInfo, DescribesEverythingThatHasTheNameAndAChannelWhosePublisherDoesNotAnswer) {
  RobotForCommands robot("tick");
  const auto publish = robot.session().Advertise<Log>("tick");
  const Subscription heard = robot.session().FromAny<Log>("tick", Invoke::kSerial, [](const Log&) {}, {.name = "tick"});
  EXPECT_THAT(robot.Run(Patiently({"info", "tick"})).out,
              AllOf(HasSubstr("channel tick\n"), HasSubstr("session tick\n"), HasSubstr("node tick\n")));
  const Subscription wished = robot.session().FromAny<Log>("wish", Invoke::kSerial, [](const Log&) {});
  CommandRun stopped({"pub", "wish", "{message: a}", "--latched"}, robot.environment());
  robot.RunUntil({"list", "--json"},  // It is announced.
                 Prints(HasSubstr("\"wish\",\"type\":\"foxglove.Log\",\"publishers\":1")));
  stopped.Signal(SIGSTOP);
  TwoAtATime(2, [&robot](std::size_t i) {
    EXPECT_THAT(robot.Run({"info", "wish", i == 0 ? "--exact" : "--json"}),
                AllOf(Ends(0, HasSubstr("does not answer; its counters are missing.")), Prints(HasSubstr("hgros"))));
  });
}

}  // namespace
}  // namespace hgros::cli
