#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <foxglove/LaserScan.pb.h>
#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::LaserScan;
using foxglove::Log;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

Log Line(const std::string& text) {
  Log log;
  log.set_message(text);
  log.set_level(Log::ERROR);
  log.set_line(7);
  return log;
}

TEST(HgrosEcho, ShowsLatchedMessagesFirstAsAskedFor) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 3});
  const auto more = robot.session().Advertise<Log>("more", {.latched = 1});
  for (const char* text : {"one, two", "bb", "three"}) publish(Line(text));
  more(Line("other"));
  EXPECT_THAT(robot.Run({"echo", "status", "-n", "3", "--field", "message"}), Writes("\"one, two\"\nbb\nthree\n"));
  EXPECT_THAT(LinesOf(robot.Run({"echo", "status", "-n", "3", "--csv", "--field", "message", "--field", "line"}).out),
              testing::ElementsAre("publish_time_ns,message,line", EndsWith(",\"one, two\",7"), testing::_,
                                   EndsWith(",three,7")));
  EXPECT_THAT(robot.Run({"echo", "status", "--once", "--field", "message", "--filter",
                         "size(message) == 2 && level == 'ERROR'"}),
              Prints("bb\n"));
  EXPECT_THAT(robot.Run({"echo", "--field", "message", "-n", "4", "status", "more"}),
              Prints(0, AllOf(HasSubstr("three\n"), HasSubstr("other\n"))));
}

TEST(HgrosEcho, ShowsYamlAndEscapesWhatATerminalWouldObeyUntilCtrlC) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 1});
  publish(Line("a\x1b[31m\n\xC2\x9B \"b\""));
  EXPECT_EQ(robot.Run({"echo", "status", "--once"}).out,
            "level: ERROR\nmessage: \"a\\x1b[31m\\n\\x9b \\\"b\\\"\"\nname: \"\"\nfile: \"\"\nline: 7\n---\n");
  EXPECT_THAT(robot.Run({"echo", "status", "--once", "--json"}).out,
              HasSubstr(R"("message":"a\u001B[31m\n\u009B \"b\"")"));
  CommandRun run({"echo", "status"}, robot.environment());
  ASSERT_TRUE(run.Prints("---"));
  run.End();
  EXPECT_EQ(run.err(), "");
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

TEST(HgrosEcho, NamesTheNearestFieldAndChannelAndSaysThatNoMessageCameInTime) {
  RobotForCommands robot("talker");
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 1});
  const auto silent = robot.session().Advertise<Log>("silent");
  publish(Line("a"));
  EXPECT_THAT(robot.Run({"echo", "status", "--field", "mesage"}),
              Ends(2, HasSubstr("foxglove.Log has no field \"mesage\". Did you mean message?")));
  EXPECT_THAT(robot.Run({"echo", "statsu", "--field", "a[99999999999999999999]"}),
              Ends(2, HasSubstr("The index in \"a[99999999999999999999]\" is too large.")));
  EXPECT_THAT(robot.Run({"echo", "statsu", "--timeout", "0.1"}),
              Ends(3, HasSubstr("Nobody publishes on statsu yet. Did you mean status?")));
  EXPECT_THAT(robot.Run({"echo", "silent", "--timeout", "0.3"}),
              Ends(3, AllOf(HasSubstr("No message of silent came within 0.3 s. talker:"),
                            EndsWith(" publishes, but sent none.\n"))));
  EXPECT_THAT(robot.Run({"echo", "nothing", "--timeout", "0.1"}).err,
              EndsWith("hgros: No message of nothing came within 0.1 s.\n"));
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
  stuck.End();
  EXPECT_EQ(stuck.err(), "");
  CommandRun left({"echo", "nothing"}, robot.environment(), ends[1]);
  close(ends[1]);
  ASSERT_TRUE(test::Await([&] { return left.err().find("Nobody publishes") != std::string::npos; }));
  close(ends[0]);
  EXPECT_EQ(left.Wait(), 0);
}

}  // namespace
}  // namespace hgros::cli
