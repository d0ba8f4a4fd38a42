// Channels whose configuration names the transports that they may use.
#include "session/domain_fixture.hpp"

namespace hgros::test::transport_rules_test {
namespace {

constexpr const char* kNoMemory = "There is no shared memory for a message";

std::string Rule(const std::string& transports) { return "channels: {scan: {transports: " + transports + "}}\n"; }

class RulesOfTransports : public DomainFixture {
 protected:
  // Publishes `count` messages and waits until they have arrived. None may arrive twice.
  static void Pass(Robot& talker, const std::string& channel, Notes& heard, std::size_t count) {
    const std::size_t before = heard.size();
    for (std::size_t i = 0; i < count; ++i) talker->ToAny(channel, Note(std::to_string(i)));
    EXPECT_TRUE(Await([&] { return heard.size() >= before + count; })) << channel << ": " << heard.size();
    Linger(std::chrono::milliseconds(200));  // Time for repeats to arrive.
    EXPECT_EQ(heard.size(), before + count) << channel;
  }

  Notes notes;
};

TEST_F(RulesOfTransports, ChannelUsesZeroMqWhicheverSideExcludesSharedMemory) {
  using Case = std::pair<std::string, std::string>;
  for (const auto& [here, there] : {Case{"zmq", ""}, Case{"", "[zmq]"}, Case{"zmq", "zmq"}}) {
    SCOPED_TRACE("\"" + here + "\", \"" + there + "\"");
    const Bus bus;
    // With a limit of 0 each use of shared memory is logged. That shows which transport a message takes.
    Robot talker(bus.Publishing("a") + (here.empty() ? "" : Rule(here)) + "shared_memory: {limit_bytes: 0}\n");
    Robot listener(bus.Subscribing("a") + (there.empty() ? "" : Rule(there)));
    Notes scans, poses;
    const NodeOptions all{.queue = Queue::KeepAll(200)};
    const auto first = listener->FromAny<Note>("scan", kSerial, std::ref(scans), all);
    const auto second = listener->FromAny<Note>("pose", kSerial, std::ref(poses), all);
    const auto publish_scans = talker->Advertise<Note>("scan");
    const auto publish_poses = talker->Advertise<Note>("pose");
    ASSERT_TRUE(talker->WaitForSubscribers("scan", 1, kPatience));
    ASSERT_TRUE(talker->WaitForSubscribers("pose", 1, kPatience));
    Pass(talker, "scan", scans, 50);
    EXPECT_FALSE(talker.Said(kNoMemory)) << "the channel went through shared memory";
    // On a busy machine ZeroMQ may be used for the other channel before.
    ASSERT_TRUE(Await([&] {
      const auto peers = listener->Peers();
      return peers.size() == 1 && peers[0].transport == "shared memory";
    }));
    Pass(talker, "pose", poses, 50);
    EXPECT_TRUE(talker.Said(kNoMemory)) << "the other channel did not go through shared memory";
    EXPECT_EQ(talker->WaitForSubscribers("scan", 2, std::chrono::milliseconds(1)), false);
    ASSERT_EQ(listener->Peers().size(), 1U);
    EXPECT_EQ(listener->Peers()[0].transport, "shared memory");
  }
}

TEST_F(RulesOfTransports, ChannelForSharedMemoryUsesNoOtherTransport) {
  const Bus bus;
  Robot talker(bus.Publishing("a") + Rule("shared_memory"));
  Robot near("");
  Robot far(bus.Subscribing("a") + "discovery: {local: false}");
  Notes near_scans, far_scans, far_poses;
  const auto first = near->FromAny<Note>("scan", kSerial, std::ref(near_scans));
  const auto second = far->FromAny<Note>("scan", kSerial, std::ref(far_scans));
  const auto third = far->FromAny<Note>("pose", kSerial, std::ref(far_poses));
  const auto publish_scans = talker->Advertise<Note>("scan");
  const auto publish_poses = talker->Advertise<Note>("pose");
  ASSERT_TRUE(talker->WaitForSubscribers("scan", 1, kPatience));
  ASSERT_TRUE(talker->WaitForSubscribers("pose", 1, kPatience));
  Pass(talker, "scan", near_scans, 10);
  Pass(talker, "pose", far_poses, 10);
  EXPECT_EQ(far_scans.size(), 0U);
}

TEST_F(RulesOfTransports, ChannelThatPassesNowhereIsLogged) {
  const Bus bus;
  Robot talker(bus.Publishing("a") + Rule("zmq"));
  Robot listener(bus.Subscribing("a") + Rule("shared_memory"));
  Enter("test-" + SessionId::Random().ToString());
  Robot unreached(Rule("zmq")), other("");
  Notes others;
  const auto subscription = listener->FromAny<Note>("scan", kSerial, std::ref(notes));
  const auto second = other->FromAny<Note>("scan", kSerial, std::ref(others));
  (void)talker->Advertise<Note>("scan");
  (void)unreached->Advertise<Note>("scan");
  const auto said = [](Robot& robot) { return robot.Count("Nothing passes on channel \"scan\""); };
  EXPECT_TRUE(Await([&] { return said(talker) == 1 && said(listener) == 1; }));
  EXPECT_TRUE(talker.Said("the `transports` here and there have nothing in common"));
  EXPECT_FALSE(talker->WaitForSubscribers("scan", 1, std::chrono::milliseconds(1)));
  EXPECT_TRUE(Await([&] { return other.Said("allow ZeroMQ only, which does not reach that session"); }));
  Robot hermit("discovery: {local: false}\n" + Rule("shared_memory"));
  hermit->AddPublisherEndpoint({bus.Endpoint("b"), {}, true});
  (void)hermit->Advertise<Note>("scan");
  EXPECT_TRUE(hermit.Said("Channel \"scan\" stays in this process"));
}

TEST_F(RulesOfTransports, WhiteListAppliesOnlyToItsEndpoint) {
  const Bus bus;
  Robot talker(bus.Publishing("a", "pose"));
  Robot near("");
  const auto subscription = near->FromAny<Note>("scan", kSerial, std::ref(notes));
  const auto publish = talker->Advertise<Note>("scan");
  ASSERT_TRUE(talker->WaitForSubscribers("scan", 1, kPatience));
  Pass(talker, "scan", notes, 5);
  EXPECT_TRUE(talker.Said("Channel \"scan\" is published, but does not leave this host"));
}

}  // namespace
}  // namespace hgros::test::transport_rules_test
