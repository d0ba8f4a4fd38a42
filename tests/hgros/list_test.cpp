#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/graph/handed_over.hpp"
#include "hgros/tf/transforms.hpp"
#include "hgros/transport/curve_key_pair.hpp"
#include "support/path.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::AllOf;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::ResultOf;
using testing::StartsWith;

TEST(HgrosList, ShowsChannelsWithTypeUsersLatchedMessagesRateAndTransports) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 2});
  const Subscription heard = robot.session().FromAny<Log>("wish", Invoke::kSerial, [](const Log&) {});
  robot.RunUntil(Patiently({"list"}),  // A session announces its channels a moment after they were made.
                 Writes("CHANNEL  TYPE          PUB  SUB  RATE  LATCHED  VIA\n"
                        "status   foxglove.Log    1    0     -        2\n"
                        "wish     foxglove.Log    0    1              -\n"));
  const auto out = [&] { return robot.Run(Patiently({"list", "--json"})).out; };
  const std::vector<std::string> json = LinesOf(out());
  ASSERT_EQ(json.size(), 2U);
  EXPECT_EQ(json[0],
            "{\"channel\":\"status\",\"type\":\"foxglove.Log\",\"publishers\":1,\"subscribers\":0,\"rate_hz\":0,"
            "\"latched\":2,\"refused\":0,\"via\":[]}");

  const Subscription own = robot.session().FromAny<Log>("status", Invoke::kSerial, [](const Log&) {});
  EXPECT_THAT(out(), HasSubstr("\"via\":[\"process\"]"));
  CommandRun other({"echo", "status"}, robot.environment());
  ASSERT_TRUE(robot.session().WaitForSubscribers("status", 1, test::kPatience));
  EXPECT_TRUE(test::Await([&] { return out().find("\"via\":[\"process\",\"shared memory\"]") != std::string::npos; }))
      << out();

  const NodeTimer timer = robot.session().CreateTimer("tick", std::chrono::milliseconds(20),
                                                      [&](const Tick&) { publish(std::make_unique<Log>()); });
  const auto rate = [&] {
    const std::string all = out();
    const std::size_t at = all.find("\"rate_hz\":");
    return at == std::string::npos ? 0 : std::strtod(all.c_str() + at + 10, nullptr);
  };
  EXPECT_TRUE(test::Await([&] {
    const double now = rate();
    return now > 5 && now < 60;
  })) << "a busy machine ticks less often";
}

TEST(HgrosList, WaitsForSessionsThatOnlyBeaconsFind) {
  const std::string discovery = "discovery: {local: false, lan: {interfaces: [lo]}}";
  RobotForCommands there("there", {}, discovery + "\nnetwork: {publisher: {ip: 'tcp://127.0.0.1:*'}}");
  const auto publish = there.session().Advertise<Log>("status");
  auto environment = there.environment();
  environment["HGROS_CONFIG"] = discovery;
  for (const std::vector<std::string>& command : {std::vector<std::string>{"list"}, {"info", "status"}}) {
    RunUntil(command, environment, Prints(HasSubstr("foxglove.Log")));
  }
}

TEST(HgrosList, CountsSubscribersThatOnlyThePublisherKnows) {
  const test::ScratchFolder folder;
  const std::string endpoint = "{ip: '" + folder.Ipc() + "'}";
  RobotForCommands here("here", {}, "network: {publisher: " + endpoint + "}");
  const auto publish = here.session().Advertise<Log>("status");
  const Subscription near = here.session().FromAny<Log>("status", Invoke::kSerial, [](const Log&) {});
  RobotForCommands there("there", {}, "network: {subscribers: [" + endpoint + "]}");  // As on another host.
  const Subscription far = there.session().FromAny<Log>("status", Invoke::kSerial, [](const Log&) {});
  ASSERT_TRUE(here.session().WaitForSubscribers("status", 2, test::kPatience));
  here.RunUntil(Patiently({"list"}), Prints(HasSubstr("status   foxglove.Log    1    2 ")));
  // Also publishers that only the subscriber knows.
  there.RunUntil(Patiently({"list"}), Prints(HasSubstr("status   foxglove.Log    1    1 ")));
}

TEST(HgrosList, CountsMessagesThatASubscriberDoesNotTake) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status");
  const Subscription heard = robot.session().FromAny<Log>(
      "status", Invoke::kSerial, [](const Log&) { HandedOver::CountRefusedHere(); }, {.name = "deaf"});
  ASSERT_EQ(publish(Log()), PublishStatus::kOk);
  ASSERT_TRUE(robot.session().WaitIdle(test::kPatience));
  robot.RunUntil(Patiently({"list"}), Prints(HasSubstr("  LATCHED  REFUSED  VIA\n")));
  EXPECT_THAT(robot.Run(Patiently({"list", "--json"})).out, HasSubstr("\"refused\":1,"));
  EXPECT_THAT(robot.Run(Patiently({"info", "deaf"})).out, HasSubstr("  Refused      1\n"));
}

TEST(HgrosList, ShowsFramesWithParentAgeAndPublisher) {
  RobotForCommands robot("patrol");
  Transforms transforms(robot.session());
  transforms.ToStaticTF("base", "laser", RigidTransform());
  robot.RunUntil({"list", "frames"},
                 Prints("FRAME    KIND    RATE  AGE  PUBLISHER\nbase\n  laser  static             patrol\n"));
  const NodeTimer timer = robot.session().CreateTimer("tick", std::chrono::milliseconds(20), [&](const Tick&) {
    transforms.ToTF(WallNow(), "map", "base", RigidTransform());
  });
  robot.RunUntil(
      {"list", "frames", "--json"},
      Prints(ResultOf(LinesOf, ElementsAre(StartsWith(R"({"frame":"map","parent":null,"kind":null,)"),
                                           StartsWith(R"({"frame":"base","parent":"map","kind":"moving",)"),
                                           HasSubstr(R"("frame":"laser","parent":"base","kind":"static")")))));
}

TEST(HgrosList, ShowsSessionsNodesAndServices) {
  RobotForCommands robot("patrol");
  const Subscription heard =
      robot.session().FromAny<Log>("wish", Invoke::kSerial, [](const Log&) {}, {.name = "granting"});
  const Service service = robot.session().Serve<Log, Log>("ask", [](const Log& log) { return log; });
  robot.RunUntil(Patiently({"list", "services"}), Prints(HasSubstr("ask      foxglove.Log  patrol:")));
  EXPECT_THAT(robot.Run(Patiently({"list", "sessions"})).out, HasSubstr("patrol"));
  EXPECT_THAT(robot.Run(Patiently({"list", "nodes"})).out, HasSubstr("granting"));
  EXPECT_THAT(robot.Run(Patiently({"list", "services", "--json"})).out,
              HasSubstr("\"servers\":[{\"process\":\"patrol\",\"pid\":" + std::to_string(getpid()) + ",\"host\":\""));
  EXPECT_THAT(robot.Run({"list"}).out, Not(HasSubstr("hgros/")));
  EXPECT_THAT(robot.Run(Patiently({"list", "--all"})).out, HasSubstr("hgros/snapshots"));
}

TEST(HgrosList, SaysSoWhenNothingRuns) {
  const CommandEnd end = RunInShell(
      "for what in channels sessions nodes services params frames; do\n"
      "  $HGROS list $what --domain $HGROS_DOMAIN$what || echo $what &\n"
      "done; wait",
      OwnDomain());
  EXPECT_EQ(end.out, "");
  for (const char* what : {"channels", "sessions", "nodes", "services", "params", "frames"}) {
    EXPECT_THAT(end.err, ContainsRegex("hgros: No sessions in domain [^ ]*" + std::string(what) + "\\."));
  }
}

TEST(HgrosList, NamesTheDomainInWhichSomethingRuns) {
  const std::string domain = "0first" + std::to_string(getpid());  // The names are sorted.
  RobotForCommands robot("robot", domain);
  const auto publish = robot.session().Advertise<Log>("log");
  std::string said;
  EXPECT_TRUE(test::Await([&] {
    said = RunToEnd({"list"}, OwnDomain()).err;
    return said.find(". There are some in: " + domain) != std::string::npos;
  })) << said;
}

TEST(HgrosList, MeetsASessionBehindAnEndpointOrSaysWhyNot) {
  const auto session = [](const std::string& security) {
    return Session(
        Config::Parse("network: {publisher: {ip: 'tcp://127.0.0.1:*'}" + security + "}\ndiscovery: {local: false}\n"),
        SessionOptions{"far", [](LogLevel, std::string_view) {}});
  };
  Session robot = session("");
  const auto publish = robot.Advertise<Log>("status");
  const CurveKeyPair keys = GenerateCurveKeyPair();
  const Session secure =
      session(", security: {public_key: '" + keys.public_key + "', secret_key: '" + keys.secret_key + "'}");
  CommandRun refused({"list", "--connect", secure.PublisherEndpoints().front(), "--timeout", "1.5"}, OwnDomain());
  EXPECT_THAT(RunToEnd(Patiently({"list", "--connect", robot.PublisherEndpoints().front(), "channels"}), OwnDomain()),
              Prints(0, HasSubstr("status   foxglove.Log")));
  EXPECT_THAT(RunToEnd({"list", "--connect", "127.0.0.1:1", "--timeout", "0.2"}),
              Ends(3, HasSubstr("No session answers at tcp://127.0.0.1:1.")));
  EXPECT_EQ(refused.Wait(), 3);
  EXPECT_THAT(refused.err(), HasSubstr(", although a program listens there. It may refuse the key of this command"));
}

TEST(HgrosList, EndsInTimeWhenNoNameServerAnswers) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status");
  robot.AwaitAnnounced();
  std::map<std::string, std::string> environment{{"LD_PRELOAD", test::Path("slow_names")}};
  EXPECT_THAT(RunToEnd({"list", "--connect", "slow.example:5555", "--timeout", "0.3"}, environment),
              Ends(3, HasSubstr("The address of slow.example is not known: no name server answers in time.")));
  const test::ScratchFolder folder;
  const std::string file = folder.Write(
      "desk.yaml", "network: {subscribers: [{ip: 'tcp://slow.example:5555'}, {ip: 'tcp://slow.two:1'}]}\n");
  environment.merge(robot.environment());
  const CommandEnd end = RunToEnd({"list", "--config", file}, environment);  // It leaves out the endpoints.
  EXPECT_THAT(end, Ends(0, AllOf(HasSubstr("The address of slow.example is not known"), HasSubstr("slow.two"))));
  EXPECT_THAT(end.out, HasSubstr("status"));
}

TEST(HgrosList, SaysSoWhenItCanOpenTooFewFiles) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "The sanitizer opens files itself.";
#endif
  TwoAtATime(12, [](std::size_t i) {
    RobotForCommands robot;
    const auto publish = robot.session().Advertise<Log>("status");
    robot.AwaitAnnounced();
    const std::string files = std::to_string(8 + i);
    const CommandEnd end = RunInShell("ulimit -n " + files + "; $HGROS list --timeout 2", robot.environment());
    const bool listed = end.out.find("status") != std::string::npos;
    EXPECT_TRUE(listed || end.err.find("Too many open files") != std::string::npos ||
                end.err.find("limit of open files") != std::string::npos)
        << files << end.out << end.err;
  });
}

}  // namespace
}  // namespace hgros::cli
