// Sessions change others while these run.
#include "hgros/session/session_control.hpp"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.pb.h>
#include <signal.h>

#include <array>

#include <foxglove/Vector3.pb.h>
#include <hgros/SessionControl.pb.h>

#include "hgros/session/session_parts.hpp"
#include "hgros/session/snapshot_message.hpp"
#include "hgros/transport/curve_key_pair.hpp"
#include "session/domain_fixture.hpp"
#include "session/hand_made_session.hpp"
#include "session/session_core.hpp"
#include "support/error_of.hpp"

namespace hgros::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

constexpr auto kShort = std::chrono::milliseconds(300);

ControlOrder ForChannel(ControlAction action, const std::string& channel) { return {action, channel, {}}; }

class SessionControl : public DomainFixture {
 protected:
  // The answer of one session.
  static ControlAnswer Ask(Robot& desk, const Robot& robot, const ControlOrder& order,
                           std::chrono::nanoseconds timeout = kPatience) {
    const std::array asked{robot.session->id()};
    return AskSessions(*desk.session, asked, order, timeout).at(0);
  }
};

class SteeredSession : public SessionControl {
 protected:
  [[nodiscard]] ControlAnswer Asked(const ControlOrder& order) { return Ask(desk, robot, order); }
  [[nodiscard]] ControlAnswer Asked(ControlAction action, const std::string& channel = "notes") {
    return Asked(ForChannel(action, channel));
  }

  Robot robot{""};
  Robot desk{"", "desk"};
  const Publisher<Note> publish = robot->Advertise<Note>("notes");
};

TEST_F(SteeredSession, ClosesAndOpensAChannelOrNamesTheNearest) {
  Notes notes;
  const Subscription own = robot->FromAny<Note>("notes", kSerial, std::ref(notes), Inline());
  publish(Note("open"));
  const ControlAnswer closed = Asked(ControlAction::kClose);
  EXPECT_TRUE(closed.answered);
  EXPECT_EQ(closed.refusal, "");
  EXPECT_THAT(closed.done, StartsWith("Channel \"notes\" is closed"));
  publish(Note("closed"));
  EXPECT_EQ(Asked(ControlAction::kOpen).refusal, "");
  publish(Note("again"));
  EXPECT_THAT(notes.texts(), ElementsAre("open", "again"));
  EXPECT_TRUE(Await([&] { return robot.Said("Session desk:"); }));
  EXPECT_TRUE(robot.Said("has steered this session. Channel \"notes\" is closed"));
  EXPECT_THAT(Asked(ControlAction::kClose, "ntoes").done,
              HasSubstr("does not use a channel of that name. Did you mean \"notes\"?"));
}

OutboundStats OutOf(const SessionSnapshot& snapshot) {
  const auto notes = std::ranges::find(snapshot.traffic, "notes", &ChannelTraffic::channel);
  return notes == snapshot.traffic.end() ? OutboundStats() : notes->out;
}

// The transport of the channel: shared_memory or zmq.
class ForbiddenChannel : public SessionControl, public testing::WithParamInterface<std::string> {
 protected:
  [[nodiscard]] bool Joins() { return robot->WaitForSubscribers("notes", 1, kPatience); }
  [[nodiscard]] bool Leaves() {
    return Await([&] { return !robot->WaitForSubscribers("notes", 1, std::chrono::nanoseconds(0)); });
  }
  void Allow(const Robot& side) { EXPECT_EQ(Ask(desk, side, ForChannel(ControlAction::kAllow, "notes")).refusal, ""); }
  ControlAnswer Forbid(const Robot& side) {
    ControlAnswer answer = Ask(desk, side, ForChannel(ControlAction::kForbid, "notes"));
    EXPECT_EQ(answer.refusal, "");
    return answer;
  }

  Notes notes;
  Bus bus;
  const std::string rule = "channels: {notes: {transports: [" + GetParam() + "]}}\n";
  Robot robot{bus.Publishing("robot") + rule};
  Robot listener{bus.Subscribing("robot") + rule, "listener"};
  Robot desk{"", "desk"};
  const Publisher<Note> publish = robot->Advertise<Note>("notes");
};

INSTANTIATE_TEST_SUITE_P(Transports, ForbiddenChannel, testing::Values("shared_memory", "zmq"),
                         [](const auto& one) { return one.param == "zmq" ? "Zmq" : "SharedMemory"; });

TEST_P(ForbiddenChannel, LeavesNoSessionAndLosesNoAcceptedLosslessMessage) {
  Door door;
  const auto take = [&](const Note& note) {
    door.Pass();
    notes(note);
  };
  const Subscription heard =
      listener->FromAny<Note>("notes", kSerial, take, {{}, Queue::KeepAll(10), Executor::Dedicated()});
  ASSERT_TRUE(Joins());
  std::size_t accepted = 0;
  while (publish(Note("before")) == PublishStatus::kOk) ++accepted;
  Forbid(robot);
  // The queue is full, but messages that stay inside need no room there.
  EXPECT_EQ(publish(Note("inside")), PublishStatus::kOk);
  door.Open();
  EXPECT_TRUE(Await([&] { return notes.size() == accepted; })) << notes.size() << " of " << accepted;
  EXPECT_TRUE(Leaves());
  EXPECT_TRUE(Await([&] { return !listener->WaitForPublishers("notes", 1, std::chrono::nanoseconds(0)); }));
  EXPECT_EQ(publish(Note("inside")), PublishStatus::kOk);
  const SessionSnapshot counted = robot->Snapshot();
  EXPECT_EQ(OutOf(counted).sent, accepted);
  EXPECT_EQ(OutOf(counted).missed, 0U);
  EXPECT_THAT(counted.not_leaving.at("notes"), HasSubstr("forbidden"));
  EXPECT_TRUE(std::ranges::any_of(ToMessage(counted).channels(),
                                  [](const auto& one) { return one.name() == "notes" && one.forbidden(); }));
  Allow(robot);
  ASSERT_TRUE(Joins());
  EXPECT_EQ(publish(Note("after")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return notes.size() == accepted + 1; }));
  EXPECT_EQ(notes.texts().back(), "after");
  EXPECT_THAT(robot->Snapshot().not_leaving, IsEmpty());
}

TEST_P(ForbiddenChannel, LosesNoAcceptedMessageUnderTraffic) {
  const Subscription heard = listener->FromAny<Note>("notes", kSerial, std::ref(notes), {.queue = Queue::KeepAll(50)});
  ASSERT_TRUE(Joins());
  std::atomic<bool> ends{false};
  std::atomic<std::uint64_t> published{0};
  std::thread talker([&] {
    while (!ends) published += publish(Note("x")) == PublishStatus::kOk ? 1 : 0;
  });
  for (int i = 0; i < 5; ++i) {
    Forbid(robot);
    EXPECT_TRUE(Leaves());
    const std::size_t before = notes.size();
    Allow(robot);
    EXPECT_TRUE(Await([&] { return notes.size() > before; }));
  }
  ends = true;
  talker.join();
  EXPECT_EQ(OutOf(robot->Snapshot()).missed, 0U);
  EXPECT_GT(published, notes.size());
  EXPECT_FALSE(listener.Said("did not arrive"));
}

TEST_P(ForbiddenChannel, EntersNoSession) {
  const Subscription heard = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  ASSERT_TRUE(Joins());
  EXPECT_THAT(Forbid(listener).done, EndsWith("enters this session."));
  ASSERT_TRUE(Leaves());
  // A later subscription does not enter, either.
  const Subscription second = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  publish(Note("secret"));
  EXPECT_THAT(listener->Snapshot().not_entering.at("notes"), HasSubstr("forbidden"));
  Allow(listener);
  ASSERT_TRUE(Joins());
  publish(Note("told"));
  ASSERT_TRUE(Await([&] { return notes.size() == 2; }));
  EXPECT_THAT(notes.texts(), ElementsAre("told", "told"));
}

TEST_P(ForbiddenChannel, SaysThatALosslessSubscriptionLosesMessages) {
  const Subscription heard =
      listener->FromAny<Note>("notes", kSerial, [](const Note&) {}, {.queue = Queue::KeepAll(10)});
  ASSERT_TRUE(Joins());
  EXPECT_THAT(Forbid(listener).done, EndsWith("Messages on their way to its lossless subscriptions are lost."));
  EXPECT_TRUE(Await([&] { return listener.Said("lossless subscriptions are lost"); }));
}

TEST_F(SteeredSession, ChannelIsForbiddenBeforeItIsUsed) {
  Robot listener("", "listener");
  EXPECT_EQ(Asked(ControlAction::kForbid, "unused").refusal, "");
  Notes notes;
  const Subscription heard = listener->FromAny<Note>("unused", kSerial, std::ref(notes));
  const auto latched = robot->Advertise<Note>("unused", {.latched = 1});
  latched(Note("latched"));
  EXPECT_FALSE(robot->WaitForSubscribers("unused", 1, kShort));
  EXPECT_EQ(Asked(ControlAction::kAllow, "unused").refusal, "");
  EXPECT_TRUE(Await([&] { return notes.texts() == std::vector<std::string>{"latched"}; }));
}

TEST_F(SessionControl, AllowAddsAChannelToTheListsOfEndpoints) {
  const Bus bus;
  Robot robot(bus.Publishing("a", "other"));
  Robot desk("", "desk");
  const auto publish = robot->Advertise<Note>("notes");
  EXPECT_THAT(robot->Snapshot().not_leaving.at("notes"), HasSubstr("no publisher endpoint has it in its list"));
  EXPECT_THAT(robot->Snapshot().forbidden, IsEmpty());
  EXPECT_EQ(Ask(desk, robot, ForChannel(ControlAction::kAllow, "notes")).refusal, "");
  EXPECT_THAT(robot->config().publishers.at(0).channels, ElementsAre("notes", "other"));
  EXPECT_THAT(robot->Snapshot().not_leaving, IsEmpty());
}

TEST_F(SteeredSession, SetsTheLevelOfTheLogAndSaysWhoHasChangedWhatAtEveryLevel) {
  EXPECT_EQ(Asked({ControlAction::kLog, {}, LogLevel::kError}).done,
            "Log lines below the level error are not written.");
  EXPECT_TRUE(robot.Said("has steered this session. Log lines below the level error"));
  EXPECT_TRUE(Asked(ControlAction::kClose).answered);
  EXPECT_TRUE(robot.Said("has steered this session. Channel \"notes\" is closed"));
  robot->log().Write(LogLevel::kWarning, "left out");
  EXPECT_EQ(Asked({ControlAction::kLog, {}, LogLevel::kDebug}).refusal, "");
  robot->log().Write(LogLevel::kDebug, "written");
  EXPECT_FALSE(robot.Said("left out"));
  EXPECT_TRUE(Await([&] { return robot.Said("written"); }));
}

// Counts this signal instead of being ended by it.
class CountedSigterms {
 public:
  CountedSigterms() {
    count = 0;
    Handle([](int) { ++count; }, &before_);
  }
  CountedSigterms(const CountedSigterms&) = delete;
  CountedSigterms& operator=(const CountedSigterms&) = delete;
  ~CountedSigterms() { EXPECT_EQ(sigaction(SIGTERM, &before_, nullptr), 0); }
  static void Handle(void (*handler)(int), struct sigaction* before = nullptr) {
    struct sigaction handles {};
    handles.sa_handler = handler;
    ASSERT_EQ(sigaction(SIGTERM, &handles, before), 0);
  }
  inline static std::atomic<int> count{0};

 private:
  struct sigaction before_ {};
};

TEST_F(SteeredSession, StopSendsSigtermUnlessItIsIgnored) {
  const CountedSigterms sigterms;
  EXPECT_THAT(Asked(ControlAction::kStop, "").done, HasSubstr("gets SIGTERM"));
  EXPECT_TRUE(Await([] { return CountedSigterms::count == 1; }));
  CountedSigterms::Handle(SIG_IGN);
  EXPECT_THAT(Asked(ControlAction::kStop, "").refusal, StartsWith("The process ignores SIGTERM"));
  EXPECT_EQ(CountedSigterms::count, 1);
}

TEST_F(SteeredSession, StopsAProgramWhoseForbiddenCallbackHangs) {
  Robot listener("", "listener");
  Door door;
  std::atomic<bool> hangs{false};
  const auto hang = [&](const Note&) {
    hangs = true;
    door.Pass();
  };
  const Subscription heard = listener->FromAny<Note>("notes", kSerial, hang, Inline());
  ASSERT_TRUE(robot->WaitForSubscribers("notes", 1, kPatience));
  publish(Note("endless"));
  ASSERT_TRUE(Await([&] { return hangs.load(); }));
  EXPECT_THAT(Ask(desk, listener, ForChannel(ControlAction::kForbid, "notes")).done, HasSubstr("callback"));
  EXPECT_TRUE(Ask(desk, listener, {ControlAction::kLog, {}, LogLevel::kInfo}).answered);
  const CountedSigterms sigterms;
  EXPECT_THAT(Ask(desk, listener, {ControlAction::kStop, {}, {}}).done, HasSubstr("gets SIGTERM"));
  EXPECT_TRUE(Await([] { return CountedSigterms::count == 1; }, kPatience / 2));
  door.Open();
  EXPECT_TRUE(Await([&] { return !robot->WaitForSubscribers("notes", 1, std::chrono::nanoseconds(0)); }));
}

TEST_F(SteeredSession, ProgramCannotUseTheChannelOfRequests) {
  const auto says_what_to_use = AllOf(HasSubstr("hgros control"), HasSubstr("control: off"));
  const auto ignore = [](const Note&) {};
  for (int i = 0; i < 2; ++i) {
    EXPECT_THAT(ErrorOf([&] { return robot->FromAny<Note>("hgros/control", kSerial, ignore); }), says_what_to_use);
  }
  EXPECT_THAT(ErrorOf([&] { return robot->AwaitSchema("hgros/control", std::chrono::nanoseconds(0)); }),
              says_what_to_use);
  for (const char* channel : {"hgros/control", "hgros/control/replies"}) {
    EXPECT_THAT(ErrorOf([&] { return robot->Advertise<Note>(channel); }), HasSubstr("belongs to the library"));
  }
  for (const ChannelSnapshot& channel : robot->Snapshot().graph.channels) {
    EXPECT_THAT(channel.name, Not(StartsWith("hgros/control")));
  }
  EXPECT_TRUE(Ask(desk, robot, ForChannel(ControlAction::kClose, "notes")).answered);
  EXPECT_TRUE(Ask(robot, desk, ForChannel(ControlAction::kClose, "notes")).answered);
}

TEST_F(SteeredSession, SubscriptionThatFailsLeavesNothingBehind) {
  ServicePlace& place = SessionParts(*robot.session).core().place();
  for (int i = 0; i < 2; ++i) {  // The desk subscribes to it already.
    EXPECT_THROW((void)place.Listen(
                     "hgros/control", TypeOf<ControlRequest>(), [](const AnyMessage&, const MessageInfo&) {}, 1),
                 Error);
  }
  const auto second = robot->Advertise<Note>("second");
  const auto lists = [&](const std::string& name) {
    const auto channels = desk->Channels();
    return std::ranges::find(channels, name, &KnownChannel::name) != channels.end();
  };
  EXPECT_TRUE(Await([&] { return lists("second"); }));
  EXPECT_FALSE(lists("hgros/control"));
}

TEST_F(SteeredSession, RefusesWhatItDoesNotKnow) {
  EXPECT_THAT(Asked(static_cast<ControlAction>(99), "").refusal, HasSubstr("action 99"));
  EXPECT_NE(Asked(ControlAction::kForbid, "").refusal, "");
  EXPECT_THAT(Asked(ControlAction::kForbid, "hgros/snapshots").refusal, HasSubstr("belongs to the library"));
  EXPECT_NE(Asked({ControlAction::kLog, {}, static_cast<LogLevel>(7)}).refusal, "");
  EXPECT_EQ(robot->Snapshot().refused_orders, 4U);
}

TEST_F(SteeredSession, DescribesTheTypesOfItsPublishersAndSubscribersAndRefusesQuietlyWhatHasNoSchema) {
  const auto vectors = robot->Advertise<foxglove::Vector3>("vectors");
  const Subscription typed = robot->FromAny<foxglove::Vector3>("heard", kSerial, [](const foxglove::Vector3&) {});
  for (const char* channel : {"vectors", "heard"}) {
    const ControlAnswer answer = Asked(ControlAction::kDescribe, channel);
    EXPECT_EQ(answer.refusal, "");
    EXPECT_EQ(answer.schema, SchemaOf(TypeOf<foxglove::Vector3>()));
  }
  EXPECT_FALSE(robot.Said("has steered"));
  const Subscription raw = robot->FromAnyRaw("raw", kSerial, [](const RawMessage&) {});
  const auto why = [&](const std::string& channel) {
    const ControlAnswer answer = Asked(ControlAction::kDescribe, channel);
    EXPECT_EQ(answer.schema, MessageSchema());
    return answer.refusal;
  };
  EXPECT_THAT(why("notes"), HasSubstr("has no protobuf schema"));
  EXPECT_THAT(why("raw"), HasSubstr("is used with any type"));
  EXPECT_THAT(why("other"), HasSubstr("is not used by this session"));
  for (const ChannelSnapshot& channel : robot->Snapshot().graph.channels) EXPECT_NE(channel.name, "other");
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
  const RawPublisher large = robot->AdvertiseRaw("large", {"Large", Encoding::kProtobuf, 0, set.SerializeAsString()});
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

TEST_F(SteeredSession, SeveralThreadsMayAsk) {
  std::vector<std::jthread> threads;
  for (const char* channel : {"a", "b", "c"}) {
    threads.emplace_back([this, channel] { EXPECT_TRUE(Asked(ControlAction::kClose, channel).answered); });
  }
}

TEST_F(SteeredSession, AnswersOfOthersComeIfOneSessionIsGone) {
  Robot second("", "second");
  const auto two = second->Advertise<Note>("notes");
  const std::array asked{robot->id(), SessionId{1}, second->id()};
  std::chrono::milliseconds time = kShort;
  EXPECT_TRUE(Await([&] {
    const auto answers = AskSessions(*desk.session, asked, ForChannel(ControlAction::kClose, "notes"), time *= 2);
    if (answers.size() != 3U) return false;
    EXPECT_FALSE(answers[1].answered);
    EXPECT_EQ(answers[2].session, second->id());
    return answers[0].answered && answers[2].answered;
  }));
}

TEST_F(SessionControl, ConnectsNoSessions) {
  Robot first("", "first");
  Robot second("", "second");
  const auto one = first->Advertise<Note>("one");
  const auto two = second->Advertise<Note>("two");
  ASSERT_TRUE(Await([&] {
    return std::ranges::any_of(first->Channels(), [](const KnownChannel& channel) { return channel.name == "two"; });
  }));
  Linger(kShort);
  EXPECT_THAT(first->Peers(), IsEmpty());
  for (const KnownChannel& channel : first->Channels()) EXPECT_NE(channel.name, "hgros/control");
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
  const Bus bus;
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
class Forger final : public HandMadeSession, private OutboundSource {
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
  Linger(kShort);
  EXPECT_FALSE(robot.Said("Session 000000000000004d"));
  EXPECT_FALSE(robot.Said("Session desk:"));
}

}  // namespace
}  // namespace hgros::test
