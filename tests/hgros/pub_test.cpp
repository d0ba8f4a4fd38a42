#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <robot/Hand.pb.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <foxglove/Log.pb.h>
#include <foxglove/Pose.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/proto_folder.hpp"
#include "hgros/run_time_types.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::_;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// The texts of the messages that come.
class Heard {
 public:
  Heard() = default;
  Heard(Session& session, const std::string& channel, Queue queue = Queue::KeepAll(64))
      : subscription_(session.FromAny<Log>(channel, Invoke::kSerial,
                                           [this](const Log& log) {
                                             last_second_ = log.timestamp().seconds();
                                             Add(log.message());
                                           },
                                           {.queue = queue})) {}

  void Add(std::string text) {
    const std::scoped_lock lock(mutex_);
    texts_.push_back(std::move(text));
  }
  [[nodiscard]] std::vector<std::string> texts() const {
    const std::scoped_lock lock(mutex_);
    return texts_;
  }
  [[nodiscard]] bool Await(std::size_t count) const {
    return test::Await([&] { return texts().size() >= count; });
  }
  [[nodiscard]] std::int64_t last_second() const { return last_second_; }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> texts_;  // Guarded by mutex_.
  std::atomic<std::int64_t> last_second_ = 0;
  Subscription subscription_;
};

TEST(HgrosPub, PublishesOnceOrAgainAndAgainWithoutLosingAMessage) {
  RobotForCommands robot;
  const Heard heard(robot.session(), "wish");
  const Heard again(robot.session(), "wish");
  EXPECT_THAT(robot.Run(Patiently({"pub", "wish", "{message: hello, level: INFO, timestamp: now}", "--json"})),
              Writes(AllOf(HasSubstr(R"({"channel":"wish","type":"foxglove.Log","messages":1,"bytes":)"),
                           HasSubstr(R"("subscribers":1})"))));
  ASSERT_TRUE(heard.Await(1));
  EXPECT_THAT(heard.texts(), ElementsAre("hello"));
  EXPECT_GT(heard.last_second(), 1'700'000'000);
  EXPECT_EQ(robot.Run(Patiently({"pub", "wish", "message: more"})).out, "");
  ASSERT_TRUE(again.Await(2));
  EXPECT_EQ(robot.Run(Patiently({"pub", "wish", "{message: a}", "--rate", "50", "-n", "5"})).status, 0);
  ASSERT_TRUE(heard.Await(7));
  EXPECT_EQ(heard.texts().size(), 7U);
  for (const std::vector<std::string>& example : ExamplesOf("pub")) {
    EXPECT_THAT(robot.Run(Patiently(example)), Ends(0, _));
  }
  ASSERT_TRUE(heard.Await(7 + 6));
  CommandRun run({"pub", "wish", "{message: b}", "--rate", "50"}, robot.environment());
  ASSERT_TRUE(test::Await([&] { return std::ranges::count(heard.texts(), std::string("b")) >= 3; }));
  run.End();
  EXPECT_EQ(run.out() + run.err(), "");
}

TEST(HgrosPub, WaitsForSubscribersAndSaysThatThereAreNone) {
  RobotForCommands robot;
  EXPECT_THAT(robot.Run({"pub", "wish", "{message: a}", "--type", "foxglove.Log", "--timeout", "0.1"}),
              Ends(3, "hgros: Nobody subscribes to wish, so nobody gets the message.\n"));
  EXPECT_THAT(robot.Run({"pub", "wish", "{message: a}", "--timeout", "0.1"}),
              Ends(3, HasSubstr("The type of wish is not known")));
  EXPECT_THAT(robot.Run({"pub", "wish", "{message: a}"}),
              Ends(1, HasSubstr("The type of wish is not known, because no session uses it. Name it with --type")));
  CommandRun early({"pub", "wish", "{message: a}", "--timeout", "40"}, robot.environment());
  CommandRun latched({"pub", "late", "{message: late}", "--type", "foxglove.Log", "--latched"}, robot.environment());
  ASSERT_TRUE(test::Await(
      [&] { return std::ranges::count(robot.session().Channels(), std::string("late"), &KnownChannel::name) > 0; }));
  const Heard wish(robot.session(), "wish");
  EXPECT_EQ(early.Wait(), 0) << early.err();
  ASSERT_TRUE(wish.Await(1));
  const Heard late(robot.session(), "late");
  ASSERT_TRUE(late.Await(1));
  EXPECT_THAT(late.texts(), ElementsAre("late"));
  latched.End(SIGTERM);
}

struct Number {
  double value = 0;
};

TEST(HgrosPub, RefusesWhatItCannotPublish) {
  RobotForCommands robot;
  const Heard heard(robot.session(), "wish");
  const auto any = robot.session().FromAnyRaw("any", Invoke::kSerial, [](const RawMessage&) {});
  const auto named = robot.session().FromAnyRaw("named", MessageSchema{"foxglove.Log", Encoding::kProtobuf, 0, {}},
                                                Invoke::kSerial, [](const RawMessage&) {});
  const auto number = robot.session().Advertise<Number>("number");
  EXPECT_THAT(robot.Run({"pub", "named", "{}", "--type", "foxglove.Pose"}),
              Ends(1, "hgros: named has the type foxglove.Log, not foxglove.Pose. Leave out --type.\n"));
  EXPECT_THAT(robot.Run({"pub", "any", "{message: a}"}).err,
              HasSubstr("because its subscribers take any type. Name it with --type"));
  EXPECT_THAT(RunToEnd({"pub", "hgros/clock", "{}", "--type", "foxglove.Log"}),
              Ends(2, testing::StartsWith("hgros: Channels that begin with \"hgros/\" belong to the library")));
  EXPECT_THAT(robot.Run({"pub", "wihs", "{}"}).err, HasSubstr("Did you mean wish?"));
  EXPECT_THAT(robot.Run({"pub", "wihs", "{}", "--type", "foxglove.Log"}).err,
              HasSubstr("so nobody gets the message. Did you mean wish?"));
  EXPECT_THAT(robot.Run({"pub", "x", "--type", "foxglove.Lgo"}).err, HasSubstr("Did you mean foxglove.Log?"));
  EXPECT_THAT(robot.Run({"pub", "wish", "{}", "--type", "foxglove.Pose"}),
              Ends(1, "hgros: wish has the type foxglove.Log, not foxglove.Pose. Leave out --type.\n"));
  for (const char* rate : {"1e-300", "1e300"}) {
    EXPECT_THAT(RunToEnd({"pub", "wish", "--type", "foxglove.Log", "--rate", rate}),
                Ends(2, "hgros: --rate must be from 0.000001 to 1000000 Hz.\n"));
  }
  for (const char* command : {"pub", "schema"}) {
    EXPECT_THAT(robot.Run({command, "number"}), Ends(1, HasSubstr("which is not protobuf, so it has no known fields.")))
        << command;
  }
  EXPECT_THAT(robot.Run({"pub", "wish", "{message: \"\x1b[31m\"}"}).err, Not(HasSubstr("\x1b")));
  const std::vector<std::vector<std::string>> hostile{{"pub", "a\x1b[31m", "{}", "--type", "foxglove.Log"},
                                                      {"pub", "wish", "{\"\\u001b[31m\": 1}", "--type", "foxglove.Log"},
                                                      {"pub", "wish", "{}", "--type", "fox\x1b[31m"},
                                                      {"pub", "wish", "--file", "\x1b[31m", "--type", "foxglove.Log"},
                                                      {"schema", "\x1b[31m"},
                                                      {"call", "\x1b[31m"}};
  TwoAtATime(hostile.size(), [&](std::size_t i) {
    const CommandEnd end = robot.Run(hostile[i]);
    EXPECT_NE(end.status, 0);
    EXPECT_THAT(end.err + end.out, Not(HasSubstr("\x1b")));
    EXPECT_NE(end.err, "");
  });
}

TEST(HgrosPub, TellsWhoTakesAnotherTypeAndPublishesThatType) {
  RobotForCommands robot("talker");
  RobotForCommands other("listener", robot.domain());
  const auto publish = robot.session().Advertise<foxglove::Pose>("mixed");
  const Heard heard(other.session(), "mixed");
  other.AwaitAnnounced();
  robot.RunUntil(
      {"pub", "mixed", "{position: {x: 1}}"},
      Ends(1, AllOf(HasSubstr("Nobody subscribes to mixed with this type, so nobody gets the message. listener:"),
                    HasSubstr(" subscribes to mixed with the type foxglove.Log, not foxglove.Pose."))));
  EXPECT_THAT(robot.Run(Patiently({"pub", "mixed", "{message: a}", "--type", "foxglove.Log"})), Ends(0, ""));
  EXPECT_TRUE(heard.Await(1));
}

TEST(HgrosPub, PublishesATypeThatOnlyAPublisherOrASubscriberOfTheChannelKnows) {
  RobotForCommands robot;
  Heard grips;
  Heard hands;
  const RawPublisher publish = robot.session().AdvertiseRaw("grip", GripSchema());
  const Subscription on_grip = robot.session().FromAnyRaw(
      "grip", Invoke::kSerial, [&](const RawMessage& message) { grips.Add(std::string(AsText(message.data.bytes))); });
  // The command is not compiled with this type.
  const Subscription on_hand = robot.session().FromAny<robot::Hand>(
      "hand", Invoke::kSerial, [&](const robot::Hand& hand) { hands.Add(hand.name()); });
  for (const char* channel : {"grip", "hand"}) {
    EXPECT_THAT(robot.Run(Patiently({"pub", channel, "{width: 0.5, name: left}"})), Ends(0, ""));
  }
  ASSERT_TRUE(grips.Await(1));
  EXPECT_EQ(grips.texts().front(), GripBytes(0.5, "left"));
  ASSERT_TRUE(hands.Await(1));
  EXPECT_EQ(hands.texts().front(), "left");
  EXPECT_THAT(robot.Run(Patiently({"pub", "hand", "{widht: 1}"})),
              Ends(2, "hgros: message:1:2: robot.Hand has no field \"widht\". Did you mean width?\n"));
}

TEST(HgrosPub, TellsHowATypeOfSubscribersAloneBecomesKnown) {
  RobotForCommands off("off", {}, "control: off\n");
  const Subscription subscription =
      off.session().FromAny<robot::Hand>("hand", Invoke::kSerial, [](const robot::Hand&) {});
  EXPECT_THAT(
      off.Run({"pub", "hand", "{}", "--timeout", "40"}),
      Ends(1, AllOf(HasSubstr("The type robot.Hand of hand is not known here, and no session that uses it describes "
                              "it: `control: off` is set there"),
                    HasSubstr("Give the type's file with --proto"))));
}

TEST(HgrosPub, PublishesTheLinesOfAFileAndWhatEchoWrote) {
  RobotForCommands robot;
  const auto publish = robot.session().Advertise<Log>("status", {.latched = 2});
  for (const char* text : {"first", "sec\nond \x1b \U0001F600"}) {
    Log log;
    log.set_message(text);
    publish(log);
  }
  const Heard heard(robot.session(), "wish");
  const Heard all(robot.session(), "all", Queue::KeepAll(4));
  const CommandEnd recorded = robot.Run({"echo", "status", "--json", "-n", "2"});
  ASSERT_EQ(recorded.status, 0);
  const ProtoFolder folder{};
  const std::string file = folder.Write("x.jsonl", recorded.out + "\n{\"message\":\"bare\"}");
  EXPECT_EQ(robot.Run(Patiently({"pub", "wish", "--file", file})).err, "");
  ASSERT_TRUE(heard.Await(3));
  EXPECT_THAT(heard.texts(), ElementsAre("first", "sec\nond \x1b \U0001F600", "bare"));
  EXPECT_THAT(robot.Run(Patiently({"pub", "wish", "--file", folder.Write("y.jsonl", "{}\n{\"line\": -1}\n")})),
              Ends(2, AllOf(HasSubstr("hgros: Published 1 message of foxglove.Log on wish to 1 subscriber.\nhgros: "),
                            HasSubstr("y.jsonl:2:10: \"-1\" is out of range for line"))));
  const std::string pose = folder.Write("z.jsonl", R"({"type":"foxglove.Pose","publish_time_ns":1,"message":{}})");
  EXPECT_THAT(robot.Run({"pub", "wish", "--file", pose}).err,
              HasSubstr("z.jsonl:1:9: This message is of the type foxglove.Pose, not foxglove.Log."));
  const std::string parts = robot.Run({"echo", "status", "--json", "--field", "message", "--once"}).out;
  EXPECT_THAT(robot.Run({"pub", "wish", "--file", folder.Write("parts.jsonl", parts)}).err,
              HasSubstr("parts.jsonl:1:1: This line of `hgros echo` has no whole message."));

  ASSERT_TRUE(heard.Await(4));  // With the good line of y.jsonl.
  const std::string times = folder.Write("t.jsonl",
                                         "{\"publish_time_ns\":1700000000000000000,\"message\":{\"message\":\"a\"}}\n"
                                         "{\"publish_time_ns\":1700000000300000000,\"message\":{\"message\":\"b\"}}\n");
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(robot.Run(Patiently({"pub", "wish", "--file", times, "--as-recorded"})).status, 0);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(300));
  ASSERT_TRUE(heard.Await(6));
  EXPECT_THAT(robot.Run({"pub", "wish", "--as-recorded", "--file", folder.Write("bare.jsonl", "{}\n")}),
              Ends(2, HasSubstr("bare.jsonl:1: This line has no publish_time_ns")));

  std::string lines;
  for (int i = 0; i < 2000; ++i) lines += "{\"message\":\"" + std::to_string(i) + "\"}\n";
  EXPECT_THAT(robot.Run(Patiently({"pub", "all", "--file", folder.Write("all.jsonl", lines)})), Ends(0, _));
  ASSERT_TRUE(all.Await(2000)) << all.texts().size() << " of a lossless subscriber";
  EXPECT_EQ(all.texts().back(), "1999");
}

TEST(HgrosPub, EndsWithCode3WhenPublishingTakesLongerThanTheTimeoutOrALosslessSubscriberHasNoRoom) {
  RobotForCommands robot;
  test::Door door;
  const Heard heard(robot.session(), "wish");
  const Subscription stuck = robot.session().FromAny<Log>("full", Invoke::kSerial, [&](const Log&) { door.Pass(); },
                                                          {.queue = Queue::KeepAll(1)});
  robot.AwaitAnnounced();
  CommandRun rare({"pub", "wish", "{message: a}", "--timeout", "2", "--rate", "0.01"}, robot.environment());
  CommandRun many({"pub", "wish", "{message: a}", "--timeout", "2", "-n", "999"}, robot.environment());
  CommandRun full({"pub", "full", "--rate", "10000", "-n", "100000", "--timeout", "6"}, robot.environment());
  for (CommandRun* run : {&rare, &many}) {
    EXPECT_EQ(run->Wait(), 3);
    EXPECT_THAT(run->err(), HasSubstr("Publishing takes longer than --timeout allows."));
  }
  EXPECT_EQ(full.Wait(), 3);
  EXPECT_THAT(full.err(), HasSubstr("was not published on full: a lossless subscriber has no room for it."));
  door.Open();
}

TEST(HgrosPub, TellsWhyARobotBehindAnEndpointDoesNotHearIt) {
  RobotForCommands robot;
  EndpointConfig endpoint;
  endpoint.endpoint = "tcp://127.0.0.1:*";
  endpoint.all_channels = true;
  robot.session().AddPublisherEndpoint(endpoint);
  const Heard heard(robot.session(), "wish");
  EXPECT_THAT(RunToEnd({"pub", "wish", "{message: a}", "--type", "foxglove.Log", "--connect",
                        robot.session().PublisherEndpoints().front()},
                       {{"HGROS_DOMAIN", "none"}}),
              Ends(1, HasSubstr("Use discovery on both sides instead, such as lan in --config.")));
}

}  // namespace
}  // namespace hgros::cli
