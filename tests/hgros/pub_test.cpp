#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <robot/Hand.pb.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <mutex>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>
#include <foxglove/PoseInFrame.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/proto_folder.hpp"
#include "hgros/run_time_types.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::ElementsAre;
using testing::HasSubstr;

// Whether the session knows of somebody who publishes on the channel, or subscribes to it. Others of its own count,
// too.
bool IsUsed(Session& session, const std::string& channel) {
  const std::vector<KnownChannel> known = session.Channels();
  return std::ranges::find(known, channel, &KnownChannel::name) != known.end();
}

// The texts of the messages that come.
class Heard {
 public:
  Heard(Session& session, const std::string& channel, Queue queue = Queue::KeepAll(64))
      : subscription_(session.FromAny<Log>(channel, Invoke::kSerial,
                                           [this](const Log& log) {
                                             const std::scoped_lock lock(mutex_);
                                             texts_.push_back(log.message());
                                             seconds_.push_back(log.timestamp().seconds());
                                           },
                                           {.queue = queue})) {}

  [[nodiscard]] std::vector<std::string> texts() const {
    const std::scoped_lock lock(mutex_);
    return texts_;
  }
  [[nodiscard]] bool Await(std::size_t count) const {
    return test::Await([&] { return texts().size() >= count; });
  }
  [[nodiscard]] std::int64_t last_second() const {
    const std::scoped_lock lock(mutex_);
    return seconds_.back();
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> texts_;
  std::vector<std::int64_t> seconds_;
  Subscription subscription_;
};

TEST(HgrosPub, DoesNotLoseASingleMessage) {
  RobotForCommands robot;
  const Heard heard(robot.session(), "wish");
  const Heard again(robot.session(), "wish");
  const CommandEnd end =
      robot.Run(Patiently({"pub", "wish", "{message: hello, level: INFO, timestamp: now}", "--json"}));
  EXPECT_EQ(end.status, 0);
  EXPECT_EQ(end.err, "");
  EXPECT_THAT(end.out, HasSubstr(R"({"channel":"wish","type":"foxglove.Log","messages":1,"bytes":)"));
  EXPECT_THAT(end.out, HasSubstr(R"("subscribers":1})"));
  ASSERT_TRUE(heard.Await(1));
  EXPECT_THAT(heard.texts(), ElementsAre("hello"));
  EXPECT_GT(heard.last_second(), 1'700'000'000);
  EXPECT_EQ(robot.Run(Patiently({"pub", "wish", "message: more"})).out, "");
  ASSERT_TRUE(again.Await(2));
}

TEST(HgrosPub, WaitsForASubscriberThatStartsLater) {
  RobotForCommands robot;
  CommandRun run({"pub", "wish", "{message: a}", "--timeout", "40"}, robot.environment());
  test::Linger(std::chrono::milliseconds(100));
  const Heard heard(robot.session(), "wish");
  EXPECT_EQ(run.Wait(), 0) << run.err();
  ASSERT_TRUE(heard.Await(1));
}

TEST(HgrosPub, SaysThatNobodySubscribes) {
  RobotForCommands robot;
  const CommandEnd end = robot.Run({"pub", "wish", "{message: a}", "--type", "foxglove.Log", "--timeout", "0.1"});
  EXPECT_EQ(end.status, 3);
  EXPECT_EQ(end.err, "hgros: Nobody subscribes to wish, so nobody gets the message.\n");
  const CommandEnd late = robot.Run({"pub", "wish", "{message: a}", "--timeout", "0.1"});
  EXPECT_EQ(late.status, 3);
  EXPECT_THAT(late.err, HasSubstr("The type of wish is not known"));
  const CommandEnd untyped = robot.Run({"pub", "wish", "{message: a}"});
  EXPECT_EQ(untyped.status, 1);
  EXPECT_THAT(untyped.err, HasSubstr("The type of wish is not known, because no session uses it. Name it with --type"));
}

TEST(HgrosPub, OffersNoChannelForItself) {
  RobotForCommands robot;
  const auto subscription = robot.session().FromAnyRaw("wish", Invoke::kSerial, [](const RawMessage&) {});
  EXPECT_THAT(robot.Run({"pub", "wish", "{message: a}"}).err,
              HasSubstr("because its subscribers take any type. Name it with --type"));
}

TEST(HgrosPub, RefusesChannelsOfTheLibrary) {
  const CommandEnd end = RunToEnd({"pub", "hgros/clock", "{}", "--type", "foxglove.Log"});
  EXPECT_EQ(end.status, 2);
  EXPECT_THAT(end.err, testing::StartsWith("hgros: Channels that begin with \"hgros/\" belong to the library"));
}

TEST(HgrosPub, NamesTheNearestChannelFieldAndType) {
  RobotForCommands robot;
  const Heard heard(robot.session(), "wish");
  EXPECT_THAT(robot.Run({"pub", "wihs", "{}"}).err, HasSubstr("Did you mean wish?"));
  const CommandEnd field = robot.Run({"pub", "wish", "{mesage: a}"});
  EXPECT_EQ(field.status, 2);
  EXPECT_EQ(field.err, "hgros: message:1:2: foxglove.Log has no field \"mesage\". Did you mean message?\n");
  EXPECT_THAT(robot.Run({"pub", "x", "--type", "foxglove.Lgo"}).err, HasSubstr("Did you mean foxglove.Log?"));
  const CommandEnd other = robot.Run({"pub", "wish", "{}", "--type", "foxglove.Pose"});
  EXPECT_EQ(other.status, 1);
  EXPECT_EQ(other.err, "hgros: wish has the type foxglove.Log, not foxglove.Pose. Leave out --type.\n");
  EXPECT_THAT(robot.Run({"pub", "wish", "{message: \"\x1b[31m\"}"}).err, testing::Not(HasSubstr("\x1b")));
}

TEST(HgrosPub, RepeatsUntilItsCount) {
  RobotForCommands robot;
  const Heard heard(robot.session(), "wish");
  const CommandEnd end = robot.Run(Patiently({"pub", "wish", "{message: a}", "--rate", "50", "-n", "5"}));
  EXPECT_EQ(end.status, 0);
  ASSERT_TRUE(heard.Await(5));
  EXPECT_EQ(heard.texts().size(), 5U);
}

TEST(HgrosPub, RepeatsUntilCtrlC) {
  RobotForCommands robot;
  const Heard heard(robot.session(), "wish");
  robot.AwaitAnnounced();
  CommandRun run({"pub", "wish", "{message: a}", "--rate", "50"}, robot.environment());
  ASSERT_TRUE(heard.Await(3));
  run.Signal(SIGINT);
  EXPECT_EQ(run.Wait(), 128 + SIGINT);
  EXPECT_EQ(run.out(), "");
  EXPECT_EQ(run.err(), "");
}

TEST(HgrosPub, GivesALatchedMessageToLateSubscribers) {
  RobotForCommands robot;
  CommandRun run({"pub", "wish", "{message: late}", "--type", "foxglove.Log", "--latched"}, robot.environment());
  ASSERT_TRUE(test::Await([&] { return IsUsed(robot.session(), "wish"); }));
  const Heard heard(robot.session(), "wish");
  ASSERT_TRUE(heard.Await(1));
  EXPECT_THAT(heard.texts(), ElementsAre("late"));
  run.Signal(SIGTERM);
  EXPECT_EQ(run.Wait(), 128 + SIGTERM);
}

TEST(HgrosPub, PublishesATypeThatOnlyAPublisherOfTheChannelKnows) {
  RobotForCommands robot;
  const RawPublisher publish = robot.session().AdvertiseRaw("grip", GripSchema());
  std::mutex mutex;
  std::vector<std::string> heard;
  const Subscription subscription = robot.session().FromAnyRaw(
      "grip", Invoke::kSerial, [&](const std::shared_ptr<const RawMessage>& message, const MessageInfo&) {
        const std::scoped_lock lock(mutex);
        heard.emplace_back(AsText(message->data.bytes));
      });
  const CommandEnd end = robot.Run(Patiently({"pub", "grip", "{width: 0.5, name: left}"}));
  EXPECT_EQ(end.err, "");
  EXPECT_EQ(end.status, 0);
  ASSERT_TRUE(test::Await([&] {
    const std::scoped_lock lock(mutex);
    return !heard.empty();
  }));
  EXPECT_EQ(heard.front(), GripBytes(0.5, "left"));
}

// The command is not compiled with this type.
Subscription HearHands(Session& session) {
  return session.FromAny<robot::Hand>("hand", Invoke::kSerial, [](const robot::Hand&) {});
}

TEST(HgrosPub, PublishesATypeThatOnlyASubscriberOfTheChannelKnows) {
  RobotForCommands robot;
  std::mutex mutex;
  std::vector<std::string> heard;
  const Subscription subscription =
      robot.session().FromAny<robot::Hand>("hand", Invoke::kSerial, [&](const robot::Hand& hand) {
        const std::scoped_lock lock(mutex);
        heard.push_back(hand.name());
      });
  const CommandEnd end = robot.Run({"pub", "hand", "{width: 0.5, name: left}", "--timeout", "40"});
  EXPECT_EQ(end.err, "");
  EXPECT_EQ(end.status, 0);
  ASSERT_TRUE(test::Await([&] {
    const std::scoped_lock lock(mutex);
    return !heard.empty();
  }));
  EXPECT_EQ(heard.front(), "left");
  const CommandEnd wrong = robot.Run({"pub", "hand", "{widht: 1}", "--timeout", "40"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_EQ(wrong.err, "hgros: message:1:2: robot.Hand has no field \"widht\". Did you mean width?\n");
}

TEST(HgrosPub, TellsHowATypeOfSubscribersAloneBecomesKnown) {
  RobotForCommands robot;
  setenv("HGROS_DOMAIN", robot.environment().at("HGROS_DOMAIN").c_str(), 1);
  Session off(Config::Parse("control: off\n"), {.name = "off", .log = [](LogLevel, std::string_view) {}});
  setenv("HGROS_DOMAIN", "none", 1);
  const Subscription subscription = HearHands(off);
  ASSERT_TRUE(test::Await([&] { return IsUsed(robot.session(), "hand"); }));
  const CommandEnd end = robot.Run({"pub", "hand", "{}", "--timeout", "40"});
  EXPECT_EQ(end.status, 1);
  EXPECT_THAT(end.err, HasSubstr("The type robot.Hand of hand is not known here, and no session that uses it describes "
                                 "it: `control: off` is set there"));
  EXPECT_THAT(end.err, HasSubstr("Give the type's file with --proto"));
}

TEST(HgrosPub, PublishesTheLinesOfAFileAndWhatEchoWrote) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 2});
  for (const char* text : {"first", "sec\nond \x1b \U0001F600"}) {
    Log log;
    log.set_message(text);
    publish(log);
  }
  const CommandEnd recorded = robot.Run({"echo", "status", "--json", "-n", "2"});
  ASSERT_EQ(recorded.status, 0);
  const ProtoFolder folder;
  const std::string file = folder.Write("x.jsonl", recorded.out + "\n{\"message\":\"bare\"}");
  const Heard heard(robot.session(), "wish");
  EXPECT_EQ(robot.Run(Patiently({"pub", "wish", "--file", file})).err, "");
  ASSERT_TRUE(heard.Await(3));
  EXPECT_THAT(heard.texts(), ElementsAre("first", "sec\nond \x1b \U0001F600", "bare"));
  const CommandEnd broken =
      robot.Run(Patiently({"pub", "wish", "--file", folder.Write("y.jsonl", "{}\n{\"line\": -1}\n")}));
  EXPECT_EQ(broken.status, 2);
  EXPECT_THAT(broken.err, HasSubstr("hgros: Published 1 message of foxglove.Log on wish to 1 subscriber.\nhgros: "));
  EXPECT_THAT(broken.err, HasSubstr("y.jsonl:2:10: \"-1\" is out of range for line"));
  const CommandEnd other =
      robot.Run({"pub", "wish", "--file",
                 folder.Write("z.jsonl", R"({"type":"foxglove.Pose","publish_time_ns":1,"message":{}})")});
  EXPECT_THAT(other.err, HasSubstr("z.jsonl:1:9: This message is of the type foxglove.Pose, not foxglove.Log."));
  const std::string parts = robot.Run({"echo", "status", "--json", "--field", "message", "--once"}).out;
  EXPECT_THAT(robot.Run({"pub", "wish", "--file", folder.Write("parts.jsonl", parts)}).err,
              HasSubstr("parts.jsonl:1:1: This line of `hgros echo` has no whole message."));
}

TEST(HgrosPub, PublishesAsRecorded) {
  RobotForCommands robot;
  const ProtoFolder folder;
  const std::string file = folder.Write("x.jsonl",
                                        "{\"publish_time_ns\":1700000000000000000,\"message\":{\"message\":\"a\"}}\n"
                                        "{\"publish_time_ns\":1700000000300000000,\"message\":{\"message\":\"b\"}}\n");
  const Heard heard(robot.session(), "wish");
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(robot.Run(Patiently({"pub", "wish", "--file", file, "--as-recorded"})).status, 0);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(300));
  ASSERT_TRUE(heard.Await(2));
  const CommandEnd bare = robot.Run({"pub", "wish", "--as-recorded", "--file", folder.Write("y.jsonl", "{}\n")});
  EXPECT_EQ(bare.status, 2);
  EXPECT_THAT(bare.err, HasSubstr("y.jsonl:1: This line has no publish_time_ns"));
}

TEST(HgrosPub, DeliversAllLinesToALosslessSubscriber) {
  RobotForCommands robot;
  const ProtoFolder folder;
  std::string lines;
  for (int i = 0; i < 2000; ++i) lines += "{\"message\":\"" + std::to_string(i) + "\"}\n";
  const Heard heard(robot.session(), "wish", Queue::KeepAll(4));
  const CommandEnd end = robot.Run(Patiently({"pub", "wish", "--file", folder.Write("x.jsonl", lines)}));
  EXPECT_EQ(end.status, 0) << end.err;
  ASSERT_TRUE(heard.Await(2000)) << heard.texts().size();
  EXPECT_EQ(heard.texts().back(), "1999");
}

TEST(HgrosPub, TellsThatALosslessSubscriberHasNoRoom) {
  RobotForCommands robot;
  test::Door door;
  const Subscription stuck = robot.session().FromAny<Log>("wish", Invoke::kSerial, [&](const Log&) { door.Pass(); },
                                                          {.queue = Queue::KeepAll(1)});
  const CommandEnd end = robot.Run({"pub", "wish", "--rate", "10000", "-n", "100000", "--timeout", "4"});
  door.Open();
  EXPECT_EQ(end.status, 3);
  EXPECT_THAT(end.err, HasSubstr("was not published on wish: a lossless subscriber has no room for it."));
}

TEST(HgrosPub, RefusesARateOutsideItsRange) {
  for (const char* rate : {"1e-300", "1e300"}) {
    const CommandEnd end = RunToEnd({"pub", "wish", "--type", "foxglove.Log", "--rate", rate});
    EXPECT_EQ(end.status, 2);
    EXPECT_EQ(end.err, "hgros: --rate must be from 0.000001 to 1000000 Hz.\n");
  }
}

TEST(HgrosPub, EndsWithCode3WhenPublishingTakesLongerThanTheTimeout) {
  RobotForCommands robot;
  const Heard heard(robot.session(), "wish");
  for (const std::vector<std::string>& how : std::vector<std::vector<std::string>>{{"--rate", "0.01"}, {"-n", "999"}}) {
    robot.AwaitAnnounced();
    std::vector<std::string> words = {"pub", "wish", "{message: a}", "--timeout", "2"};
    words.insert(words.end(), how.begin(), how.end());
    CommandRun run(words, robot.environment());
    EXPECT_EQ(run.Wait(), 3);
    EXPECT_THAT(run.err(), HasSubstr("Publishing takes longer than --timeout allows."));
  }
}

struct Number {
  double value = 0;
};

TEST(HgrosPub, RefusesAChannelThatIsNotProtobuf) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Number>("number");
  for (const char* command : {"pub", "schema"}) {
    const CommandEnd end = robot.Run({command, "number"});
    EXPECT_EQ(end.status, 1) << command;
    EXPECT_THAT(end.err, HasSubstr("which is not protobuf, so it has no known fields.")) << command;
  }
}

TEST(HgrosPub, ItsExamplesWork) {
  RobotForCommands robot;
  const Heard heard(robot.session(), "wish");
  const std::vector<std::vector<std::string>> examples = ExamplesOf("pub");
  ASSERT_GE(examples.size(), 2U);
  for (const std::vector<std::string>& example : examples) {
    const CommandEnd end = robot.Run(Patiently(example));
    EXPECT_EQ(end.status, 0) << end.err;
  }
  ASSERT_TRUE(heard.Await(6));
}

TEST(HgrosPub, EscapesTheNamesThatItIsGiven) {
  RobotForCommands robot;
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"pub", "a\x1b[31m", "{}", "--type", "foxglove.Log"},
                                             {"pub", "wish", "{\"\\u001b[31m\": 1}", "--type", "foxglove.Log"},
                                             {"pub", "wish", "{}", "--type", "fox\x1b[31m"},
                                             {"pub", "wish", "--file", "\x1b[31m", "--type", "foxglove.Log"},
                                             {"schema", "\x1b[31m"},
                                             {"call", "\x1b[31m"}}) {
    const CommandEnd end = robot.Run(words);
    EXPECT_NE(end.status, 0);
    EXPECT_THAT(end.err + end.out, testing::Not(HasSubstr("\x1b")));
    EXPECT_NE(end.err, "");
  }
}

TEST(HgrosPub, TellsWhyARobotBehindAnEndpointDoesNotHearIt) {
  RobotForCommands robot;
  EndpointConfig endpoint;
  endpoint.endpoint = "tcp://127.0.0.1:*";
  endpoint.all_channels = true;
  robot.session().AddPublisherEndpoint(endpoint);
  const Heard heard(robot.session(), "wish");
  const CommandEnd end = RunToEnd({"pub", "wish", "{message: a}", "--type", "foxglove.Log", "--connect",
                                   robot.session().PublisherEndpoints().front()},
                                  {{"HGROS_DOMAIN", "none"}});
  EXPECT_EQ(end.status, 1);
  EXPECT_THAT(end.err, HasSubstr("Use discovery on both sides instead, such as lan in --config."));
}

}  // namespace
}  // namespace hgros::cli
