// Sessions change others from which they receive, and which receive nothing from them.
#include <gmock/gmock.h>
#include <signal.h>

#include <array>

#include <foxglove/Vector3.pb.h>
#include <hgros/SessionControl.pb.h>

#include "hgros/session/session_control.hpp"
#include "hgros/transport/curve_key_pair.hpp"
#include "session/domain_fixture.hpp"
#include "transport/agreement.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq_places.hpp"

namespace hgros::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr auto kInVain = std::chrono::milliseconds(500);

std::string Publishing(const std::string& security) {
  return "network: {publisher: {ip: 'tcp://127.0.0.1:*'}" + security + "}\ndiscovery: {local: false}\n";
}

std::string Subscribing(const std::string& endpoint, const std::string& security) {
  return "network: {subscribers: [{ip: '" + endpoint + "'}]" + security + "}\ndiscovery: {local: false}\n";
}

std::string Keys(const CurveKeyPair& own, const std::string& more) {
  return ", security: {public_key: '" + own.public_key + "', secret_key: '" + own.secret_key + "', " + more + "}";
}

ControlAnswer Order(const Robot& desk, SessionId robot, const ControlOrder& order,
                    std::chrono::nanoseconds timeout = kPatience) {
  const std::array asked{robot};
  return AskSessions(*desk.session, asked, order, timeout).at(0);
}

class OneWayControl : public DomainFixture {
 protected:
  // A robot that lets this key subscribe.
  [[nodiscard]] std::string RobotLetsIn(const CurveKeyPair& key, const std::string& more = {}) const {
    return Publishing(Keys(robots_, "allowed_clients: ['" + key.public_key + "']")) + more;
  }
  [[nodiscard]] std::string DeskOf(const Robot& robot) const {
    const std::string endpoint = robot->PublisherEndpoints().at(0);
    return Subscribing(endpoint, Keys(desks_, "servers: {'" + endpoint + "': '" + robots_.public_key + "'}"));
  }

  const CurveKeyPair robots_ = GenerateCurveKeyPair();
  const CurveKeyPair desks_ = GenerateCurveKeyPair();
};

std::atomic<int> stops{0};

TEST_F(OneWayControl, CarriesOutEachActionForAnAllowedKey) {
  Robot robot(RobotLetsIn(desks_));
  Robot desk(DeskOf(robot), "desk");
  Notes own;
  const Subscription notes = robot->FromAny<Note>("notes", kSerial, std::ref(own), Inline());
  const Subscription heard = robot->FromAny<foxglove::Vector3>("heard", kSerial, [](const foxglove::Vector3&) {});
  const auto publish = robot->Advertise<Note>("notes");
  const auto done = [&](const ControlOrder& order) {
    const ControlAnswer answer = Order(desk, robot->id(), order);
    EXPECT_TRUE(answer.answered);
    EXPECT_EQ(answer.refusal, "");
    return answer.done;
  };
  EXPECT_THAT(done({ControlAction::kClose, "notes", {}}), HasSubstr("is closed"));
  publish(Note("closed"));
  EXPECT_THAT(done({ControlAction::kOpen, "notes", {}}), HasSubstr("is open"));
  publish(Note("open"));
  EXPECT_THAT(own.texts(), testing::ElementsAre("open"));
  EXPECT_THAT(done({ControlAction::kForbid, "notes", {}}), HasSubstr("is forbidden"));
  EXPECT_TRUE(robot->Snapshot().forbidden.contains("notes"));
  EXPECT_THAT(done({ControlAction::kAllow, "notes", {}}), HasSubstr("is allowed"));
  EXPECT_FALSE(robot->Snapshot().forbidden.contains("notes"));
  EXPECT_THAT(done({ControlAction::kLog, {}, LogLevel::kDebug}), HasSubstr("below the level debug"));
  const ControlAnswer described = Order(desk, robot->id(), {ControlAction::kDescribe, "heard", {}});
  EXPECT_EQ(described.schema, SchemaOf(TypeOf<foxglove::Vector3>()));
  struct sigaction before {};
  struct sigaction counts {};
  counts.sa_handler = [](int) { ++stops; };
  ASSERT_EQ(sigaction(SIGTERM, &counts, &before), 0);
  EXPECT_THAT(done({ControlAction::kStop, {}, {}}), HasSubstr("gets SIGTERM"));
  EXPECT_TRUE(Await([] { return stops == 1; }));
  EXPECT_EQ(sigaction(SIGTERM, &before, nullptr), 0);
  EXPECT_TRUE(Await([&] { return robot.Said("Session desk:"); }));
  EXPECT_EQ(robot->Snapshot().refused_orders, 0U);
}

TEST_F(OneWayControl, RefusesWithoutKeysAndSaysSoOnceAlsoIfTheRobotReceivesFromTheDesk) {
  for (const bool receives : {false, true}) {
    SCOPED_TRACE(receives);
    Robot robot(Publishing(""));
    Robot desk(Subscribing(robot->PublisherEndpoints().at(0), receives ? ", publisher: {ip: 'tcp://127.0.0.1:*'}" : ""),
               "desk");
    if (receives) robot->AddSubscriberEndpoint({desk->PublisherEndpoints().at(0), {}, true});
    for (int i = 0; i < 2; ++i) {
      const ControlAnswer answer = Order(desk, robot->id(), {ControlAction::kStop, {}, {}});
      EXPECT_TRUE(answer.answered);
      EXPECT_THAT(answer.refusal, StartsWith("Only sessions of the same user on the same host"));
    }
    EXPECT_GE(robot->Snapshot().refused_orders, 2U);
    EXPECT_EQ(robot.Count("A request to change something in this session was refused"), 1U);
    EXPECT_FALSE(robot.Said("has steered"));
  }
}

TEST_F(OneWayControl, HearsNothingFromAKeyThatIsNotAllowed) {
  Robot robot(RobotLetsIn(GenerateCurveKeyPair()));
  Robot desk(DeskOf(robot), "desk");
  EXPECT_FALSE(Order(desk, robot->id(), {ControlAction::kStop, {}, {}}, kInVain).answered);
  EXPECT_TRUE(Await([&] { return robot.Said("its key is not among the allowed ones"); }));
  EXPECT_EQ(robot->Snapshot().refused_orders, 0U);
}

TEST_F(OneWayControl, IsNotPossibleIfItIsOffOrNoRepliesLeave) {
  const std::string lists_others = "network: {publisher: {ip: 'tcp://127.0.0.1:*', channels: [notes]}" +
                                   Keys(robots_, "allowed_clients: ['" + desks_.public_key + "']") +
                                   "}\ndiscovery: {local: false}\n";
  for (const std::string& yaml : {RobotLetsIn(desks_, "control: off\n"), lists_others}) {
    SCOPED_TRACE(yaml);
    Robot robot(yaml);
    Robot desk(DeskOf(robot), "desk");
    ASSERT_TRUE(Await([&] { return !desk->Peers().empty(); }));
    EXPECT_FALSE(Order(desk, robot->id(), {ControlAction::kClose, "notes", {}}, kInVain).answered);
    EXPECT_FALSE(robot.Said("has steered"));
  }
}

// A program that speaks for a session, and sends orders of its own.
class Stranger {
 public:
  explicit Stranger(const std::string& endpoint) {
    zmq_connect(socket_.get(), endpoint.c_str());
    socket_.Send({'\1' + zmq::ControlTopic(id)});
    auto hello = zmq::ControlFrom(id);
    WriteFacts(OwnFacts(id, "stranger"), *hello.mutable_hello()->mutable_facts());
    hello.mutable_hello()->set_handshake(Welcome());
    hello.mutable_hello()->set_proof(1);
    socket_.Send({zmq::UpstreamFrame(hello)});
  }
  void Send(const std::string& request, SessionId as) const {
    auto message = zmq::ControlFrom(as);
    message.mutable_order()->set_request(request);
    socket_.Send({zmq::UpstreamFrame(message)});
  }
  // The number of the handshake in the next Welcome.
  [[nodiscard]] std::uint64_t Welcome() const {
    for (;;) {
      const auto frames = socket_.Receive();
      if (frames.empty()) return 0;
      const auto control = frames.size() == 2 ? zmq::ParseControl(AsBytes(frames[1])) : std::nullopt;
      if (control && control->has_welcome()) return control->welcome().handshake();
    }
  }
  const SessionId id = SessionId::Random();

 private:
  RawSocket socket_{ZMQ_XSUB};
};

TEST_F(OneWayControl, CountsOrdersWithoutMeaningAndFloodsOfThem) {
  Robot robot(Publishing(""));
  const Stranger stranger(robot->PublisherEndpoints().at(0));
  stranger.Send("\xff\xff\xff", stranger.id);
  stranger.Send("", stranger.id);
  EXPECT_TRUE(Await([&] { return robot->Snapshot().refused_orders == 2; }));
  ControlRequest request;
  request.set_action(ControlRequest::STOP);
  request.set_version(1);
  request.add_sessions(robot->id().value);
  for (std::uint64_t i = 1; i <= 500; ++i) {
    request.set_number(i);
    stranger.Send(request.SerializeAsString(), stranger.id);
  }
  EXPECT_TRUE(Await([&] { return robot->Snapshot().refused_orders == 502; }));
  EXPECT_LE(robot.Count("A request to change something in this session was refused"), 10U);
  // A longer message than sessions send ends the connection. The next one is greeted.
  stranger.Send(std::string(100'000, 'x'), stranger.id);
  EXPECT_NE(stranger.Welcome(), 0U);
  EXPECT_EQ(robot->Snapshot().refused_orders, 502U);
}

TEST_F(OneWayControl, IsNotSpokenForByAnotherConnection) {
  Robot robot(Publishing(""));
  Robot desk(Subscribing(robot->PublisherEndpoints().at(0), ""), "desk");
  ASSERT_TRUE(Await([&] { return !robot->Peers().empty(); }));
  const Stranger stranger(robot->PublisherEndpoints().at(0));
  stranger.Send("forged", desk->id());
  stranger.Send("own", stranger.id);
  EXPECT_TRUE(Await([&] { return robot->Snapshot().refused_orders > 0; }));
  EXPECT_EQ(robot->Snapshot().refused_orders, 1U);
  EXPECT_TRUE(robot.Said("which has another connection"));
}

TEST(OneWayOrder, IsWrittenAsInTheExampleOfTheWireProtocol) {
  ControlRequest request;
  request.set_version(1);
  request.add_sessions(0xab);
  request.set_number(1);
  request.set_action(ControlRequest::CLOSE);
  request.set_channel("scan");
  auto message = zmq::ControlFrom(SessionId{0xcd});
  message.mutable_order()->set_request(request.SerializeAsString());
  std::string digits;
  for (const char byte : zmq::UpstreamFrame(message)) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    digits += {kDigits[static_cast<unsigned char>(byte) >> 4U], kDigits[static_cast<unsigned char>(byte) & 15U]};
  }
  EXPECT_EQ(digits, "0209cd000000000000006a180a1608011208ab00000000000000180120012a047363616e");
}

// A robot that is made by hand, of any minor version.
class RobotOfMinor : public testing::TestWithParam<std::uint32_t> {};

TEST_P(RobotOfMinor, GetsOrdersFromItsThirdOnOnly) {
  const ScratchFolder folder;
  RawSocket robot(ZMQ_XPUB);
  ASSERT_EQ(zmq_bind(robot.get(), folder.Ipc().c_str()), 0);
  Robot desk(Subscribing(folder.Ipc(), ""), "desk");
  const SessionId id = SessionId::Random();
  auto welcome = zmq::ControlFrom(id);
  WriteFacts(OwnFacts(id, "robot"), *welcome.mutable_welcome()->mutable_facts());
  welcome.mutable_welcome()->mutable_facts()->set_wire_minor(GetParam());
  welcome.mutable_welcome()->set_handshake(1);
  const auto subscribed = robot.Receive();
  ASSERT_FALSE(subscribed.empty());
  robot.Send({subscribed[0].substr(1), welcome.SerializeAsString()});
  ASSERT_TRUE(Await([&] { return !desk->Peers().empty(); }));
  const ControlAnswer answer = Order(desk, id, {ControlAction::kClose, "notes", {}}, kInVain);
  EXPECT_FALSE(answer.answered);
  const bool knows = GetParam() >= 3;
  EXPECT_EQ(answer.refusal.find("takes no requests over a connection") == std::string::npos, knows) << answer.refusal;
  std::size_t orders = 0;
  const auto end = std::chrono::steady_clock::now() + kPatience;
  const auto may_come = [&] { return knows && orders == 0 && std::chrono::steady_clock::now() < end; };
  for (auto frames = robot.Receive(200); !frames.empty() || may_come(); frames = robot.Receive(200)) {
    if (frames.empty()) continue;
    const auto control = frames[0][0] == '\2' ? zmq::ParseControl(AsBytes(frames[0]).subspan(1)) : std::nullopt;
    if (!control || !control->has_order()) continue;
    ControlRequest request;
    ASSERT_TRUE(request.ParseFromString(control->order().request()));
    EXPECT_THAT(request.sessions(), testing::ElementsAre(id.value));
    EXPECT_EQ(request.channel(), "notes");
    ++orders;
  }
  EXPECT_EQ(orders > 0, knows);
}

INSTANTIATE_TEST_SUITE_P(OneWayControl, RobotOfMinor, testing::Values(0, 2, 3));

}  // namespace
}  // namespace hgros::test
