#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidjson/document.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::HasSubstr;

constexpr auto kWork = std::chrono::milliseconds(8);

// A timer publishes scan; the session "mapper" makes map of it, which this session plans with.
struct MappingRobot {
  RobotForCommands robot{"lidar"};
  RobotForCommands mapper{"mapper", robot.environment().at("HGROS_DOMAIN")};
  Publisher<Log> scan = robot.session().Advertise<Log>("scan");
  Publisher<Log> map = mapper.session().Advertise<Log>("map");
  Subscription on_scan = mapper.session().FromAny<Log>("scan", Invoke::kSerial,
                                                       [this](const Log& log) {
                                                         test::Linger(kWork);
                                                         map(log);
                                                       },
                                                       {.name = "mapping"});
  Subscription on_map = robot.session().FromAny<Log>("map", Invoke::kSerial, [](const Log&) {}, {.name = "planning"});
  NodeTimer timer =
      robot.session().CreateTimer("scan", std::chrono::milliseconds(20), [this](const Tick&) { scan(Log()); });

  MappingRobot() { mapper.AwaitAnnounced(); }
};

TEST(HgrosPath, ShowsEachHopAndMarksTheOneThatTakesLongest) {
  MappingRobot mapping;
  const CommandEnd table = mapping.robot.Run({"path", "scan", "map", "--seconds", "1"});
  EXPECT_EQ(table.status, 0) << table.err;
  const std::vector<std::string> lines = LinesOf(table.out);
  ASSERT_EQ(lines.size(), 4U) << table.out;
  EXPECT_THAT(lines[0], testing::StartsWith("CHANNEL  NODE      PROCESS"));
  EXPECT_THAT(lines[1], testing::StartsWith("scan     mapping   mapper:"));
  EXPECT_THAT(lines[1], HasSubstr("* "));
  EXPECT_THAT(lines[2], testing::StartsWith("map      planning  lidar:"));
  EXPECT_THAT(lines[3], HasSubstr(" from scan until planning gets map. * takes longest."));

  const CommandEnd end = mapping.robot.Run({"path", "timer/scan", "map", "--seconds", "1", "--json"});
  EXPECT_EQ(end.status, 0) << end.err;
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
}

// The mapper asks a service for each scan, and publishes the map when it gets the reply.
TEST(HgrosPath, PassesThroughAService) {
  RobotForCommands lidar{"lidar"};
  const std::string domain = lidar.environment().at("HGROS_DOMAIN");
  RobotForCommands mapper{"mapper", domain};
  RobotForCommands locator{"locator", domain};
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
  const Subscription on_map =
      lidar.session().FromAny<Log>("map", Invoke::kSerial, [](const Log&) {}, {.name = "planning"});
  const NodeTimer timer =
      lidar.session().CreateTimer("scan", std::chrono::milliseconds(20), [&](const Tick&) { scan(Log()); });
  mapper.AwaitAnnounced();
  locator.AwaitAnnounced();
  const CommandEnd end = lidar.Run({"path", "scan", "map", "--seconds", "1", "--json"});
  EXPECT_EQ(end.status, 0) << end.err;
  std::vector<std::string> channels;
  for (const std::string& line : LinesOf(end.out)) {
    rapidjson::Document hop;
    ASSERT_FALSE(hop.Parse(line.c_str()).HasParseError()) << line;
    channels.emplace_back(hop["channel"].GetString());
    if (channels.back() != "locate (request)") continue;
    EXPECT_GE(hop["run_p50_ns"].GetInt64(), std::chrono::nanoseconds(kWork).count());
    EXPECT_TRUE(hop["critical"].GetBool());
  }
  EXPECT_THAT(channels, testing::ElementsAre("scan", "locate (request)", "locate (reply)", "replies (callback)", "map"))
      << end.out;
}

TEST(HgrosPath, SaysWhyThereIsNone) {
  MappingRobot mapping;
  const CommandEnd none = mapping.robot.Run({"path", "mpa", "scan", "--seconds", "0.3"});
  EXPECT_EQ(none.status, 1);
  EXPECT_THAT(none.err, HasSubstr("Did you mean map?"));
  EXPECT_THAT(none.err, HasSubstr("No message on scan came from one on mpa in 0.3 s."));
  EXPECT_THAT(none.err, HasSubstr(" began on timer/scan."));
  const CommandEnd silent = mapping.robot.Run({"path", "scan", "pose", "--seconds", "0.1"});
  EXPECT_EQ(silent.status, 1);
  EXPECT_THAT(silent.err, HasSubstr("No node has handled a message on pose in 0.1 s."));
}

TEST(HgrosTrace, WritesSpansAndArrowsThatFitTogether) {
  MappingRobot mapping;
  const auto file = std::filesystem::temp_directory_path() / ("hgros_trace_" + SessionId::Random().ToString());
  const CommandEnd end = mapping.robot.Run({"trace", "--seconds", "1", "-o", file.string()});
  EXPECT_EQ(end.status, 0) << end.err;
  EXPECT_THAT(end.out, HasSubstr(" of 2 sessions are in "));
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  std::filesystem::remove(file);
  rapidjson::Document trace;
  ASSERT_FALSE(trace.Parse(text.str().c_str()).HasParseError()) << text.str();
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
}

TEST(HgrosTrace, FailsInASentenceWhenNothingRunsOrTheFileCannotBeWritten) {
  RobotForCommands robot("still");
  const auto idle = robot.session().Advertise<Log>("idle");
  const CommandEnd nothing = robot.Run({"trace", "--seconds", "0.1"});
  EXPECT_EQ(nothing.status, 1);
  EXPECT_EQ(nothing.err, "hgros: No node did anything in 0.1 s.\n");
  MappingRobot mapping;
  const CommandEnd unwritable = mapping.robot.Run({"trace", "--seconds", "0.1", "-o", "/nowhere/run.json"});
  EXPECT_EQ(unwritable.status, 1);
  EXPECT_THAT(unwritable.err, HasSubstr("The file /nowhere/run.json cannot be written"));
}

TEST(HgrosPath, ExamplesRun) {
  MappingRobot mapping;
  for (const char* command : {"path", "trace"}) {
    const auto examples = ExamplesOf(command);
    EXPECT_GE(examples.size(), 2U);
    for (std::vector<std::string> words : examples) {
      const auto output = std::ranges::find(words, "run.json");
      const std::string file = (std::filesystem::temp_directory_path() / SessionId::Random().ToString()).string();
      if (output != words.end()) *output = file;
      const CommandEnd end = mapping.robot.Run(words);
      EXPECT_EQ(end.status, 0) << end.err;
      EXPECT_FALSE(end.out.empty());
      std::filesystem::remove(file);
    }
  }
}

}  // namespace
}  // namespace hgros::cli
