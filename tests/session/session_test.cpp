#include "hgros/session/session.hpp"

#include <gmock/gmock.h>

#include <array>
#include <fstream>
#include <new>

#include <foxglove/Log.pb.h>
#include <foxglove/Vector3.pb.h>

#include "conformance/tcp_forwarder.hpp"
#include "hgros/session/default_session.hpp"
#include "session/domain_fixture.hpp"

namespace hgros::test {
namespace {

class TwoSessions : public testing::Test {
 protected:
  const Bus bus{};
  Robot talker{bus.Publishing("a")};
  Robot listener{bus.Subscribing("a")};
};

std::vector<std::string> Numbered(int from, int to) {
  std::vector<std::string> texts;
  for (int i = from; i < to; ++i) texts.push_back(std::to_string(i));
  return texts;
}

// A note that there is no memory to copy.
struct HeavyNote : Note {
  HeavyNote() = default;
  HeavyNote(const HeavyNote& /*other*/) : Note() { throw std::bad_alloc(); }
  HeavyNote& operator=(const HeavyNote&) = delete;
  ~HeavyNote() = default;
};

TEST(Session, MovesMessagesAndRefusesThoseThatThereIsNoMemoryToCopy) {
  const Bus bus;
  Robot robot(bus.Publishing("a"));
  const HeavyNote note;
  EXPECT_EQ(robot->ToAny("notes", note), PublishStatus::kNoMemory);
  EXPECT_EQ(robot->Advertise<HeavyNote>("notes")(note), PublishStatus::kNoMemory);
  Note moved("a text that is too long to be inside the string");
  const char* const text = moved.text.data();
  const char* seen = nullptr;
  const auto subscription = robot->FromAny<Note>(
      "moved", kSerial, [&](const Note& got) { seen = got.text.data(); }, Inline());
  EXPECT_EQ(robot->ToAny("moved", std::move(moved)), PublishStatus::kOk);
  EXPECT_EQ(seen, text) << "a copy was delivered";
  EXPECT_EQ(robot.Count("There is no memory to copy a message that is published on channel \"notes\""), 1U);
}

TEST_F(TwoSessions, SendsMessagesToAnotherSessionInOrder) {
  Notes notes;
  const auto subscription = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  const auto publish = talker->Advertise<Note>("notes");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  ASSERT_TRUE(listener->WaitForPublishers("notes", 1, kPatience));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(publish(std::make_unique<Note>(std::to_string(i))), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return notes.size() == 10; }));
  EXPECT_EQ(notes.texts(), Numbered(0, 10));
  EXPECT_EQ(talker->Peers().size(), 1U);
}

// The connections at a port of this host that its owner has not closed yet.
int ConnectionsAt(int port) {
  int count = 0;
  std::ifstream all("/proc/net/tcp");
  std::string number, local, remote, state, rest;
  while (all >> number >> local >> remote >> state && std::getline(all, rest)) {
    const bool open = state == "01" || state == "08";  // Established, or closed by the other end only.
    if (open && std::stoi(local.substr(local.find(':') + 1), nullptr, 16) == port) ++count;
  }
  return count;
}

// Two names of one socket make two connections. After either is removed, messages still arrive once.
TEST(Session, ReceivesEachMessageOnceThroughTwoNamesOfOneEndpoint) {
  for (const std::size_t removed : {0U, 1U}) {
    SCOPED_TRACE(removed);
    Robot talker("network: {publisher: {ip: 'tcp://*:*'}}");
    const std::string bound = talker->PublisherEndpoints().at(0);
    const std::string port = bound.substr(bound.rfind(':'));
    const std::array names{"tcp://127.0.0.1" + port, "tcp://127.0.0.2" + port};
    Robot listener("network: {subscribers: [{ip: '" + names[0] + "'}, {ip: '" + names[1] + "'}]}");
    Notes notes;
    const auto subscription =
        listener->FromAny<Note>("notes", kSerial, std::ref(notes), {.queue = Queue::KeepAll(100)});
    const auto publish = talker->Advertise<Note>("notes");
    const auto pass = [&](int from, int to) {
      ASSERT_TRUE(Await([&] { return talker->Snapshot().traffic.at(0).out.subscribers == 1; }));
      for (int i = from; i < to; ++i) publish(std::make_unique<Note>(std::to_string(i)));
      EXPECT_TRUE(Await([&] { return notes.size() == static_cast<std::size_t>(to); })) << notes.size();
    };
    ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
    const int at = std::stoi(port.substr(1));
    ASSERT_TRUE(Await([&] { return ConnectionsAt(at) == 2; }));
    Linger(std::chrono::milliseconds(300));  // Time for subscriptions over the second one.
    pass(0, 50);
    listener->RemoveSubscriberEndpoint(names[removed]);
    ASSERT_TRUE(Await([&] { return ConnectionsAt(at) == 1; }));
    Linger(std::chrono::milliseconds(300));  // Time for messages about the removal.
    ASSERT_TRUE(Await([&] { return talker->WaitForSubscribers("notes", 1, std::chrono::nanoseconds(0)); }));
    pass(50, 100);
    EXPECT_EQ(notes.texts(), Numbered(0, 100));
    EXPECT_EQ(talker->Snapshot().peers.size(), 1U);
  }
}

TEST(Session, DeliversByPointerAndEncodesOnceForAllRemoteSubscribersAndNotWithoutThem) {
  const Bus bus;
  Robot robot(bus.Publishing("a"));
  std::vector<const Note*> seen;
  std::vector<Subscription> local;
  for (int i = 0; i < 3; ++i) {
    local.push_back(robot->FromAny<Note>(
        "notes", kSerial, [&](const std::shared_ptr<const Note>& note) { seen.push_back(note.get()); }, Inline()));
  }
  const auto expect_pointers = [&] {
    seen.clear();
    auto note = std::make_unique<Note>("x");
    const Note* sent = note.get();
    EXPECT_EQ(robot->ToAny("notes", std::move(note)), PublishStatus::kOk);
    EXPECT_EQ(seen, (std::vector<const Note*>{sent, sent, sent})) << "delivered by pointer, before publishing returned";
  };
  Note::written = 0;
  expect_pointers();
  EXPECT_EQ(Note::written, 0);
  std::vector<std::unique_ptr<Robot>> observers;
  std::vector<Subscription> outside;
  Notes notes;
  for (int i = 0; i < 2; ++i) {
    observers.push_back(std::make_unique<Robot>(bus.Subscribing("a")));
    for (int k = 0; k < 3; ++k) {
      outside.push_back((*observers.back())->FromAny<Note>("notes", kSerial, std::ref(notes)));
    }
  }
  ASSERT_TRUE(robot->WaitForSubscribers("notes", 5, kPatience));
  Note::read = 0;
  expect_pointers();
  ASSERT_TRUE(Await([&] { return notes.size() == 6; }));
  EXPECT_EQ(Note::written, 1) << "encoded once, for any number of subscribers";
  EXPECT_EQ(Note::read, 2) << "decoded once in each session, for any number of subscriptions";
}

// Both publish and subscribe.
struct BothWays {
  explicit BothWays(const std::string& firsts = {}) : first(bus.Both("a", "b") + firsts) {}
  [[nodiscard]] bool Joined() {
    return first->WaitForSubscribers("notes", 2, kPatience) && second->WaitForSubscribers("notes", 2, kPatience);
  }
  const Bus bus;
  Notes at_first;
  Notes at_second;
  Robot first;
  Robot second{bus.Both("b", "a")};
  const Subscription one = first->FromAny<Note>("notes", kSerial, std::ref(at_first));
  const Subscription two = second->FromAny<Note>("notes", kSerial, std::ref(at_second));
};

TEST(Session, MessagesDoNotEchoBetweenTwoSessions) {
  BothWays they;
  ASSERT_TRUE(they.Joined());
  EXPECT_EQ(they.first->ToAny("notes", Note("from first")), PublishStatus::kOk);
  EXPECT_EQ(they.second->ToAny("notes", Note("from second")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return they.at_first.size() == 2 && they.at_second.size() == 2; }));
  // An echo would arrive before one more message over the same connection.
  EXPECT_EQ(they.first->ToAny("notes", Note("last")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return they.at_first.size() >= 3 && they.at_second.size() >= 3; }));
  EXPECT_EQ(they.at_second.size(), 3U);
  EXPECT_EQ(they.at_first.size(), 3U);
}

TEST(Session, LongCallbackDoesNotDelayOtherNodesOfARemoteChannel) {
  const Bus bus;
  Robot talker(bus.Publishing("a"));
  Robot listener(bus.Subscribing("a") + "data_graph: {threads: 2}\n");
  Door door;
  std::atomic<int> slow{0};
  Notes notes;
  const auto one = listener->FromAny<Note>("notes", kSerial, [&](const Note&) {
    door.Pass();
    ++slow;
  });
  const auto two = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  const auto publish = talker->Advertise<Note>("notes");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(publish(Note(std::to_string(i))), PublishStatus::kOk);
    EXPECT_TRUE(Await([&] { return notes.size() == static_cast<std::size_t>(i) + 1; }));
  }
  EXPECT_EQ(slow, 0);
  door.Open();
  EXPECT_TRUE(Await([&] { return slow == 5; }));
}

TEST(Session, ClosedChannelStillSendsToAndReceivesFromOtherSessions) {
  BothWays they("data_graph: {close_channels: [notes]}\n");
  ASSERT_TRUE(they.Joined());
  EXPECT_EQ(they.first->ToAny("notes", Note("out")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return they.at_second.size() == 1; }));
  EXPECT_EQ(they.second->ToAny("notes", Note("in")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return they.at_first.size() == 1; }));
  EXPECT_EQ(they.at_first.texts(), std::vector<std::string>{"in"});
  they.first->SetClosed("notes", false);
  EXPECT_EQ(they.first->ToAny("notes", Note("both")), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return they.at_first.size() == 2; }));
}

TEST(Session, SendsOnlyListedChannelsAndTheListCanChangeAtRunTime) {
  const Bus bus;
  Robot talker(bus.Publishing("a", "open"));
  Robot listener(bus.Subscribing("a"));
  Notes open;
  Notes hidden;
  const auto one = listener->FromAny<Note>("open", kSerial, std::ref(open));
  const auto two = listener->FromAny<Note>("hidden", kSerial, std::ref(hidden));
  (void)talker->Advertise<Note>("open");
  (void)talker->Advertise<Note>("hidden");
  ASSERT_TRUE(talker->WaitForSubscribers("open", 1, kPatience));
  EXPECT_FALSE(talker->WaitForSubscribers("hidden", 1, std::chrono::milliseconds(100)));
  EXPECT_EQ(talker->ToAny("hidden", Note("secret")), PublishStatus::kOk);
  talker->AllowPublishing("hidden", true);
  ASSERT_TRUE(talker->WaitForSubscribers("hidden", 1, kPatience));
  EXPECT_EQ(talker->ToAny("hidden", Note("told")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return hidden.size() == 1; }));
  EXPECT_EQ(hidden.texts()[0], "told");
  talker->AllowPublishing("hidden", false);
  ASSERT_TRUE(Await([&] { return !talker->WaitForSubscribers("hidden", 1, std::chrono::nanoseconds(0)); }));
  EXPECT_EQ(talker->ToAny("hidden", Note("again secret")), PublishStatus::kOk);
  EXPECT_EQ(talker->ToAny("open", Note("marker")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return open.size() == 1; }));
  EXPECT_EQ(hidden.size(), 1U);
}

TEST(Session, LogsAChannelThatNoEndpointListsOnceWithTheNearestName) {
  const Bus bus;
  Robot talker(bus.Publishing("a", "wheel"));
  Robot listener(bus.Subscribing("a", "wheel"));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(talker->ToAny("wheels", Note("x")), PublishStatus::kOk);
  EXPECT_TRUE(
      talker.Said("Channel \"wheels\" is published, but does not leave this process: no publisher endpoint has "
                  "it in its list of channels. Did you mean \"wheel\"?"));
  const auto subscription = listener->FromAny<Note>("battery", kSerial, [](const Note&) {});
  EXPECT_TRUE(listener.Said("Channel \"battery\" is subscribed to, but nothing enters this process"));
  const auto heard = listener->FromAny<Note>("wheel", kSerial, [](const Note&) {});
  EXPECT_FALSE(listener.Said("\"wheel\" is subscribed to"));
}

struct Level {
  int value = 0;
};

TEST_F(TwoSessions, LogsEachChannelThatHasDifferentTypes) {
  constexpr std::size_t kChannels = 12;
  std::vector<Subscription> subscriptions;
  for (std::size_t i = 0; i < kChannels; ++i) {
    const std::string channel = "channel" + std::to_string(i);
    (void)talker->ToAny(channel, std::make_unique<Note>("x"));
    subscriptions.push_back(listener->FromAny<Level>(channel, kSerial, [](const Level&) {}));
  }
  EXPECT_TRUE(Await([&] {
    return std::max(talker.Count("Use one type in both programs"), listener.Count("Use one type in both programs")) ==
           kChannels;
  }));
}

constexpr const char* kMisspelled = "data_graph: {nodes: {planner: {queue: latest}, localisation: {queue: latest}}}\n";

TEST(Session, LogsUnusedConfiguredNodeNamesAtItsEndWithTheNearestName) {
  for (const bool misspelled : {true, false}) {
    SCOPED_TRACE(misspelled);
    Robot robot(kMisspelled);
    {
      const std::string name = misspelled ? "localization" : "localisation";
      const auto planner = robot->FromGraph<Note>("a", kSerial, [](const Note&) {}, {.name = "planner"});
      const auto localizer = robot->FromGraph<Note>("b", kSerial, [](const Note&) {}, {.name = name});
    }
    EXPECT_FALSE(robot.Said("data_graph: nodes"));
    robot.session.reset();
    EXPECT_EQ(robot.Said("names that no node of this process has so far: \"localisation\" (did you mean "
                         "\"localization\"?)."),
              misspelled);
    EXPECT_EQ(robot.lines.all().size(), misspelled ? 1U : 0U);
  }
}

TEST(Session, LogsConfiguredNodeNamesWithoutASimilarOneForDebuggingOnly) {
  std::vector<LogLevel> levels;
  std::string said;
  const auto log = [&](LogLevel level, std::string_view text) {
    levels.push_back(level);
    said = text;
  };
  {
    Session session(Config::Parse(kMisspelled), {"robot", log});
    const auto planner = session.FromGraph<Note>("a", kSerial, [](const Note&) {}, {.name = "plan"});
  }
  EXPECT_EQ(levels, std::vector<LogLevel>{LogLevel::kDebug}) << said;
  EXPECT_TRUE(said.ends_with("so far: \"localisation\", \"planner\".")) << said;
}

TEST(Session, DoesNotLogUnusedNodeNamesWhenItsConstructorThrows) {
  std::vector<std::string> lines;
  const std::string yaml = std::string(kMisspelled) + "network: {publisher: {ip: \"ipc:///nowhere/at/all\"}}\n";
  const auto log = [&](LogLevel, std::string_view text) { lines.emplace_back(text); };
  EXPECT_THROW(Session(Config::Parse(yaml), {"robot", log}), Error);
  EXPECT_EQ(lines, std::vector<std::string>{});
}

TEST(Session, LatchedMessagesReachALateSessionAndItsLateNodesOnce) {
  const Bus bus;
  Robot talker(bus.Publishing("a"));
  const auto publish = talker->Advertise<Note>("map", {.latched = 2});
  for (int i = 0; i < 5; ++i) EXPECT_EQ(publish(std::make_unique<Note>(std::to_string(i))), PublishStatus::kOk);
  Robot listener(bus.Subscribing("a"));
  Notes first;
  const auto one = listener->FromAny<Note>("map", kSerial, std::ref(first));
  ASSERT_TRUE(Await([&] { return first.size() == 2; }));
  Notes second;
  const auto two = listener->FromAny<Note>("map", kSerial, std::ref(second));
  ASSERT_TRUE(Await([&] { return second.size() == 2; }));
  EXPECT_EQ(publish(std::make_unique<Note>("5")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return first.size() == 3 && second.size() == 3; }));
  EXPECT_EQ(first.texts(), Numbered(3, 6));
  EXPECT_EQ(second.texts(), Numbered(3, 6));
}

/// A message whose codec records the threads that encode it.
struct Traced {
  bool SerializeToString(std::string* out) const {
    const std::scoped_lock lock(mutex);
    writers.push_back(std::this_thread::get_id());
    *out = "traced";
    return true;
  }
  bool ParseFromString(const std::string& in) { return in == "traced"; }

  inline static std::mutex mutex;
  inline static std::vector<std::thread::id> writers;
};

TEST(Session, LatchedMessageWithItsOwnCodecIsEncodedOnThePublishingThread) {
  const Bus bus;
  const EndpointConfig endpoint{bus.Endpoint("late"), {}, true};
  for (const bool joins_late : {false, true}) {
    Traced::writers.clear();
    Robot talker(joins_late ? "" : bus.Publishing("a"));
    const auto publish = talker->Advertise<Traced>("map", {.latched = 2});
    for (int i = 0; i < 3; ++i) EXPECT_EQ(publish(std::make_unique<Traced>()), PublishStatus::kOk);
    EXPECT_EQ(Traced::writers.size(), joins_late ? 0U : 3U) << "nothing is encoded without a transport";
    if (joins_late) talker->AddPublisherEndpoint(endpoint);
    Robot listener(bus.Subscribing(joins_late ? "late" : "a"));
    std::atomic<int> heard{0};
    const auto subscription = listener->FromAny<Traced>("map", kSerial, [&](const Traced&) { ++heard; });
    ASSERT_TRUE(Await([&] { return heard == 2; }));
    EXPECT_EQ(publish(std::make_unique<Traced>()), PublishStatus::kOk);
    ASSERT_TRUE(Await([&] { return heard == 3; }));
    for (const std::thread::id writer : Traced::writers) EXPECT_EQ(writer, std::this_thread::get_id());
    EXPECT_EQ(Traced::writers.size(), joins_late ? 3U : 4U) << "each message once";
  }
}

TEST(Session, LatchedMessageReachesALateNodeAfterALostConnection) {
  Robot talker("network: {publisher: {ip: \"tcp://127.0.0.1:*\"}}");
  const std::string endpoint = talker->PublisherEndpoints()[0];
  conformance::TcpForwarder cable(static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1))));
  Robot listener("network: {subscribers: [{ip: \"tcp://127.0.0.1:" + std::to_string(cable.port()) + "\"}]}");
  const auto publish = talker->Advertise<Note>("map", {.latched = 1});
  EXPECT_EQ(publish(std::make_unique<Note>("1")), PublishStatus::kOk);
  Notes first;
  const auto one = listener->FromAny<Note>("map", kSerial, std::ref(first));
  ASSERT_TRUE(Await([&] { return first.size() == 1; }));
  cable.Cut();
  ASSERT_TRUE(Await([&] { return listener->Peers().empty(); }));
  Notes second;
  const auto two = listener->FromAny<Note>("map", kSerial, std::ref(second));
  cable.Resume();
  ASSERT_TRUE(Await([&] { return second.size() == 1; }));
  EXPECT_EQ(publish(std::make_unique<Note>("2")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return first.size() == 2 && second.size() == 2; }));
  EXPECT_EQ(first.texts(), Numbered(1, 3));
  EXPECT_EQ(second.texts(), Numbered(1, 3));
}

TEST_F(TwoSessions, LosslessChannelLosesNothingWithASlowRemoteSubscriber) {
  Notes notes;
  std::atomic<int> slow{20};
  const auto subscription = listener->FromAny<Note>("notes", kSerial,
                                                    [&](const Note& note) {
                                                      if (slow-- > 0) Linger(std::chrono::milliseconds(2));
                                                      notes(note);
                                                    },
                                                    {{}, Queue::KeepAll(4), Executor::Dedicated()});
  const auto publish = talker->Advertise<Note>("notes");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  int full = 0;
  constexpr int kCount = 500;
  for (int i = 0; i < kCount; ++i) {
    auto note = std::make_unique<Note>(std::to_string(i));
    PublishStatus status = publish(std::move(note));
    if (status == PublishStatus::kFull) {
      ++full;
      ASSERT_NE(note, nullptr);
      status = publish.Wait(std::move(note), std::chrono::steady_clock::now() + kPatience);
    }
    ASSERT_EQ(status, PublishStatus::kOk);
  }
  ASSERT_TRUE(Await([&] { return notes.size() == kCount; }));
  EXPECT_EQ(notes.texts(), Numbered(0, kCount));
  EXPECT_GT(full, 0);
}

TEST_F(TwoSessions, LogsATypeMismatchOnBothSidesAndPublishesAnEvent) {
  std::atomic<int> events{0};
  const auto watch = listener->FromGraph<PeerEvent>(kPeerEventsChannel, kSerial, [&](const PeerEvent& event) {
    if (event.kind == PeerEvent::Kind::kTypeMismatch && event.channel == "pose") ++events;
  });
  (void)talker->Advertise<foxglove::Vector3>("pose");
  const auto subscription = listener->FromAny<foxglove::Log>("pose", kSerial, [](const foxglove::Log&) {});
  for (Robot* robot : {&talker, &listener}) {
    ASSERT_TRUE(Await([&] { return robot->Said("foxglove.Vector3"); }));
    EXPECT_TRUE(robot->Said("pose: " + talker->NameOf(talker->id()) + " publishes foxglove.Vector3, " +
                            listener->NameOf(listener->id()) + " subscribes to foxglove.Log. Use one type in both " +
                            "programs, or give one of the two another channel."));
  }
  EXPECT_TRUE(Await([&] { return events == 1; }));
}

TEST(Session, PublishesEventsWhenPeersComeAndGo) {
  const Bus bus;
  Robot talker(bus.Publishing("a"), "talker");
  std::atomic<int> came{0};
  std::atomic<int> gone{0};
  const auto count = [&](const PeerEvent& event) {
    if (event.kind == PeerEvent::Kind::kCame && event.peer.process == "listener") ++came;
    if (event.kind == PeerEvent::Kind::kGone && event.peer.process == "listener") ++gone;
  };
  const auto watch = talker->FromGraph<PeerEvent>(kPeerEventsChannel, kSerial, count, Inline());
  {
    Robot listener(bus.Subscribing("a"), "listener");
    EXPECT_TRUE(Await([&] { return came == 1; }));
  }
  EXPECT_TRUE(Await([&] { return gone == 1; }));
}

TEST(Session, EndpointsCanBeAddedAtRunTime) {
  const Bus bus;
  Robot talker("");
  Robot listener("");
  Notes notes;
  const auto subscription = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  const auto publish = talker->Advertise<Note>("notes");
  EXPECT_EQ(publish(std::make_unique<Note>("unheard")), PublishStatus::kOk);
  talker->AddPublisherEndpoint({bus.Endpoint("a"), {}, true});
  listener->AddSubscriberEndpoint({bus.Endpoint("a"), {}, true});
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  EXPECT_EQ(publish(std::make_unique<Note>("heard")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return notes.size() == 1; }));
  EXPECT_EQ(notes.texts()[0], "heard");
}

auto ThrowsSentence(const std::string& sentence) {
  return testing::Throws<Error>(testing::Property(&Error::sentence, sentence));
}

TEST(Session, AddedEndpointsAreCheckedAsThoseOfFiles) {
  Robot robot("discovery: {local: false}");
  const auto publish = [&](const std::string& endpoint) { robot->AddPublisherEndpoint({endpoint, {}, true}); };
  const auto subscribe = [&](const std::string& endpoint) { robot->AddSubscriberEndpoint({endpoint, {}, true}); };
  EXPECT_THAT([&] { subscribe("tcp://256.1.1.1:5"); },
              ThrowsSentence(R"(The endpoint is "tcp://256.1.1.1:5", but "256.1.1.1" is not an IPv4 address.)"));
  EXPECT_THAT([&] { subscribe("tcp://localhost:65536"); },
              ThrowsSentence(R"(The endpoint is "tcp://localhost:65536", whose port "65536" is not valid.)"));
  EXPECT_THAT([&] { publish(""); }, ThrowsSentence("The endpoint is empty."));
  EXPECT_THAT([&] { publish("x"); }, ThrowsSentence(R"(The endpoint is "x", which has no port.)"));
}

TEST_F(TwoSessions, SubscriptionMayEndItselfInACallbackForARemoteMessage) {
  const auto publish = talker->Advertise<Note>("notes");
  for (int round = 0; round < 5; ++round) {
    std::optional<Subscription> subscription;
    Door wired;
    std::atomic<int> calls{0};
    const auto end_itself = [&](const Note&) {
      wired.Pass();
      subscription->Reset();
      ++calls;  // Last, because the test continues then.
    };
    subscription.emplace(listener->FromAny<Note>("notes", kSerial, end_itself, Inline()));
    wired.Open();
    ASSERT_TRUE(Await([&] {  // A late message of the last round may have ended it already.
      (void)publish(std::make_unique<Note>("x"));
      return calls > 0;
    })) << "round "
        << round;
    EXPECT_EQ(calls, 1);
  }
}

TEST_F(TwoSessions, LogsTheInlineCallbackThatBlocksItsDestructor) {
  Door door;
  std::atomic<bool> inside{false};
  const auto hold = [&](const Note&) {
    inside = true;
    door.Pass();
  };
  const auto subscription = listener->FromAny<Note>("notes", kSerial, hold, Inline());
  const auto publish = talker->Advertise<Note>("notes");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  EXPECT_EQ(publish(std::make_unique<Note>("x")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return inside.load(); }));
  std::jthread ender([&] { listener.session.reset(); });
  EXPECT_TRUE(Await([&] { return listener.Said("waits for node \"notes#0\" on channel \"notes\""); }));
  door.Open();
}

TEST(Session, CanBeDestroyedWhileMessagesFlow) {
  const Bus bus;
  for (int round = 0; round < 5; ++round) {
    auto talker = std::make_unique<Robot>(bus.Publishing("a"));
    auto listener = std::make_unique<Robot>(bus.Subscribing("a"));
    Notes notes;
    auto subscription = (*listener)->FromAny<Note>("notes", kSerial, std::ref(notes));
    const auto publish = (*talker)->Advertise<Note>("notes");
    std::jthread publisher([&, publish] {
      while (publish(std::make_unique<Note>("x")) != PublishStatus::kClosed) {
      }
    });
    ASSERT_TRUE(Await([&] { return notes.size() > 10; }));
    (round % 2 == 0 ? listener : talker).reset();
    talker.reset();
    listener.reset();
  }
}

// The parameter is the transport of the channel: shared_memory or zmq.
class HeldUpChannel : public DomainFixture, public testing::WithParamInterface<std::string> {};

INSTANTIATE_TEST_SUITE_P(Transports, HeldUpChannel, testing::Values("shared_memory", "zmq"),
                         [](const auto& one) { return one.param == "zmq" ? "Zmq" : "SharedMemory"; });

TEST_P(HeldUpChannel, IsLoggedWithTheSubscriberForWhichItWaits) {
  const Bus bus;
  const std::string rule = "channels: {notes: {transports: [" + GetParam() + "]}}\n";
  Robot talker(bus.Publishing("robot") + rule);
  Robot listener(bus.Subscribing("robot") + rule, "holder");
  Door door;
  const auto subscription = listener->FromAny<Note>("notes", kSerial, [&](const Note&) { door.Pass(); },
                                                    {{}, Queue::KeepAll(1), Executor::Dedicated()});
  const auto publish = talker->Advertise<Note>("notes");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  EXPECT_TRUE(Await([&] {
    (void)publish(Note("x"));
    return talker.Said("Channel \"notes\" waits for ");
  }));
  EXPECT_TRUE(talker.Said("holder"));
  door.Open();
}

// The free functions, as the listings of the paper use them.
TEST(DefaultSession, PublishesAndSubscribesThroughFreeFunctions) {
  Init();
  Notes any;
  Notes graph;
  FromAny<Note>("any", Invoke::kSerial, std::ref(any));
  FromGraph<Note>("graph", Invoke::kConcurrent, std::ref(graph));
  EXPECT_EQ(ToAny("any", std::make_unique<Note>("a")), PublishStatus::kOk);
  EXPECT_EQ(ToAny("any", Note("b")), PublishStatus::kOk);
  EXPECT_EQ(ToGraph("graph", std::make_shared<const Note>("c")), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return any.size() == 2 && graph.size() == 1; }));
  Shutdown();
}

TEST(DefaultSession, MisuseThrowsAnErrorThatNamesTheFix) {
  EXPECT_THROW((void)DefaultSession(), Error);
  Init();
  EXPECT_THROW(Init(), Error);
  Shutdown();
  EXPECT_THROW((void)ToAny("c", Note("x")), Error);
  Shutdown();  // A second call is allowed.
}

}  // namespace
}  // namespace hgros::test
