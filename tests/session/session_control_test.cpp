// Sessions change others while these run.
#include "hgros/session/session_control.hpp"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.pb.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <thread>

#include <foxglove/Vector3.pb.h>
#include <hgros/SessionControl.pb.h>

#include "hgros/session/snapshot_message.hpp"
#include "hgros/transport/curve_key_pair.hpp"
#include "session/domain_fixture.hpp"
#include "session/hand_made_session.hpp"

namespace hgros {
namespace {

using test::Await;
using test::kPatience;
using test::kSerial;
using test::Note;
using test::Notes;
using test::Robot;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr auto kShort = std::chrono::milliseconds(300);

ControlOrder ForChannel(ControlAction action, const std::string& channel) { return {action, channel, {}}; }

// The answer of one session.
ControlAnswer Ask(Robot& desk, const Robot& robot, const ControlOrder& order,
                  std::chrono::nanoseconds timeout = kPatience) {
  const std::array asked{robot.session->id()};
  return AskSessions(*desk.session, asked, order, timeout).at(0);
}

class SessionControl : public test::DomainFixture {};

TEST_F(SessionControl, ClosesAndOpensAChannel) {
  Robot robot("");
  Robot desk("", "desk");
  Notes notes;
  const Subscription own = robot->FromAny<Note>("notes", kSerial, std::ref(notes), test::Inline());
  const auto publish = robot->Advertise<Note>("notes");
  publish(Note("open"));
  const ControlAnswer closed = Ask(desk, robot, ForChannel(ControlAction::kClose, "notes"));
  EXPECT_TRUE(closed.answered);
  EXPECT_EQ(closed.refusal, "");
  EXPECT_THAT(closed.done, StartsWith("Channel \"notes\" is closed"));
  publish(Note("closed"));
  EXPECT_EQ(Ask(desk, robot, ForChannel(ControlAction::kOpen, "notes")).refusal, "");
  publish(Note("again"));
  EXPECT_THAT(notes.texts(), ElementsAre("open", "again"));
  EXPECT_TRUE(Await([&] { return robot.Said("(desk, process "); }));
  EXPECT_TRUE(robot.Said("has steered this session. Channel \"notes\" is closed"));
}

TEST_F(SessionControl, NamesTheNearestChannelIfThereIsNone) {
  Robot robot("");
  Robot desk("", "desk");
  const auto publish = robot->Advertise<Note>("notes");
  EXPECT_THAT(Ask(desk, robot, ForChannel(ControlAction::kClose, "ntoes")).done,
              HasSubstr("does not use a channel of that name. Did you mean \"notes\"?"));
}

OutboundStats OutOf(const SessionSnapshot& snapshot) {
  const auto notes = std::ranges::find(snapshot.traffic, "notes", &ChannelTraffic::channel);
  return notes == snapshot.traffic.end() ? OutboundStats() : notes->out;
}

// The transport of the channel: shared_memory or zmq.
class ForbiddenChannel : public test::DomainFixture, public testing::WithParamInterface<std::string> {
 protected:
  [[nodiscard]] std::string Rule() const { return "channels: {notes: {transports: [" + GetParam() + "]}}\n"; }
  [[nodiscard]] std::string Publishing() const { return bus_.Publishing("robot") + Rule(); }
  [[nodiscard]] std::string Subscribing() const { return bus_.Subscribing("robot") + Rule(); }

 private:
  test::Bus bus_;
};

INSTANTIATE_TEST_SUITE_P(Transports, ForbiddenChannel, testing::Values("shared_memory", "zmq"),
                         [](const auto& one) { return one.param == "zmq" ? "Zmq" : "SharedMemory"; });

TEST_P(ForbiddenChannel, LeavesNoSessionAndLosesNoAcceptedLosslessMessage) {
  Robot robot(Publishing());
  Robot listener(Subscribing(), "listener");
  Robot desk("", "desk");
  Notes notes;
  test::Door door;
  NodeOptions all;
  all.queue = Queue::KeepAll(10);
  all.executor = Executor::Dedicated();
  const Subscription heard = listener->FromAny<Note>(
      "notes", kSerial,
      [&](const Note& note) {
        door.Pass();
        notes(note);
      },
      all);
  const auto publish = robot->Advertise<Note>("notes");
  ASSERT_TRUE(robot->WaitForSubscribers("notes", 1, kPatience));
  std::size_t accepted = 0;
  while (publish(Note("before")) == PublishStatus::kOk) ++accepted;
  EXPECT_EQ(Ask(desk, robot, ForChannel(ControlAction::kForbid, "notes")).refusal, "");
  // The queue is full, but messages that stay inside need no room there.
  EXPECT_EQ(publish(Note("inside")), PublishStatus::kOk);
  door.Open();
  EXPECT_TRUE(Await([&] { return notes.size() == accepted; })) << notes.size() << " of " << accepted;
  EXPECT_TRUE(Await([&] { return !robot->WaitForSubscribers("notes", 1, std::chrono::nanoseconds(0)); }));
  EXPECT_TRUE(Await([&] { return !listener->WaitForPublishers("notes", 1, std::chrono::nanoseconds(0)); }));
  EXPECT_EQ(publish(Note("inside")), PublishStatus::kOk);
  const SessionSnapshot counted = robot->Snapshot();
  EXPECT_EQ(OutOf(counted).sent, accepted);
  EXPECT_EQ(OutOf(counted).missed, 0U);
  EXPECT_THAT(counted.not_leaving.at("notes"), HasSubstr("forbidden"));
  EXPECT_TRUE(std::ranges::any_of(ToMessage(counted).channels(),
                                  [](const auto& one) { return one.name() == "notes" && one.forbidden(); }));
  EXPECT_EQ(Ask(desk, robot, ForChannel(ControlAction::kAllow, "notes")).refusal, "");
  ASSERT_TRUE(robot->WaitForSubscribers("notes", 1, kPatience));
  EXPECT_EQ(publish(Note("after")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return notes.size() == accepted + 1; }));
  EXPECT_EQ(notes.texts().back(), "after");
  EXPECT_THAT(robot->Snapshot().not_leaving, IsEmpty());
}

TEST_P(ForbiddenChannel, LosesNoAcceptedMessageUnderTraffic) {
  Robot robot(Publishing());
  Robot listener(Subscribing(), "listener");
  Robot desk("", "desk");
  Notes notes;
  NodeOptions all;
  all.queue = Queue::KeepAll(50);
  const Subscription heard = listener->FromAny<Note>("notes", kSerial, std::ref(notes), all);
  const auto publish = robot->Advertise<Note>("notes");
  ASSERT_TRUE(robot->WaitForSubscribers("notes", 1, kPatience));
  std::atomic<bool> ends{false};
  std::atomic<std::uint64_t> published{0};
  std::thread talker([&] {
    while (!ends) published += publish(Note("x")) == PublishStatus::kOk ? 1 : 0;
  });
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(Ask(desk, robot, ForChannel(ControlAction::kForbid, "notes")).refusal, "");
    EXPECT_TRUE(Await([&] { return !robot->WaitForSubscribers("notes", 1, std::chrono::nanoseconds(0)); }));
    const std::size_t before = notes.size();
    EXPECT_EQ(Ask(desk, robot, ForChannel(ControlAction::kAllow, "notes")).refusal, "");
    EXPECT_TRUE(Await([&] { return notes.size() > before; }));
  }
  ends = true;
  talker.join();
  EXPECT_EQ(OutOf(robot->Snapshot()).missed, 0U);
  EXPECT_GT(published, notes.size());
  EXPECT_FALSE(listener.Said("did not arrive"));
}

TEST_P(ForbiddenChannel, EntersNoSession) {
  Robot robot(Publishing());
  Robot listener(Subscribing(), "listener");
  Robot desk("", "desk");
  Notes notes;
  const Subscription heard = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  const auto publish = robot->Advertise<Note>("notes");
  ASSERT_TRUE(robot->WaitForSubscribers("notes", 1, kPatience));
  EXPECT_THAT(Ask(desk, listener, ForChannel(ControlAction::kForbid, "notes")).done, EndsWith("enters this session."));
  ASSERT_TRUE(Await([&] { return !robot->WaitForSubscribers("notes", 1, std::chrono::nanoseconds(0)); }));
  // A later subscription does not enter, either.
  const Subscription second = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  publish(Note("secret"));
  EXPECT_THAT(listener->Snapshot().not_entering.at("notes"), HasSubstr("forbidden"));
  EXPECT_EQ(Ask(desk, listener, ForChannel(ControlAction::kAllow, "notes")).refusal, "");
  ASSERT_TRUE(robot->WaitForSubscribers("notes", 1, kPatience));
  publish(Note("told"));
  ASSERT_TRUE(Await([&] { return notes.size() == 2; }));
  EXPECT_THAT(notes.texts(), ElementsAre("told", "told"));
}

TEST_P(ForbiddenChannel, SaysThatALosslessSubscriptionLosesMessages) {
  Robot robot(Publishing());
  Robot listener(Subscribing(), "listener");
  Robot desk("", "desk");
  NodeOptions all;
  all.queue = Queue::KeepAll(10);
  const Subscription heard = listener->FromAny<Note>(
      "notes", kSerial, [](const Note&) {}, all);
  const auto publish = robot->Advertise<Note>("notes");
  ASSERT_TRUE(robot->WaitForSubscribers("notes", 1, kPatience));
  EXPECT_THAT(Ask(desk, listener, ForChannel(ControlAction::kForbid, "notes")).done,
              EndsWith("Messages on their way to its lossless subscriptions are lost."));
  EXPECT_TRUE(Await([&] { return listener.Said("lossless subscriptions are lost"); }));
}

TEST_F(SessionControl, ChannelIsForbiddenBeforeItIsUsed) {
  Robot robot("");
  Robot listener("", "listener");
  Robot desk("", "desk");
  const auto other = robot->Advertise<Note>("other");
  EXPECT_EQ(Ask(desk, robot, ForChannel(ControlAction::kForbid, "notes")).refusal, "");
  Notes notes;
  const Subscription heard = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  const auto publish = robot->Advertise<Note>("notes", {.latched = 1});
  publish(Note("latched"));
  EXPECT_FALSE(robot->WaitForSubscribers("notes", 1, kShort));
  EXPECT_EQ(Ask(desk, robot, ForChannel(ControlAction::kAllow, "notes")).refusal, "");
  EXPECT_TRUE(Await([&] { return notes.texts() == std::vector<std::string>{"latched"}; }));
}

TEST_F(SessionControl, AllowAddsAChannelToTheListsOfEndpoints) {
  const test::Bus bus;
  Robot robot(bus.Publishing("a", "other"));
  Robot desk("", "desk");
  const auto publish = robot->Advertise<Note>("notes");
  EXPECT_THAT(robot->Snapshot().not_leaving.at("notes"), HasSubstr("no publisher endpoint has it in its list"));
  EXPECT_THAT(robot->Snapshot().forbidden, IsEmpty());
  EXPECT_EQ(Ask(desk, robot, ForChannel(ControlAction::kAllow, "notes")).refusal, "");
  EXPECT_THAT(robot->config().publishers.at(0).channels, ElementsAre("notes", "other"));
  EXPECT_THAT(robot->Snapshot().not_leaving, IsEmpty());
}

TEST_F(SessionControl, SetsTheLevelOfTheLog) {
  Robot robot("");
  Robot desk("", "desk");
  const auto publish = robot->Advertise<Note>("notes");
  EXPECT_EQ(Ask(desk, robot, {ControlAction::kLog, {}, LogLevel::kError}).done,
            "Log lines below the level error are not written.");
  robot->log().Write(LogLevel::kWarning, "left out");
  EXPECT_EQ(Ask(desk, robot, {ControlAction::kLog, {}, LogLevel::kDebug}).refusal, "");
  robot->log().Write(LogLevel::kDebug, "written");
  EXPECT_FALSE(robot.Said("left out"));
  EXPECT_TRUE(Await([&] { return robot.Said("written"); }));
}

std::atomic<int> terminations{0};

TEST_F(SessionControl, StopSendsSigterm) {
  Robot robot("");
  Robot desk("", "desk");
  const auto publish = robot->Advertise<Note>("notes");
  struct sigaction before {};
  struct sigaction ignores {};
  ignores.sa_handler = SIG_IGN;
  ASSERT_EQ(sigaction(SIGTERM, &ignores, &before), 0);
  EXPECT_THAT(Ask(desk, robot, {ControlAction::kStop, {}, {}}).refusal, StartsWith("The process ignores SIGTERM"));
  struct sigaction counts {};
  counts.sa_handler = [](int) { ++terminations; };
  ASSERT_EQ(sigaction(SIGTERM, &counts, nullptr), 0);
  EXPECT_THAT(Ask(desk, robot, {ControlAction::kStop, {}, {}}).done, HasSubstr("gets SIGTERM"));
  EXPECT_TRUE(Await([] { return terminations == 1; }));
  EXPECT_EQ(sigaction(SIGTERM, &before, nullptr), 0);
}

TEST_F(SessionControl, RefusesWhatItDoesNotKnow) {
  Robot robot("");
  Robot desk("", "desk");
  const auto publish = robot->Advertise<Note>("notes");
  EXPECT_THAT(Ask(desk, robot, {static_cast<ControlAction>(99), {}, {}}).refusal, HasSubstr("action 99"));
  EXPECT_NE(Ask(desk, robot, ForChannel(ControlAction::kForbid, "")).refusal, "");
  EXPECT_THAT(Ask(desk, robot, ForChannel(ControlAction::kForbid, "hgros/snapshots")).refusal,
              HasSubstr("belongs to the library"));
  EXPECT_NE(Ask(desk, robot, {ControlAction::kLog, {}, static_cast<LogLevel>(7)}).refusal, "");
  EXPECT_EQ(robot->Snapshot().refused_orders, 4U);
}

TEST_F(SessionControl, DescribesTheTypesOfItsPublishersAndSubscribers) {
  Robot robot("");
  Robot desk("", "desk");
  const auto publish = robot->Advertise<foxglove::Vector3>("notes");
  const Subscription typed = robot->FromAny<foxglove::Vector3>("heard", kSerial, [](const foxglove::Vector3&) {});
  for (const char* channel : {"notes", "heard"}) {
    const ControlAnswer answer = Ask(desk, robot, ForChannel(ControlAction::kDescribe, channel));
    EXPECT_EQ(answer.refusal, "");
    EXPECT_EQ(answer.schema, SchemaOf(TypeOf<foxglove::Vector3>()));
  }
  EXPECT_FALSE(robot.Said("has steered"));
}

TEST_F(SessionControl, RefusesQuietlyToDescribeWhatHasNoSchema) {
  Robot robot("");
  Robot desk("", "desk");
  const Subscription raw = robot->FromAnyRaw("raw", kSerial, [](const RawMessage&) {});
  const auto why = [&](const std::string& channel) {
    const ControlAnswer answer = Ask(desk, robot, ForChannel(ControlAction::kDescribe, channel));
    EXPECT_EQ(answer.schema, MessageSchema());
    return answer.refusal;
  };
  const auto custom = robot->Advertise<Note>("custom");
  EXPECT_THAT(why("custom"), HasSubstr("has no protobuf schema"));
  EXPECT_THAT(why("raw"), HasSubstr("is used with any type"));
  EXPECT_THAT(why("other"), HasSubstr("is not used by this session"));
  for (const ChannelSnapshot& channel : robot->Snapshot().graph.channels) EXPECT_NE(channel.name, "other");
  MessageSchema large{"Large", Encoding::kProtobuf, 0, {}};
  {
    google::protobuf::FileDescriptorSet set;
    auto& file = *set.add_file();
    file.set_name("large.proto");
    file.set_syntax("proto3");
    auto& type = *file.add_message_type();
    type.set_name("Large");
    for (int i = 1; i <= 600; ++i) {
      auto& field = *type.add_field();
      field.set_name("f" + std::to_string(i) + std::string(500, 'x'));
      field.set_number(i);
      field.set_type(google::protobuf::FieldDescriptorProto::TYPE_BOOL);
      field.set_label(google::protobuf::FieldDescriptorProto::LABEL_OPTIONAL);
    }
    large.descriptor_set = set.SerializeAsString();
  }
  const RawPublisher publish = robot->AdvertiseRaw("large", large);
  EXPECT_THAT(why("large"), HasSubstr("is larger than 262144 bytes"));
  EXPECT_EQ(robot->Snapshot().refused_orders, 0U);
  EXPECT_FALSE(robot.Said("was refused"));
}

TEST_F(SessionControl, IsOffIfTheConfigurationSaysSo) {
  Robot robot("control: off\n");
  Robot desk("", "desk");
  const auto publish = robot->Advertise<Note>("notes");
  EXPECT_FALSE(robot->Snapshot().steerable);
  EXPECT_FALSE(Ask(desk, robot, ForChannel(ControlAction::kClose, "notes"), kShort).answered);
}

TEST_F(SessionControl, SeveralThreadsMayAsk) {
  Robot robot("");
  Robot desk("", "desk");
  const auto publish = robot->Advertise<Note>("notes");
  std::vector<std::thread> threads;
  for (const char* channel : {"a", "b", "c"}) {
    threads.emplace_back([&desk, &robot, channel] {
      EXPECT_TRUE(Ask(desk, robot, ForChannel(ControlAction::kClose, channel)).answered);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST_F(SessionControl, AnswersOfOthersComeIfOneSessionIsGone) {
  Robot first("", "first");
  Robot second("", "second");
  Robot desk("", "desk");
  const auto one = first->Advertise<Note>("notes");
  const auto two = second->Advertise<Note>("notes");
  const std::array asked{first->id(), SessionId{1}, second->id()};
  const auto answers =
      AskSessions(*desk.session, asked, ForChannel(ControlAction::kClose, "notes"), std::chrono::seconds(10));
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_TRUE(answers[0].answered);
  EXPECT_FALSE(answers[1].answered);
  EXPECT_TRUE(answers[2].answered);
  EXPECT_EQ(answers[2].session, second->id());
}

TEST_F(SessionControl, ConnectsNoSessions) {
  Robot first("", "first");
  Robot second("", "second");
  const auto one = first->Advertise<Note>("one");
  const auto two = second->Advertise<Note>("two");
  ASSERT_TRUE(Await([&] {
    return std::ranges::any_of(first->Channels(), [](const KnownChannel& channel) { return channel.name == "two"; });
  }));
  test::Linger(kShort);
  EXPECT_THAT(first->Peers(), IsEmpty());
  for (const KnownChannel& channel : first->Channels()) EXPECT_NE(channel.name, "hgros/control");
}

// Endpoints that others can connect to.
std::string Tcp(const std::string& subscribers, const std::string& security) {
  return "network: {publisher: {ip: 'tcp://127.0.0.1:*'}, subscribers: [" + subscribers + "]" +
         (security.empty() ? "" : ", security: {" + security + "}") + "}\ndiscovery: {local: false}\n";
}

TEST_F(SessionControl, RefusesTcpWithoutKeysAndSaysSoOnce) {
  Robot robot(Tcp("", ""));
  Robot desk(Tcp("{ip: '" + robot->PublisherEndpoints().at(0) + "'}", ""), "desk");
  robot->AddSubscriberEndpoint({desk->PublisherEndpoints().at(0), {}, true});
  for (int i = 0; i < 2; ++i) {
    const ControlAnswer answer = Ask(desk, robot, ForChannel(ControlAction::kClose, "notes"));
    EXPECT_TRUE(answer.answered);
    EXPECT_THAT(answer.refusal, StartsWith("Only sessions of the same user on the same host"));
  }
  EXPECT_GE(robot->Snapshot().refused_orders, 2U);
  EXPECT_EQ(robot.Count("A request to change something in this session was refused"), 1U);
  EXPECT_FALSE(robot.Said("has steered"));
}

std::string KeyText(const std::string& key) { return "'" + key + "'"; }

TEST_F(SessionControl, TakesOrdersOverTcpFromAnAllowedKeyOnly) {
  const CurveKeyPair robots = GenerateCurveKeyPair();
  const CurveKeyPair desks = GenerateCurveKeyPair();
  const CurveKeyPair others = GenerateCurveKeyPair();
  const auto keys = [](const CurveKeyPair& own, const std::string& allowed, const std::string& servers) {
    return "public_key: " + KeyText(own.public_key) + ", secret_key: " + KeyText(own.secret_key) +
           ", allowed_clients: [" + KeyText(allowed) + "], servers: {" + servers + "}";
  };
  // The endpoints are ipc, so that their names are known before.
  const test::Bus bus;
  const auto yaml = [&](const std::string& own, const std::string& other, const std::string& security) {
    return "network: {" + bus.Publisher(own) + ", subscribers: [" + bus.Subscriber(other) + "], security: {" +
           security + "}}\ndiscovery: {local: false}\n";
  };
  const auto server = [&](const std::string& name, const CurveKeyPair& key) {
    return "'" + bus.Endpoint(name) + "': " + KeyText(key.public_key);
  };
  Robot desk(yaml("desk", "robot", keys(desks, robots.public_key, server("robot", robots))), "desk");
  {
    Robot robot(yaml("robot", "desk", keys(robots, desks.public_key, server("desk", desks))));
    const ControlAnswer answer = Ask(desk, robot, ForChannel(ControlAction::kClose, "notes"));
    EXPECT_TRUE(answer.answered);
    EXPECT_EQ(answer.refusal, "");
    EXPECT_TRUE(Await([&] { return robot.Said("has steered this session"); }));
  }
  // The robot receives from the desk, but the desk may not subscribe to it.
  Robot robot(yaml("robot", "desk", keys(robots, others.public_key, server("desk", desks))));
  EXPECT_TRUE(Await([&] {
    EXPECT_FALSE(Ask(desk, robot, ForChannel(ControlAction::kClose, "notes"), std::chrono::seconds(1)).answered);
    return robot->Snapshot().refused_orders > 0;
  }));
  EXPECT_TRUE(Await([&] { return robot.Said("nor is its CURVE key in allowed_clients"); }));
  EXPECT_FALSE(robot.Said("has steered"));
}

// A session of the same user that does not keep to the protocol.
class Forger final : public test::HandMadeSession, private OutboundSource {
 public:
  Forger(const std::string& domain, SessionId peer) : HandMadeSession("forger") {
    ChannelAnnouncement use;
    use.channel = "hgros/snapshots";
    use.subscribes = true;
    Enlist(domain, use);
    OpenShm(peer);
    type_.name = "hgros.ControlRequest";
    type_.encoding = Encoding::kProtobuf;
    channel_ = shm_->Advertise("hgros/control", type_, *this);
  }
  ~Forger() { channel_.reset(); }
  [[nodiscard]] bool IsHeard() const { return channel_->subscriber_count() > 0; }
  void Send(const std::string& bytes, std::uint64_t publisher = 0) {
    PacketHead head;
    head.channel = "hgros/control";
    head.type_name = type_.name;
    head.encoding = type_.encoding;
    head.id = {publisher == 0 ? id().value : publisher, 1, ++sequence_};
    ASSERT_EQ(channel_->Reserve(), PublishStatus::kOk);
    auto owner = std::make_shared<const std::string>(bytes);
    channel_->Commit(head, {AsBytes(*owner), owner});
  }

 private:
  std::vector<OutboundMessage> Latched(SessionId /*subscriber*/) noexcept override { return {}; }
  void OnRoom() noexcept override {}
  void OnSubscribers(std::size_t /*count*/) noexcept override {}

  TypeInfo type_;
  std::uint64_t sequence_ = 0;
  std::unique_ptr<OutboundChannel> channel_;
};

TEST_F(SessionControl, CountsMalformedRequestsAndUnknownVersionsAndForgedPublishers) {
  Robot robot("");
  const auto publish = robot->Advertise<Note>("notes");
  Forger forger(std::getenv("HGROS_DOMAIN"), robot->id());
  ASSERT_TRUE(Await([&] { return forger.IsHeard(); }));
  const auto refused = [&](std::uint64_t count) {
    return Await([&] { return robot->Snapshot().refused_orders == count; });
  };
  forger.Send("\xff\xff\xff");
  EXPECT_TRUE(refused(1));
  forger.Send("");
  EXPECT_TRUE(refused(2));
  forger.Send(std::string(100'000, 'x'));
  EXPECT_TRUE(refused(3));
  ControlRequest request;
  request.set_action(ControlRequest::CLOSE);
  request.set_channel("notes");
  request.set_version(1);
  forger.Send(request.SerializeAsString());  // For nobody.
  request.add_sessions(robot->id().value);
  request.set_version(3);
  forger.Send(request.SerializeAsString());
  EXPECT_TRUE(refused(4));
  EXPECT_TRUE(Await([&] { return robot.Said("versions 1 to 2 of such requests, not version 3"); }));
  request.set_version(1);
  forger.Send(request.SerializeAsString(), 77);  // In the name of another session.
  test::Linger(kShort);
  EXPECT_FALSE(robot.Said("Session 000000000000004d"));
  EXPECT_FALSE(robot.Said("(desk"));
}

}  // namespace
}  // namespace hgros
