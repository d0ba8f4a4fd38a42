#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <robot/Hand.pb.h>

#include <filesystem>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/proto_folder.hpp"
#include "hgros/run_time_types.hpp"
#include "support/path.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(HgrosSchema, ShowsATypeWithoutARobot) {
  EXPECT_THAT(RunToEnd({"schema", "foxglove.Pose"}),
              Writes(HasSubstr("message Pose {\n  Vector3 position = 1;\n  Quaternion orientation = 2;\n}\n")));
  EXPECT_EQ(RunToEnd({"schema", "foxglove.Vector3", "--template"}).out, "x: 0.0\ny: 0.0\nz: 0.0\n");
  EXPECT_THAT(
      LinesOf(RunToEnd({"schema", "foxglove.LaserScan", "--json"}).out),
      testing::IsSupersetOf(
          {R"({"type":"foxglove.LaserScan","field":"ranges","number":6,"kind":"double","repeated":true})",
           R"({"type":"foxglove.Pose","field":"position","number":1,"kind":"foxglove.Vector3","repeated":false})"}));
  const ProtoFolder folder{};
  const std::string file = folder.Write("arm.proto", "syntax = \"proto3\"; package arm; message Arm { bool on = 1; }");
  EXPECT_THAT(RunToEnd({"schema", "arm.Arm", "--proto", file}).out, HasSubstr("  bool on = 1;\n"));
  const std::string broken = folder.Write("broken.proto", "syntax = \"proto3\";\nmessage \n");
  EXPECT_THAT(RunToEnd({"schema", "arm.Arm", "--proto", broken}),
              Ends(2, HasSubstr("broken.proto:3:1: Expected message name.")));
  for (const std::vector<std::string>& example : ExamplesOf("schema")) EXPECT_EQ(RunToEnd(example).status, 0);
}

TEST(HgrosSchema, ShowsTheTypeOfAChannelThatOnlyAPublisherOrASubscriberKnows) {
  RobotForCommands robot;
  const auto status = robot.session().Advertise<foxglove::Log>("status");
  const RawPublisher grip = robot.session().AdvertiseRaw("grip", GripSchema(), {.latched = 1});
  const Subscription subscription =
      robot.session().FromAny<robot::Hand>("hand", Invoke::kSerial, [](const robot::Hand&) {});
  EXPECT_EQ(robot.Run(Patiently({"schema", "status"})).out, RunToEnd({"schema", "foxglove.Log"}).out);
  for (const std::string type : {"Grip", "Hand"}) {
    std::string by_channel;
    for (const std::string& name : {std::string(type == "Grip" ? "grip" : "hand"), "robot." + type}) {
      const CommandEnd end = robot.Run(Patiently({"schema", name}));
      EXPECT_EQ(end.err, "");
      EXPECT_THAT(end.out, HasSubstr("message " + type + " {\n  double width = 1;\n  string name = 2;\n}\n"));
      if (by_channel.empty()) by_channel = end.out;
      EXPECT_EQ(end.out, by_channel);
    }
  }
  EXPECT_THAT(robot.Run({"schema", "foxglove.Lgo"}),
              Ends(1, "hgros: There is no channel and no known type foxglove.Lgo. Did you mean foxglove.Log?\n"));
}

// The endpoint of the foreign publisher.
std::string EndpointOf(const CommandRun& publisher) {
  return publisher.Prints("\n") ? publisher.out().substr(0, publisher.out().find('\n')) : "";
}

const std::string kNotDescribed =
    "hgros: The type robot.Hand of hand is not known here, and no session that uses it describes it: ";

// It used to ask again and again until --timeout, which is longer than the test may take.
TEST(HgrosSchema, TellsAtOnceThatADescriptionIsTooLarge) {
  const CommandRun publisher({"large"}, {}, -1, test::Path("foreign_publisher"));
  EXPECT_THAT(
      RunToEnd({"schema", "robot.Hand", "--connect", EndpointOf(publisher), "--timeout", "3000"}),
      Ends(1, AllOf(HasSubstr(": foreign:"), HasSubstr(kNotDescribed),
                    HasSubstr(" describes robot.Hand with 3000000 bytes. A description of more than 1048576 bytes is "
                              "refused.\n"))));
}

// A session of version 1 would not answer, and the command would wait for --timeout, longer than the test may take.
TEST(HgrosSchema, DoesNotAskASessionThatTakesOnlyOlderRequests) {
  const CommandRun publisher({"older"}, {}, -1, test::Path("foreign_publisher"));
  for (const std::vector<std::string>& command : {std::vector<std::string>{"schema", "hand"}, {"pub", "hand", "{}"}}) {
    std::vector<std::string> words = command;
    words.insert(words.end(), {"--connect", EndpointOf(publisher), "--timeout", "3000"});
    EXPECT_THAT(RunToEnd(words),
                Ends(1, AllOf(testing::StartsWith(kNotDescribed), HasSubstr("it runs an older version"))));
  }
}

// Its folder is known from the place of the program.
TEST(HgrosSchema, FindsInstalledFiles) {
  const ProtoFolder prefix{};
  (void)prefix.Write("share/hgros/proto/robot/Claw.proto", "syntax = \"proto3\"; package robot; message Claw {}");
  const std::string program = prefix.Write("bin/hgros", "");
  std::filesystem::copy_file(test::Path("hgros"), program, std::filesystem::copy_options::overwrite_existing);
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  CommandRun run({"schema", "robot.Claw"}, {}, -1, program);
  EXPECT_EQ(run.Wait(), 0);
  EXPECT_EQ(run.out(), "// robot.Claw, from robot/Claw.proto\nmessage Claw {\n}\n");
}

}  // namespace
}  // namespace hgros::cli
