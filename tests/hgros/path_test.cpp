#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidjson/document.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <map>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr auto kWork = std::chrono::milliseconds(8);

// A timer publishes scan; the session "mapper" makes map of it, which this session plans with.
struct MappingRobot {
  RobotForCommands robot{"lidar"};
  RobotForCommands mapper{"mapper", robot.domain()};
  Publisher<Log> scan = robot.session().Advertise<Log>("scan");
  Publisher<Log> map = mapper.session().Advertise<Log>("map");
  Subscription on_scan = mapper.session().FromAny<Log>("scan", Invoke::kSerial,
                                                       [this](const Log& log) {
                                                         test::Linger(kWork);
                                                         map(log);
                                                       },
                                                       {.name = "mapping"});
  std::atomic<int> maps{0};
  Subscription on_map =
      robot.session().FromAny<Log>("map", Invoke::kSerial, [this](const Log&) { ++maps; }, {.name = "planning"});
  NodeTimer timer =
      robot.session().CreateTimer("scan", std::chrono::milliseconds(20), [this](const Tick&) { scan(Log()); });

  MappingRobot() {
    mapper.AwaitAnnounced();
    EXPECT_TRUE(test::Await([this] { return maps > 0; })) << "Both are connected.";
  }
};

TEST(HgrosPath, ShowsEachHopAndMarksTheOneThatTakesLongestOrSaysWhyThereIsNone) {
  MappingRobot mapping;
  // On a busy machine, any hop may take longest.
  mapping.robot.RunUntil(
      Patiently({"path", "scan", "map", "--seconds", "1"}),
      Prints(0, testing::ResultOf(
                    LinesOf, testing::ElementsAre(StartsWith("CHANNEL  NODE      PROCESS"),
                                                  AllOf(StartsWith("scan     mapping   mapper:"), HasSubstr("* ")),
                                                  StartsWith("map      planning  lidar:"),
                                                  HasSubstr(" from scan until planning gets map. * takes longest.")))));

  const CommandEnd end = mapping.robot.RunUntil(Patiently({"path", "timer/scan", "map", "--seconds", "1", "--json"}),
                                                Prints(0, HasSubstr("\"channel\":\"map\"")));
  const std::vector<std::string> hops = LinesOf(end.out);
  ASSERT_EQ(hops.size(), 3U) << end.out;
  double share = 0;
  for (std::size_t i = 0; i < hops.size(); ++i) {
    rapidjson::Document hop;
    ASSERT_FALSE(hop.Parse(hops[i].c_str()).HasParseError()) << hops[i];
    EXPECT_EQ(hop["way"].GetInt(), 1);
    EXPECT_EQ(hop["hop"].GetUint(), i + 1);
    EXPECT_GT(hop["messages"].GetInt(), 0);
    EXPECT_EQ(hop["clock_offset_ns"].GetInt(), 0);
    EXPECT_LE(hop["hop_p50_ns"].GetInt64(), hop["hop_p99_ns"].GetInt64());
    share += hop["share"].GetDouble();
    EXPECT_EQ(std::string(hop["channel"].GetString()), (std::vector{"timer/scan", "scan", "map"}.at(i)));
    EXPECT_EQ(hop["pid"].GetInt(), getpid());
    EXPECT_EQ(std::string(hop["process"].GetString()), i == 1 ? "mapper" : "lidar");
    if (i != 1) continue;
    EXPECT_GE(hop["run_p50_ns"].GetInt64(), std::chrono::nanoseconds(kWork).count());
    EXPECT_GT(hop["encode_p50_ns"].GetInt64(), 0);
    EXPECT_GT(hop["transport_p50_ns"].GetInt64(), 0);
    EXPECT_GT(hop["path_p50_ns"].GetInt64(), hop["run_p50_ns"].GetInt64());
  }
  EXPECT_NEAR(share, 1, 0.01);

  mapping.robot.RunUntil(Patiently({"path", "mpa", "scan", "--seconds", "0.3"}),
                         Ends(1, AllOf(HasSubstr(" began on timer/scan."), HasSubstr("Did you mean map?"),
                                       HasSubstr("No message on scan came from one on mpa in 0.3 s."))));
  EXPECT_THAT(mapping.robot.Run({"path", "scan", "pose", "--seconds", "0.1"}),
              Ends(1, HasSubstr("No node has handled a message on pose in 0.1 s.")));
}

// The mapper asks a service for each scan, and publishes the map when it gets the reply.
TEST(HgrosPath, PassesThroughAService) {
  RobotForCommands lidar{"lidar"};
  RobotForCommands mapper{"mapper", lidar.domain()};
  RobotForCommands locator{"locator", lidar.domain()};
  const Publisher<Log> scan = lidar.session().Advertise<Log>("scan");
  const Publisher<Log> map = mapper.session().Advertise<Log>("map");
  const Service service = locator.session().Serve<Log, Log>("locate", [](const Log& log) {
    test::Linger(kWork);
    return log;
  });
  const Subscription on_scan = mapper.session().FromAny<Log>(
      "scan", Invoke::kSerial,
      [&](const Log& log) {
        mapper.session().Call<Log, Log>("locate", log, test::kPatience, [&](const CallResult<Log>& result) {
          if (result) map(*result);
        });
      },
      {.name = "mapping"});
  std::atomic<int> maps{0};
  const Subscription on_map =
      lidar.session().FromAny<Log>("map", Invoke::kSerial, [&](const Log&) { ++maps; }, {.name = "planning"});
  const NodeTimer timer =
      lidar.session().CreateTimer("scan", std::chrono::milliseconds(20), [&](const Tick&) { scan(Log()); });
  mapper.AwaitAnnounced();
  locator.AwaitAnnounced();
  ASSERT_TRUE(test::Await([&] { return maps > 0; })) << "All are connected.";
  const CommandEnd end =
      lidar.RunUntil(Patiently({"path", "scan", "map", "--seconds", "1", "--json"}),
                     Prints(0, testing::ContainsRegex("locate \\(request\\)[^\n]*\"critical\":true")));
  std::vector<std::string> channels;
  for (const std::string& line : LinesOf(end.out)) {
    rapidjson::Document hop;
    ASSERT_FALSE(hop.Parse(line.c_str()).HasParseError()) << line;
    channels.emplace_back(hop["channel"].GetString());
    if (channels.back() != "locate (request)") continue;
    EXPECT_GE(hop["run_p50_ns"].GetInt64(), std::chrono::nanoseconds(kWork).count());
  }
  EXPECT_THAT(channels, testing::ElementsAre("scan", "locate (request)", "locate (reply)", "replies (callback)", "map"))
      << end.out;
}

TEST(HgrosTrace, WritesSpansAndArrowsThatFitTogetherAsInItsExamples) {
  MappingRobot mapping;
  const test::ScratchFolder folder;
  const std::string file = folder / "trace.json";
  const auto run_until = [&](const std::vector<std::string>& words, const testing::Matcher<const CommandEnd&>& ends) {
    return std::async(std::launch::async, [=, &mapping] { return mapping.robot.RunUntil(Patiently(words), ends); });
  };
  auto unwritten = run_until({"trace", "--seconds", "0.1", "-o", "/nowhere/run.json"},
                             Ends(1, HasSubstr("The file /nowhere/run.json cannot be written")));
  std::vector<std::future<CommandEnd>> examples;
  for (const char* command : {"path", "trace"}) {
    for (std::vector<std::string> words : ExamplesOf(command)) {
      std::ranges::replace(words, std::string("run.json"), folder / "run.json");
      std::ranges::replace(words, std::string("5"), std::string("1"));
      examples.push_back(run_until(words, Ends(0)));
    }
  }
  mapping.robot.RunUntil(Patiently({"trace", "--seconds", "1", "-o", file}),
                         Prints(0, HasSubstr(" of 2 sessions are in ")));
  const std::string text = folder.Read("trace.json");
  rapidjson::Document trace;
  ASSERT_FALSE(trace.Parse(text.c_str()).HasParseError()) << text;
  std::map<std::string, int> phases;
  std::map<std::string, double> begins;
  std::map<std::string, int> callbacks;
  for (const auto& event : trace["traceEvents"].GetArray()) {
    const std::string phase = event["ph"].GetString();
    ++phases[phase];
    if (phase == "M") continue;
    EXPECT_GE(event["ts"].GetDouble(), 0);
    if (phase == "s") begins[event["id"].GetString()] = event["ts"].GetDouble();
    if (phase == "X" && event["cat"] == "callback") {
      ++callbacks[event["name"].GetString()];
      if (event["name"] == "mapping") {
        EXPECT_GE(event["dur"].GetDouble(), std::chrono::microseconds(kWork).count());
      }
    }
    if (phase != "f") continue;
    ASSERT_TRUE(begins.contains(event["id"].GetString()));
    EXPECT_LE(begins[event["id"].GetString()], event["ts"].GetDouble());
  }
  EXPECT_GT(callbacks["mapping"], 0);
  EXPECT_GT(callbacks["planning"], 0);
  EXPECT_GT(callbacks["scan"], 0) << "the timer";
  EXPECT_EQ(phases["s"], phases["f"]);
  EXPECT_GT(phases["s"], 0);
  EXPECT_EQ(phases["M"], 2);
  EXPECT_EQ(trace["otherData"]["clocks"].Size(), 2U);

  (void)unwritten.get();
  for (std::future<CommandEnd>& example : examples) EXPECT_FALSE(example.get().out.empty());
}

TEST(HgrosTrace, FailsInASentenceWhenNothingRuns) {
  RobotForCommands robot("still");
  const auto idle = robot.session().Advertise<Log>("idle");
  robot.RunUntil(Patiently({"trace", "--seconds", "0.1"}), Ends(1, "hgros: No node did anything in 0.1 s.\n"));
}

}  // namespace
}  // namespace hgros::cli
