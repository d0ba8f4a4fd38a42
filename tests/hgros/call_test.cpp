#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <regex>
#include <stdexcept>
#include <string>
#include <thread>

#include <foxglove/Log.pb.h>
#include <foxglove/Vector3.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/proto_folder.hpp"
#include "hgros/run_time_types.hpp"
#include "hgros/screen/terminal_run.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using foxglove::Vector3;
using testing::AllOf;
using testing::HasSubstr;

TEST(HgrosCall, ShowsTheReplyOrSaysWhyThereIsNone) {
  RobotForCommands robot;
  const Service size = robot.session().Serve<Log, Vector3>("size", [](const Log& log) {
    Vector3 reply;
    reply.set_x(static_cast<double>(log.message().size()));
    return reply;
  });
  const Service ask = robot.session().Serve<Log, Log>("ask", [](const Log& log) { return log; });
  const Service name = robot.session().Serve<Log, Log>(
      "give_name", [](const Log&) -> Log { throw std::runtime_error("there is \x1b[31m no name"); });
  EXPECT_THAT(robot.Run(Patiently({"call", "size", "{message: hello}"})), Writes("x: 5\ny: 0\nz: 0\n"));
  EXPECT_THAT(robot.Run(Patiently({"call", "size", "{message: hello}", "--json", "--reply-type", "foxglove.Vector3"})),
              Prints(AllOf(testing::StartsWith(R"({"service":"size","type":"foxglove.Vector3","duration_ns":)"),
                           HasSubstr(R"("message":{"x":5,"y":0,"z":0}})"))));
  for (const std::vector<std::string>& example : ExamplesOf("call")) {
    EXPECT_THAT(robot.Run(Patiently(example)), Prints(0, HasSubstr("hello")));
  }

  const std::string nearest = "hgros: No session serves give_nmae. Did you mean give_name?\n";
  EXPECT_THAT(robot.Run({"call", "give_nmae", "{}"}), Ends(1, nearest));
  EXPECT_THAT(robot.Run({"call", "give_nmae", "{}", "--timeout", "0.3"}), Ends(3, nearest));
  EXPECT_THAT(robot.Run({"call", "ask", "{lin: 1}"}),
              Ends(2, "hgros: request:1:2: foxglove.Log has no field \"lin\". Did you mean line?\n"));
  EXPECT_THAT(robot.Run({"call", "ask", "{}", "--reply-type", "foxglove.Pose"}), Ends(1, HasSubstr("foxglove.Pose")));
  EXPECT_THAT(robot.Run({"call", "give_name"}), AllOf(Ends(1, "hgros: there is \\x1b[31m no name\n"), Prints("")));
}

TEST(HgrosCall, WaitFindsAServiceThatIsServedLater) {
  RobotForCommands robot;
  EXPECT_THAT(RunToEnd({"wait", "--service", "ask", "--timeout", "0.3"}, robot.environment()),
              Ends(3, HasSubstr("No session serves ask.")));
  CommandRun wait(Patiently({"wait", "--service", "ask"}), robot.environment());
  const Service ask = robot.session().Serve<Log, Log>("ask", [](const Log& log) { return log; });
  EXPECT_EQ(wait.Wait(), 0) << wait.err();
  EXPECT_THAT(RunToEnd({"wait", "--timeout", "1"}, robot.environment()), Ends(2, HasSubstr("--service")));
}

TEST(HgrosCall, CallsAServiceWhoseTypesAreInAFile) {
  RobotForCommands robot;
  const Service service = robot.session().ServeRaw("grip", GripSchema(), GripSchema(),
                                                   [](const RawMessage& request) { return request.data; });
  const ProtoFolder folder{};
  const std::string file = folder.Write(
      "grip.proto", "syntax = \"proto3\"; package robot; message Grip { double width = 1; string name = 2; }");
  EXPECT_THAT(robot.Run(Patiently({"call", "grip", "{width: 2, name: \"a\\x1b\"}", "--proto", file})),
              Writes("width: 2\nname: \"a\\x1b\"\n"));
  // Without the file, the server describes them.
  EXPECT_THAT(robot.Run(Patiently({"call", "grip", "{width: 3}"})), Writes(HasSubstr("width: 3\n")));
}

TEST(HgrosCall, WaitsForTheReplyAndShowsOnATerminalHowLong) {
  RobotForCommands robot;
  test::Door door;
  const Service service = robot.session().Serve<Log, Log>("ask", [&](const Log& log) {
    door.Pass();
    return log;
  });
  EXPECT_THAT(robot.Run({"call", "ask", "--timeout", "0.2"}), Ends(3, HasSubstr("ask")));
  CommandRun run({"call", "ask"}, robot.environment());
  test::Linger(std::chrono::milliseconds(300));
  run.End();
  EXPECT_EQ(run.err(), "");

  const TerminalRun call({"call", "ask", "{message: hello}", "--timeout", "90"}, robot.environment());
  // How many seconds it waits depends on how long its start took.
  const std::regex line("waiting for the reply of ask: ([0-9]+) of (8[0-9]) s");
  std::smatch found;
  std::string screen;
  const auto waited = [&] {
    screen = testing::PrintToString(call.screen().Lines());
    return std::regex_search(screen, found, line) ? std::stoi(found[1]) : 0;
  };
  ASSERT_TRUE(test::Await([&] { return waited() >= 1; })) << call.written();
  const int first = waited();
  EXPECT_TRUE(test::Await([&] { return waited() > first; })) << call.written();
  door.Open();
  EXPECT_EQ(call.Wait(), 0);
  EXPECT_TRUE(call.Shows("message: hello"));
  EXPECT_TRUE(call.ShowsNot("waiting"));  // Its line has gone.
}

TEST(HgrosCall, TellsThatTheServiceEnded) {
  RobotForCommands robot;
  test::Door door;
  auto service = std::make_unique<Service>(robot.session().Serve<Log, Log>("ask", [&](const Log& log) {
    door.Pass();
    return log;
  }));
  const auto requests = [&] {
    std::uint64_t received = 0;
    for (const ChannelSnapshot& channel : robot.session().Snapshot().graph.channels) {
      for (const NodeSnapshot& node : channel.nodes) received += node.name == "ask" ? node.received : 0;
    }
    return received;
  };
  robot.AwaitAnnounced();
  CommandRun running({"call", "ask", "--timeout", "60"}, robot.environment());
  ASSERT_TRUE(test::Await([&] { return requests() >= 1; }));
  CommandRun waiting({"call", "ask", "--timeout", "60"}, robot.environment());
  ASSERT_TRUE(test::Await([&] { return requests() >= 2; }));
  std::thread ender([&] { service.reset(); });  // Waits for the running handler.
  EXPECT_EQ(waiting.Wait(), 1);
  EXPECT_THAT(waiting.err(), testing::StartsWith("hgros: "));
  door.Open();
  ender.join();
  EXPECT_NE(running.Wait(), -1);
}

}  // namespace
}  // namespace hgros::cli
