// Sessions of one host find each other without configuration.
#include <unistd.h>

#include <algorithm>
#include <thread>

#include <foxglove/Log.pb.h>

#include "session/domain_fixture.hpp"
#include "support/error_of.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::test::local_discovery_test {
namespace {

class LocalDiscovery : public DomainFixture {
 protected:
  [[nodiscard]] Subscription Listen(const Robot& robot, Queue queue = {}) {
    return robot->FromAny<Note>("notes", kSerial, std::ref(notes), {.queue = queue});
  }
  Notes notes;
};

TEST_F(LocalDiscovery, TwoProgramsWithOneChannelFindEachOther) {
  Robot listener("");
  const auto subscription = Listen(listener);
  Robot talker("");
  const auto publish = talker->Advertise<Note>("notes");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  ASSERT_TRUE(listener->WaitForPublishers("notes", 1, kPatience));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(publish(std::make_unique<Note>(std::to_string(i))), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return notes.size() == 10; }));
  ASSERT_EQ(talker->Peers().size(), 1U);
  EXPECT_EQ(talker->Peers()[0].id, listener->id());
  EXPECT_EQ(talker->Peers()[0].transport, "shared memory");
  EXPECT_EQ(talker->Peers()[0].why, "same host");
  EXPECT_TRUE(talker->PublisherEndpoints().empty()) << "no socket was opened to the network";
}

TEST_F(LocalDiscovery, MessagesGoBothWaysOnOneChannelWithoutEcho) {
  Robot one(""), two("");
  Notes at_one, at_two;
  const auto first = one->FromAny<Note>("notes", kSerial, std::ref(at_one));
  const auto second = two->FromAny<Note>("notes", kSerial, std::ref(at_two));
  (void)one->Advertise<Note>("notes");
  (void)two->Advertise<Note>("notes");
  ASSERT_TRUE(one->WaitForSubscribers("notes", 2, kPatience));
  ASSERT_TRUE(two->WaitForSubscribers("notes", 2, kPatience));
  one->ToAny("notes", Note("from one"));
  ASSERT_TRUE(Await([&] { return at_one.size() == 1 && at_two.size() == 1; }));
  two->ToAny("notes", Note("from two"));
  ASSERT_TRUE(Await([&] { return at_one.size() == 2 && at_two.size() == 2; }));
  EXPECT_EQ(at_one.texts(), (std::vector<std::string>{"from one", "from two"}));
  EXPECT_EQ(at_two.texts(), at_one.texts());
}

TEST_F(LocalDiscovery, SessionsThatExchangeNothingDoNotPairButAreKnown) {
  Robot one("", "one"), two("", "two");
  Notes at_one, at_two;
  const auto first = one->FromAny<Note>("notes", kSerial, std::ref(at_one));
  const auto second = two->FromAny<Note>("notes", kSerial, std::ref(at_two));
  const auto subscribers = [](Robot& robot) {
    const auto channels = robot->Channels();
    const auto found = std::ranges::find(channels, "notes", &KnownChannel::name);
    return found == channels.end() ? 0 : found->subscribers.size();
  };
  ASSERT_TRUE(Await([&] { return subscribers(one) == 2 && subscribers(two) == 2; }));
  Linger(std::chrono::milliseconds(100));
  EXPECT_TRUE(one->Peers().empty());
  EXPECT_TRUE(two->Peers().empty());
  (void)two->Advertise<Note>("notes");
  ASSERT_TRUE(two->WaitForSubscribers("notes", 2, kPatience));
  EXPECT_EQ(one->Peers().size(), 1U);
}

TEST_F(LocalDiscovery, RegistryThatFailsAtTheStartIsTriedAgain) {
  const ScratchFolder folder;
  setenv("XDG_RUNTIME_DIR", folder.path().c_str(), 1);
  const auto obstacle = folder.Write("hgros", "in the way");
  Robot listener(""), talker("");
  const auto subscription = Listen(listener);
  (void)talker->Advertise<Note>("notes");
  EXPECT_FALSE(talker->WaitForSubscribers("notes", 1, std::chrono::milliseconds(100)));
  EXPECT_TRUE(talker.Said("are not found. ")) << "the reason is logged";
  std::filesystem::remove(obstacle);
  EXPECT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  unsetenv("XDG_RUNTIME_DIR");
}

TEST_F(LocalDiscovery, SessionsOfDifferentDomainsOrWithoutDiscoveryAreNotFound) {
  Robot listener("");
  const auto subscription = Listen(listener);
  Robot hermit("discovery: {local: false}");
  Enter("other-" + SessionId::Random().ToString());
  Robot stranger("");
  for (const Robot* robot : {&hermit, &stranger}) {
    (void)(*robot)->Advertise<Note>("notes");
    EXPECT_FALSE((*robot)->WaitForSubscribers("notes", 1, std::chrono::milliseconds(200)));
  }
}

TEST_F(LocalDiscovery, DomainCanBeSetInTheConfigurationAndIsCheckedInTheEnvironment) {
  Enter("../etc");
  EXPECT_NE(ErrorOf([] { const Robot robot(""); }).find("HGROS_DOMAIN"), std::string::npos);
  setenv("HGROS_DOMAIN", "", 1);
  const std::string yaml = "discovery: {domain: test-" + SessionId::Random().ToString() + "}";
  Robot talker(yaml), listener(yaml);
  const auto subscription = Listen(listener);
  (void)talker->Advertise<Note>("notes");
  EXPECT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
}

TEST_F(LocalDiscovery, CanBeLimitedToNamedProcesses) {
  Robot talker("discovery: {local: [friend]}", "talker");
  Robot stranger("", "stranger");
  Robot close("", "friend");
  Notes at_stranger, at_friend;
  const auto first = stranger->FromAny<Note>("notes", kSerial, std::ref(at_stranger));
  const auto second = close->FromAny<Note>("notes", kSerial, std::ref(at_friend));
  const auto publish = talker->Advertise<Note>("notes");
  const auto back = stranger->Advertise<Note>("back");
  Notes from_stranger;
  const auto third = talker->FromAny<Note>("back", kSerial, std::ref(from_stranger));
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  EXPECT_TRUE(Await([&] { return talker.Count("does not connect with session") == 1; }));
  EXPECT_TRUE(Await([&] { return stranger.Said("there does not list \"stranger\""); }));
  EXPECT_TRUE(talker.Said("here does not list \"stranger\""));
  EXPECT_FALSE(talker->WaitForSubscribers("notes", 2, std::chrono::milliseconds(200)));
  EXPECT_FALSE(talker->WaitForPublishers("back", 1, std::chrono::milliseconds(1)));
  publish(std::make_unique<Note>("hello"));
  EXPECT_TRUE(Await([&] { return at_friend.size() == 1; }));
  EXPECT_EQ(at_stranger.size(), 0U);
}

TEST_F(LocalDiscovery, LogsPeersWithTransportAndTheReasonOfTheirEnd) {
  Robot listener("", "listener");
  const auto subscription = Listen(listener);
  for (const bool stays : {false, true}) {
    Robot talker("", "talker");
    (void)talker->Advertise<Note>("notes");
    ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
    const std::string me = "ession listener:" + std::to_string(getpid());
    const std::string other = "ession talker:" + std::to_string(getpid());
    EXPECT_TRUE(Await([&] { return listener.Said(me + " reaches s" + other + " through shared memory: same host."); }));
    if (stays) listener.session.reset();
    talker.session.reset();
    EXPECT_TRUE(Await([&] { return listener.Said(me + " no longer reaches s" + other); }));
    EXPECT_TRUE(listener.Said(stays ? other + ": this session ends." : other + ", which is gone: it said goodbye."));
    EXPECT_TRUE(stays || talker.Said(me));
  }
}

// ThreadSanitizer checks this test for data races.
TEST_F(LocalDiscovery, EndpointsCanBeAddedWhileSessionsComeAndGo) {
  const Bus bus;
  for (int round = 0; round < 5; ++round) {
    Robot steady("");
    const auto subscription = Listen(steady);
    std::jthread neighbors([] {
      for (int i = 0; i < 4; ++i) {
        Robot talker("");
        (void)talker->Advertise<Note>("notes");
        EXPECT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
      }
    });
    std::jthread reader([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) (void)steady->Snapshot();
    });
    steady->AddPublisherEndpoint({bus.Endpoint("bus" + std::to_string(round)), {}, true});
    neighbors.join();
  }
}

TEST_F(LocalDiscovery, PeerThatIsFoundTwiceIsOnePeerOverSharedMemory) {
  const Bus bus;
  Robot talker(bus.Publishing("a"));
  Robot listener(bus.Subscribing("a"));
  const auto subscription = Listen(listener, Queue::KeepAll(200));
  const auto publish = talker->Advertise<Note>("notes");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(publish(std::make_unique<Note>(std::to_string(i))), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return notes.size() == 100; }));
  Linger(std::chrono::milliseconds(300));  // Time for ZeroMQ to connect and for repeats to arrive.
  EXPECT_EQ(notes.size(), 100U);
  ASSERT_EQ(listener->Peers().size(), 1U);
  // On a busy machine ZeroMQ may have been used before.
  EXPECT_TRUE(Await([&] {
    const auto peers = listener->Peers();
    return peers.size() == 1 && peers[0].transport == "shared memory";
  }));
  EXPECT_EQ(talker->Snapshot().traffic.at(0).out.subscribers, 1U);
}

TEST_F(LocalDiscovery, SessionThatReturnsIsFoundAgain) {
  Robot listener("");
  const auto subscription = Listen(listener);
  for (std::size_t life = 1; life <= 5; ++life) {
    Robot talker("");
    const auto publish = talker->Advertise<Note>("notes");
    ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience)) << life;
    publish(std::make_unique<Note>("x"));
    ASSERT_TRUE(Await([&] { return notes.size() == life; })) << life;
  }
}

TEST_F(LocalDiscovery, TypeMismatchIsLoggedOnBothSides) {
  Robot talker(""), listener("");
  const auto subscription = Listen(listener);
  (void)talker->Advertise<foxglove::Log>("notes");
  EXPECT_TRUE(Await(
      [&] { return talker.Said("Use one type in both programs") && listener.Said("Use one type in both programs"); }));
}

TEST_F(LocalDiscovery, LoanedBlockIsReadInPlace) {
  Robot talker("");
  const auto publish = talker->Advertise<Block>("blocks");
  auto on_heap = talker->Loan<Block>("blocks", 100);
  ASSERT_EQ(on_heap->size(), 100U);
  EXPECT_EQ(publish(std::move(on_heap)), PublishStatus::kOk) << "without a subscriber";
  Robot listener("");
  std::mutex mutex;
  std::shared_ptr<const Block> received;
  const auto subscription = listener->FromAny<Block>("blocks", kSerial, [&](const std::shared_ptr<const Block>& block) {
    const std::scoped_lock lock(mutex);
    received = block;
  });
  ASSERT_TRUE(talker->WaitForSubscribers("blocks", 1, kPatience));
  auto loan = talker->Loan<Block>("blocks", 1 << 20);
  ASSERT_EQ(loan->size(), 1U << 20);
  std::byte* const written = loan->writable().data();
  written[0] = std::byte{1};
  ASSERT_EQ(publish(std::move(loan)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] {
    const std::scoped_lock lock(mutex);
    return received != nullptr;
  }));
  EXPECT_EQ(received->bytes()[0], std::byte{1});
  // Writes through the publisher's mapping of the same memory. Only a test may do this.
  written[0] = std::byte{2};
  EXPECT_EQ(received->bytes()[0], std::byte{2});
  received.reset();
}

}  // namespace
}  // namespace hgros::test::local_discovery_test
