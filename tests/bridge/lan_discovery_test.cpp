// Sessions of two hosts find each other without endpoints. The hosts are network namespaces with a virtual cable.
#include <optional>

#include "session/domain_fixture.hpp"
#include "support/cable.hpp"

namespace hgros::test::lan_discovery_test {
namespace {

constexpr const char* kLan = "discovery: {local: false, lan: true}\n";

class LanDiscovery : public DomainFixture {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
    cable = std::make_unique<Cable>();
    if (!cable->ready || !cable->Set("up")) GTEST_SKIP() << "no network namespaces with veth here";
  }

  struct Talker {
    Talker(const std::string& host, const std::string& yaml) {
      On(host, [&] {
        robot.emplace(yaml, "talker");
        publish = (*robot)->Advertise<Note>("notes");
      });
    }
    Session* operator->() const { return robot->session.get(); }
    void Say(int count) {
      for (int i = 0; i < count; ++i) publish(std::make_unique<Note>(std::to_string(i)));
    }
    std::optional<Robot> robot;
    Publisher<Note> publish;
  };
  struct Listener {
    Listener(const std::string& host, const std::string& yaml) {
      On(host, [&] {
        robot.emplace(yaml, "listener");
        subscription = (*robot)->FromAny<Note>("notes", kSerial, std::ref(notes), {.queue = Queue::KeepAll(200)});
      });
    }
    Notes notes;
    std::optional<Robot> robot;
    Subscription subscription;
  };

  std::unique_ptr<Cable> cable;
};

TEST_F(LanDiscovery, SessionsOfTwoHostsFindEachOther) {
  Listener listener(cable->right, "discovery: {local: false, lan: {interfaces: [" + cable->right_interface + "]}}");
  Talker talker(cable->left, kLan);
  ASSERT_EQ(talker->PublisherEndpoints().size(), 1U) << "it has bound a port by itself";
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  talker.Say(20);
  EXPECT_TRUE(Await([&] { return listener.notes.size() == 20; }));
  const auto peers = (*listener.robot)->Peers();
  ASSERT_EQ(peers.size(), 1U);
  EXPECT_EQ(peers[0].id, talker->id());
  EXPECT_EQ(peers[0].transport, "ZeroMQ");
}

TEST_F(LanDiscovery, IsOffByDefault) {
  Listener listener(cable->right, kLan);
  Talker talker(cable->left, "discovery: {local: false}\nnetwork: {publisher: {ip: 'tcp://*:5553'}}");
  EXPECT_FALSE(talker->WaitForSubscribers("notes", 1, std::chrono::milliseconds(500)));
}

TEST_F(LanDiscovery, ChannelListOfThePublishersEndpointApplies) {
  Listener listener(cable->right, kLan);
  Talker talker(cable->left, std::string(kLan) + "network: {publisher: {ip: 'tcp://*:5553', channels: [poses]}}");
  (void)talker->Advertise<Note>("poses");
  Notes poses;
  const auto subscription = (*listener.robot)->FromAny<Note>("poses", kSerial, std::ref(poses));
  ASSERT_TRUE(talker->WaitForSubscribers("poses", 1, kPatience));
  EXPECT_FALSE(talker->WaitForSubscribers("notes", 1, std::chrono::milliseconds(200)));
}

// The peer is found by the registry of the host, by two names of its endpoint in the configuration, and by the beacon.
TEST_F(LanDiscovery, PeerThatIsFoundInEveryWayIsOnePeerAndMessagesArriveOnce) {
  ASSERT_TRUE(Ip("-n " + cable->left + " addr add 10.198.0.3/24 dev " + cable->left_interface));
  Listener listener(cable->right,
                    "discovery: {lan: true}\nnetwork: {subscribers: [{ip: 'tcp://10.198.0.1:5553'}, "
                    "{ip: 'tcp://10.198.0.3:5553'}]}");
  Talker talker(cable->left, "discovery: {lan: true}\nnetwork: {publisher: {ip: 'tcp://*:5553'}}");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  Linger(std::chrono::milliseconds(1200));  // Time for a beacon's period, and for all connections.
  talker.Say(100);
  EXPECT_TRUE(Await([&] { return listener.notes.size() >= 100; }));
  Linger(std::chrono::milliseconds(300));
  EXPECT_EQ(listener.notes.size(), 100U);
  ASSERT_EQ((*listener.robot)->Peers().size(), 1U);
  EXPECT_EQ((*listener.robot)->Peers()[0].why, "no transport of this host reaches it");
  EXPECT_EQ(talker->Snapshot().traffic.at(0).out.subscribers, 1U);
}

TEST_F(LanDiscovery, PeerThatFallsSilentIsDisconnectedAndFoundAgain) {
  Listener listener(cable->right, kLan);
  Talker talker(cable->left, kLan);
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  ASSERT_TRUE(cable->Set("down"));
  EXPECT_TRUE(Await([&] { return listener.robot->Said(", which is gone: "); }));
  EXPECT_TRUE(listener.robot->Said("Nothing has arrived from talker:"));
  // The endpoint is given up after the peer timeout; what is published at that moment may be missed, and that is told.
  // If it were still tried then, a failure would be logged.
  Linger(std::chrono::seconds(6));
  EXPECT_FALSE(listener.robot->Said("No connection to"));
  ASSERT_TRUE(cable->Set("up"));
  ASSERT_TRUE(Await([&] { return talker->Peers().size() == 1; }));
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  talker.Say(5);
  EXPECT_TRUE(Await([&] { return listener.notes.size() == 5; }));
  EXPECT_TRUE(Await([&] { return listener.robot->Said("Messages from talker:"); }));
}

TEST_F(LanDiscovery, EndpointCanBeAddedAndRemovedWhileTheBeaconHearsIt) {
  Listener listener(cable->right, kLan);
  Talker talker(cable->left, std::string(kLan) + "network: {publisher: {ip: 'tcp://*:5553'}}");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  (*listener.robot)->AddSubscriberEndpoint({"tcp://10.198.0.1:5553", {"poses"}, false});
  EXPECT_TRUE(Await([&] { return talker->Snapshot().traffic.at(0).out.subscribers == 0; }))
      << "the list of the added endpoint applies";
  (*listener.robot)->RemoveSubscriberEndpoint("tcp://10.198.0.1:5553");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  talker.Say(5);
  EXPECT_TRUE(Await([&] { return listener.notes.size() == 5; }));
}

}  // namespace
}  // namespace hgros::test::lan_discovery_test
