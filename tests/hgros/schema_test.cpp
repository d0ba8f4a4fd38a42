#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <robot/Hand.pb.h>

#include <cstdio>
#include <filesystem>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/proto_folder.hpp"
#include "hgros/run_time_types.hpp"
#include "support/path.hpp"

namespace hgros::cli {
namespace {

using testing::HasSubstr;

TEST(HgrosSchema, ShowsATypeWithoutARobot) {
  const CommandEnd end = RunToEnd({"schema", "foxglove.Pose"});
  EXPECT_EQ(end.status, 0);
  EXPECT_EQ(end.err, "");
  EXPECT_THAT(end.out, HasSubstr("message Pose {\n  Vector3 position = 1;\n  Quaternion orientation = 2;\n}\n"));
  EXPECT_EQ(RunToEnd({"schema", "foxglove.Vector3", "--template"}).out, "x: 0.0\ny: 0.0\nz: 0.0\n");
}

TEST(HgrosSchema, ShowsTheTypeOfAChannel) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<foxglove::Log>("status");
  EXPECT_EQ(robot.Run(Patiently({"schema", "status"})).out, RunToEnd({"schema", "foxglove.Log"}).out);
}

TEST(HgrosSchema, ShowsATypeThatOnlyThePublisherKnows) {
  RobotForCommands robot;
  const RawPublisher publish = robot.session().AdvertiseRaw("grip", GripSchema(), {.latched = 1});
  const CommandEnd end = robot.Run(Patiently({"schema", "grip"}));
  EXPECT_EQ(end.err, "");
  EXPECT_THAT(end.out, HasSubstr("message Grip {\n  double width = 1;\n  string name = 2;\n}\n"));
  EXPECT_EQ(robot.Run(Patiently({"schema", GripSchema().type_name})).out, end.out);
}

TEST(HgrosSchema, ShowsATypeThatOnlyASubscriberKnows) {
  RobotForCommands robot;
  const Subscription subscription =
      robot.session().FromAny<robot::Hand>("hand", Invoke::kSerial, [](const robot::Hand&) {});
  for (const char* name : {"hand", "robot.Hand"}) {
    const CommandEnd end = robot.Run({"schema", name, "--timeout", "40"});
    EXPECT_EQ(end.err, "");
    EXPECT_THAT(end.out, HasSubstr("message Hand {\n  double width = 1;\n  string name = 2;\n}\n"));
  }
}

// The endpoint of the foreign publisher.
std::string EndpointOf(const CommandRun& publisher) {
  return publisher.Prints("\n") ? publisher.out().substr(0, publisher.out().find('\n')) : "";
}

constexpr std::string_view kNotDescribed =
    "hgros: The type robot.Hand of hand is not known here, and no session that uses it describes it: ";

// It used to ask again and again until --timeout, which is longer than the test may take.
TEST(HgrosSchema, TellsAtOnceThatADescriptionIsTooLarge) {
  const CommandRun publisher({"large"}, {}, -1, test::Path("foreign_publisher"));
  const CommandEnd end = RunToEnd({"schema", "robot.Hand", "--connect", EndpointOf(publisher), "--timeout", "3000"});
  EXPECT_EQ(end.status, 1);
  EXPECT_THAT(end.err, HasSubstr("(foreign, process "));
  EXPECT_THAT(end.err,
              HasSubstr(" describes robot.Hand with 3000000 bytes. A description of more than 1048576 bytes is "
                        "refused.\n"));
  EXPECT_THAT(end.err, HasSubstr(kNotDescribed));
}

// A session of version 1 would not answer, and the command would wait for --timeout, longer than the test may take.
TEST(HgrosSchema, DoesNotAskASessionThatTakesOnlyOlderRequests) {
  const CommandRun publisher({"older"}, {}, -1, test::Path("foreign_publisher"));
  for (const std::vector<std::string>& command : {std::vector<std::string>{"schema", "hand"}, {"pub", "hand", "{}"}}) {
    std::vector<std::string> words = command;
    for (const std::string& word :
         {std::string("--connect"), EndpointOf(publisher), std::string("--timeout"), std::string("3000")})
      words.push_back(word);
    const CommandEnd end = RunToEnd(words);
    EXPECT_EQ(end.status, 1) << command.front();
    EXPECT_THAT(end.err, testing::StartsWith(std::string(kNotDescribed)));
    EXPECT_THAT(end.err, HasSubstr("it runs an older version"));
  }
}

TEST(HgrosSchema, WritesFieldsAsJson) {
  const std::vector<std::string> lines = LinesOf(RunToEnd({"schema", "foxglove.LaserScan", "--json"}).out);
  EXPECT_THAT(lines,
              testing::Contains(
                  R"({"type":"foxglove.LaserScan","field":"ranges","number":6,"kind":"double","repeated":true})"));
  EXPECT_THAT(
      lines,
      testing::Contains(
          R"({"type":"foxglove.Pose","field":"position","number":1,"kind":"foxglove.Vector3","repeated":false})"));
}

TEST(HgrosSchema, ReadsFilesAndTellsTheirFaults) {
  const ProtoFolder folder;
  const std::string file = folder.Write("arm.proto", "syntax = \"proto3\"; package arm; message Arm { bool on = 1; }");
  EXPECT_THAT(RunToEnd({"schema", "arm.Arm", "--proto", file}).out, HasSubstr("  bool on = 1;\n"));
  const std::string broken = folder.Write("broken.proto", "syntax = \"proto3\";\nmessage \n");
  const CommandEnd end = RunToEnd({"schema", "arm.Arm", "--proto", broken});
  EXPECT_EQ(end.status, 2);
  EXPECT_THAT(end.err, HasSubstr("broken.proto:3:1: Expected message name."));
}

// Its folder is known from the place of the program.
TEST(HgrosSchema, FindsInstalledFiles) {
  const ProtoFolder prefix;
  (void)prefix.Write("share/hgros/proto/robot/Claw.proto", "syntax = \"proto3\"; package robot; message Claw {}");
  const std::string program = prefix.Write("bin/hgros", "");
  std::filesystem::copy_file(test::Path("hgros"), program, std::filesystem::copy_options::overwrite_existing);
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  FILE* run = popen((program + " schema robot.Claw").c_str(), "r");
  ASSERT_NE(run, nullptr);
  char text[200] = {};
  (void)!fread(text, 1, sizeof text - 1, run);
  EXPECT_EQ(pclose(run), 0);
  EXPECT_STREQ(text, "// robot.Claw, from robot/Claw.proto\nmessage Claw {\n}\n");
}

TEST(HgrosSchema, ItsExamplesWork) {
  for (const std::vector<std::string>& example : ExamplesOf("schema")) EXPECT_EQ(RunToEnd(example).status, 0);
}

TEST(HgrosSchema, NamesTheNearestType) {
  RobotForCommands robot;
  const CommandEnd end = robot.Run({"schema", "foxglove.Lgo"});
  EXPECT_EQ(end.status, 1);
  EXPECT_EQ(end.err, "hgros: There is no channel and no known type foxglove.Lgo. Did you mean foxglove.Log?\n");
}

}  // namespace
}  // namespace hgros::cli
