// What becomes of messages that were published just before their session ends.
#include <cstdint>

#include "conformance/tcp_forwarder.hpp"
#include "session/observed_fixture.hpp"
#include "support/seed.hpp"

namespace hgros::test {
namespace {

constexpr const char* kRestIsLost = "a lossless subscriber of channel \"notes\" does not take its messages";

// With its first report, also of a suppressed race, ThreadSanitizer reads the symbols of the program. That stops a
// thread for longer than a session waits for a subscriber. Then the session may give up, but never without a word.
#ifdef __SANITIZE_THREAD__
constexpr bool kThreadsMayStop = true;
#else
constexpr bool kThreadsMayStop = false;
#endif

class SessionEnd : public ObservedFixture {
 protected:
  [[nodiscard]] Robot& MakeTalker() {
    observer.reset();
    return robot.emplace(PublisherYaml(), "robot");
  }
  [[nodiscard]] Robot& MakeListener() {
    observer.emplace(ObserverYaml(), "observer");
    Connect(*observer->session, *robot->session);
    return *observer;
  }
};

INSTANTIATE_TEST_SUITE_P(Transports, SessionEnd, testing::Values("sharedmemory", "ipc", "tcp"), TransportName);

TEST_P(SessionEnd, LosslessSubscribersGetWhatWasPublishedJustBefore) {
  for (int round = 0; round < test::Rounds(8, 40); ++round) {
    Robot& talker = MakeTalker();
    Robot& listener = MakeListener();
    Notes notes;
    const auto subscription =
        listener->FromAny<Note>("notes", kSerial, std::ref(notes), {.queue = Queue::KeepAll(1000)});
    (void)talker->Advertise<Note>("notes");
    ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
    for (int i = 0; i < 100; ++i) ASSERT_EQ(talker->ToAny("notes", Note(std::to_string(i))), PublishStatus::kOk);
    talker.session.reset();
    ASSERT_TRUE(Await([&] { return notes.size() == 100; })) << "round " << round << ": " << notes.size();
  }
}

// Latched messages wait for the credit of a new subscriber, here for each one.
TEST_P(SessionEnd, WaitsForASubscriberWhileItTakesMessagesHoweverSlowly) {
  for (const std::chrono::milliseconds pause : {std::chrono::milliseconds(0), std::chrono::milliseconds(150)}) {
    SCOPED_TRACE(pause.count());
    Robot& talker = MakeTalker();
    const auto publish = talker->Advertise<Note>("notes", {.latched = 8});
    for (int i = 0; i < 8; ++i) ASSERT_EQ(publish(Note(std::to_string(i))), PublishStatus::kOk);
    Robot& listener = MakeListener();
    std::atomic<int> taken{0};
    const auto take = [&](const Note&) {
      if (pause.count() > 0) Linger(pause);
      ++taken;
    };
    const auto subscription =
        listener->FromAny<Note>("notes", kSerial, take, {{}, Queue::KeepAll(1), Executor::Dedicated()});
    ASSERT_TRUE(Await([&] { return taken > 0; }));
    talker.session.reset();
    if (kThreadsMayStop && talker.Count(kRestIsLost) == 1) continue;
    EXPECT_TRUE(Await([&] { return taken == 8; })) << taken;
    EXPECT_EQ(talker.Count(kRestIsLost), 0U);
  }
}

TEST_P(SessionEnd, SaysOnceThatASubscriberTakesNothing) {
  Robot& talker = MakeTalker();
  const auto publish = talker->Advertise<Note>("notes", {.latched = 10});
  for (int i = 0; i < 10; ++i) ASSERT_EQ(publish(Note(std::to_string(i))), PublishStatus::kOk);
  Robot& listener = MakeListener();
  Door door;
  std::atomic<bool> came{false};
  const auto hold = [&](const Note&) {
    came = true;
    door.Pass();
  };
  const auto subscription =
      listener->FromAny<Note>("notes", kSerial, hold, {{}, Queue::KeepAll(1), Executor::Dedicated()});
  ASSERT_TRUE(Await([&] { return came && talker->Snapshot().traffic.at(0).out.queued_bytes > 0; }));
  talker.session.reset();
  EXPECT_EQ(talker.Count(kRestIsLost), 1U);
  door.Open();
}

// The callbacks run on threads that receive, so the end of their subscriptions waits for them.
TEST_P(SessionEnd, HoldsUpNoLosslessPublisherWhileCallbacksRun) {
  Robot& talker = MakeTalker();
  Robot& listener = MakeListener();
  Door door;
  std::atomic<int> held{0};
  std::atomic<int> left{0};
  const auto hold = [&](const Note&) {
    ++held;
    door.Pass();
    ++left;
  };
  std::vector<Subscription> subscriptions;
  std::vector<Publisher<Note>> publishers;
  for (const char* channel : {"notes", "others"}) {
    subscriptions.push_back(listener->FromAny<Note>(channel, kSerial, hold, Inline(Queue::KeepAll(1))));
    publishers.push_back(talker->Advertise<Note>(channel));
    ASSERT_TRUE(talker->WaitForSubscribers(channel, 1, kPatience));
    ASSERT_TRUE(Await([&] { return publishers.back()(Note("x")) == PublishStatus::kFull; }));
  }
  ASSERT_TRUE(Await([&] { return held == 2; }));
  std::jthread end([&] { listener.session.reset(); });
  for (const Publisher<Note>& publish : publishers) {
    EXPECT_TRUE(Await([&] { return publish(Note("y")) == PublishStatus::kOk; }));
  }
  EXPECT_EQ(left, 0);
  door.Open();
}

// The talker reaches the listener through a cable that can break. The parameter: whether more is published then.
class SessionEndWithoutConnection : public DomainFixture, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override { ASSERT_TRUE(talker_->WaitForSubscribers("notes", 1, kPatience)); }
  [[nodiscard]] std::uint16_t TalkersPort() const {
    const std::string endpoint = talker_->PublisherEndpoints().at(0);
    return static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1)));
  }
  [[nodiscard]] OutboundStats Out() const { return talker_->Snapshot().traffic.at(0).out; }
  /// The cable breaks while a message is on its way.
  void Break() {
    cable_.Stall();
    ASSERT_EQ(publish_(Note("x")), PublishStatus::kOk);
    ASSERT_TRUE(Await([&] { return Out().sent == 1; }));
    EXPECT_EQ(Out().queued_bytes, 0U);
    cable_.Cut();
    ASSERT_TRUE(Await([&] { return Out().queued_bytes > 0; })) << "It waits to be sent again.";
  }

  Robot talker_{"network: {publisher: {ip: \"tcp://127.0.0.1:*\"}}"};
  conformance::TcpForwarder cable_{TalkersPort()};
  Robot listener_{"network: {subscribers: [{ip: \"tcp://127.0.0.1:" + std::to_string(cable_.port()) +
                  "\"}]}\ndiscovery: {local: false}"};
  Notes notes_;
  const Subscription subscription_ =
      listener_->FromAny<Note>("notes", kSerial, std::ref(notes_), {.queue = Queue::KeepAll(10'000)});
  const Publisher<Note> publish_ = talker_->Advertise<Note>("notes");
};

TEST_P(SessionEndWithoutConnection, SaysOnceThatWhatIsOnItsWayAndTheRestAreLost) {
  ASSERT_NO_FATAL_FAILURE(Break());
  if (GetParam()) {
    const std::uint64_t on_its_way = Out().queued_bytes;
    ASSERT_EQ(publish_(Note("y")), PublishStatus::kOk);
    EXPECT_GT(Out().queued_bytes, on_its_way);
  }
  talker_.session.reset();
  EXPECT_EQ(talker_.Count(kRestIsLost), 1U);
}

INSTANTIATE_TEST_SUITE_P(More, SessionEndWithoutConnection, testing::Bool(),
                         [](const auto& more) { return more.param ? "Waits" : "IsNotThere"; });

}  // namespace
}  // namespace hgros::test
