#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::AllOf;
using testing::HasSubstr;

TEST(HgrosGraph, DrawsProcessesNodesAndChannelsAndNamesTheNearest) {
  RobotForCommands robot("patrol");
  const auto publish = robot.session().Advertise<Log>("status");
  const Subscription heard =
      robot.session().FromAny<Log>("status", Invoke::kSerial, [](const Log&) {}, {.name = "hear"});
  const std::string process = "patrol:" + std::to_string(getpid());
  EXPECT_THAT(robot.Run(Patiently({"graph"})),
              Prints(0, AllOf(HasSubstr("  " + process + "\n"),
                              HasSubstr("status        - \xE2\x94\x80\xE2\x96\xB6 " + process + " hear  process\n"))));
  EXPECT_THAT(robot.Run(Patiently({"graph", "--json"})).out, HasSubstr("\"kind\":\"channel\",\"channel\":\"status\""));
  EXPECT_THAT(robot.Run(Patiently({"graph", "--dot"})).out, HasSubstr("digraph hypergraph {"));
  EXPECT_THAT(robot.Run(Patiently({"graph", "--svg", "--around", "hear"})).out, HasSubstr(">hear</text>"));
  EXPECT_THAT(robot.Run({"graph", "--around", "patrl"}),
              Ends(1, "hgros: No process, node or channel has the name \"patrl\". Did you mean patrol?\n"));
  EXPECT_EQ(robot.Run({"graph", "--depth", "2"}).status, 2);
  EXPECT_EQ(robot.Run({"graph", "--svg", "--dot"}).status, 2);
}

TEST(HgrosGraph, WritesAWholeFileOrNone) {
  const RobotForCommands robot("patrol");
  const test::ScratchFolder folder;
  auto environment = robot.environment();
  environment["FOLDER"] = folder.path();
  const auto run = [&](const std::string& script) { return RunInShell("cd \"$FOLDER\"; " + script, environment); };
  EXPECT_EQ(run("$HGROS graph --dot -o a.dot && ls && tail -1 a.dot").out, "a.dot\n}\n");
  EXPECT_THAT(run("trap '' XFSZ; ulimit -f 0; $HGROS graph --dot -o a.dot"),
              Ends(1, AllOf(HasSubstr("hgros: The file "), HasSubstr("a.dot cannot be written: File too large.\n"))));
  EXPECT_EQ(run("ls; tail -1 a.dot").out, "a.dot\n}\n") << "The file is as it was before.";
  EXPECT_EQ(run("$HGROS graph --dot -o /dev/full").err,
            "hgros: The file /dev/full cannot be written: No space left on device.\n");
  EXPECT_EQ(
      run("ln -s a.dot b.dot; chmod 640 a.dot; $HGROS graph --dot -o b.dot; stat -c %a a.dot; readlink b.dot").out,
      "640\na.dot\n");
  EXPECT_THAT(run("$HGROS graph --dot -o /dev/stdout").out, HasSubstr("digraph"));
  EXPECT_THAT(run("$HGROS graph -o .").err, HasSubstr(". is a folder."));
  // It does not wait for the reader of a pipe.
  EXPECT_THAT(run("mkfifo pipe; $HGROS graph -o pipe"), Ends(1, HasSubstr("Nobody reads the pipe ")));
  EXPECT_THAT(run("exec 3<>pipe; $HGROS graph --dot -o pipe; head -1 <&3").out, HasSubstr("digraph"));
}

}  // namespace
}  // namespace hgros::cli
