#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <csignal>

#include <foxglove/LaserScan.pb.h>
#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::LaserScan;
using foxglove::Log;
using testing::HasSubstr;

Log Line(const std::string& text) {
  Log log;
  log.set_message(text);
  log.set_level(Log::ERROR);
  log.set_line(7);
  return log;
}

TEST(HgrosEcho, ShowsLatchedMessagesFirst) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 2});
  publish(Line("first"));
  publish(Line("second"));
  const CommandEnd end = robot.Run({"echo", "status", "-n", "2", "--field", "message"});
  EXPECT_EQ(end.status, 0);
  EXPECT_EQ(end.out, "first\nsecond\n");
  EXPECT_EQ(end.err, "");
}

TEST(HgrosEcho, ShowsYamlAndEscapesWhatATerminalWouldObey) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 1});
  publish(Line("a\x1b[31m\n\xC2\x9B \"b\""));
  const CommandEnd end = robot.Run({"echo", "status", "--once"});
  EXPECT_EQ(end.out, "level: ERROR\nmessage: \"a\\x1b[31m\\n\\x9b \\\"b\\\"\"\nname: \"\"\nfile: \"\"\nline: 7\n---\n");
  const CommandEnd json = robot.Run({"echo", "status", "--once", "--json"});
  EXPECT_THAT(json.out, HasSubstr(R"("message":"a\u001B[31m\n\u009B \"b\"")"));
}

TEST(HgrosEcho, WritesCsvWithAHeader) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 2});
  publish(Line("one, two"));
  publish(Line("three"));
  const std::vector<std::string> lines =
      LinesOf(robot.Run({"echo", "status", "-n", "2", "--csv", "--field", "message", "--field", "line"}).out);
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0], "publish_time_ns,message,line");
  EXPECT_THAT(lines[1], testing::EndsWith(",\"one, two\",7"));
  EXPECT_THAT(lines[2], testing::EndsWith(",three,7"));
}

TEST(HgrosEcho, ShortensLongListsUnlessAllIsAskedFor) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<LaserScan>("scan", {.latched = 1});
  LaserScan scan;
  for (int i = 0; i < 20; ++i) scan.add_ranges(i);
  publish(scan);
  EXPECT_THAT(robot.Run({"echo", "scan", "--once"}).out, HasSubstr("13, 14, 15]  # 4 more\n"));
  EXPECT_THAT(robot.Run({"echo", "scan", "--once", "--full"}).out, HasSubstr("17, 18, 19]\n"));
  EXPECT_THAT(robot.Run({"echo", "scan", "--once", "--json"}).out, HasSubstr("17,18,19]"));
}

TEST(HgrosEcho, ShowsOnlyWhatTheFilterAccepts) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 3});
  for (const char* text : {"a", "bb", "ccc"}) publish(Line(text));
  const CommandEnd end = robot.Run(
      {"echo", "status", "--once", "--field", "message", "--filter", "size(message) == 2 && level == 'ERROR'"});
  EXPECT_EQ(end.out, "bb\n");
}

TEST(HgrosEcho, NamesTheNearestFieldAndChannel) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 1});
  publish(Line("a"));
  const CommandEnd field = robot.Run({"echo", "status", "--field", "mesage"});
  EXPECT_EQ(field.status, 2);
  EXPECT_THAT(field.err, HasSubstr("foxglove.Log has no field \"mesage\". Did you mean message?"));
  const CommandEnd index = robot.Run({"echo", "statsu", "--field", "a[99999999999999999999]"});
  EXPECT_EQ(index.status, 2);
  EXPECT_THAT(index.err, HasSubstr("The index in \"a[99999999999999999999]\" is too large."));
  const CommandEnd channel = robot.Run({"echo", "statsu", "--timeout", "0.1"});
  EXPECT_EQ(channel.status, 3);
  EXPECT_THAT(channel.err, HasSubstr("Nobody publishes on statsu yet. Did you mean status?"));
}

TEST(HgrosEcho, EndsSilentlyOnCtrlC) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 1});
  publish(Line("a"));
  CommandRun run({"echo", "status"}, robot.environment());
  ASSERT_TRUE(run.Prints("---"));
  run.Signal(SIGINT);
  EXPECT_EQ(run.Wait(), 128 + SIGINT);
  EXPECT_EQ(run.err(), "");
}

TEST(HgrosEcho, TakesOptionsBeforeTheChannels) {
  RobotForCommands robot;
  const auto one = robot.session().Advertise<Log>("one", {.latched = 1});
  const auto two = robot.session().Advertise<Log>("two", {.latched = 1});
  one(Line("first"));
  two(Line("second"));
  const CommandEnd end = robot.Run({"echo", "--field", "message", "-n", "2", "one", "two"});
  EXPECT_EQ(end.status, 0) << end.err;
  EXPECT_THAT(end.out, HasSubstr("first\n"));
  EXPECT_THAT(end.out, HasSubstr("second\n"));
}

TEST(HgrosEcho, EndsWhenItsReaderGoesOrStandsStill) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<LaserScan>("scan");
  const NodeTimer timer = robot.session().CreateTimer("tick", std::chrono::milliseconds(2), [&](const Tick&) {
    auto scan = std::make_unique<LaserScan>();
    for (int i = 0; i < 2000; ++i) scan->add_ranges(i);
    publish(std::move(scan));
  });
  int ends[2];
  ASSERT_EQ(pipe2(ends, O_CLOEXEC), 0);
  CommandRun stuck({"echo", "scan", "--json"}, robot.environment(), ends[1]);
  int waiting = 0;
  ASSERT_TRUE(test::Await([&] { return ioctl(ends[0], FIONREAD, &waiting) == 0 && waiting > 30000; }));
  stuck.Signal(SIGINT);
  EXPECT_EQ(stuck.Wait(), 128 + SIGINT);
  EXPECT_EQ(stuck.err(), "");
  CommandRun left({"echo", "nothing"}, robot.environment(), ends[1]);
  close(ends[1]);
  ASSERT_TRUE(test::Await([&] { return left.err().find("Nobody publishes") != std::string::npos; }));
  close(ends[0]);
  EXPECT_EQ(left.Wait(), 0);
}

TEST(HgrosEcho, SaysThatNoMessageCameInTime) {
  RobotForCommands robot("talker");
  const auto publish = robot.session().Advertise<foxglove::Log>("status");
  const CommandEnd end = robot.Run({"echo", "status", "--timeout", "0.3"});
  EXPECT_EQ(end.status, 3);
  EXPECT_THAT(end.err, testing::HasSubstr("No message of status came within 0.3 s. talker:"));
  EXPECT_THAT(end.err, testing::EndsWith(" publishes, but sent none.\n"));
  EXPECT_THAT(robot.Run({"echo", "nothing", "--timeout", "0.1"}).err,
              testing::EndsWith("hgros: No message of nothing came within 0.1 s.\n"));
}

}  // namespace
}  // namespace hgros::cli
