// What becomes of messages that were published just before their session ends.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "conformance/tcp_forwarder.hpp"
#include "session/domain_fixture.hpp"

namespace hgros {
namespace {

using test::Await;
using test::kPatience;
using test::kSerial;
using test::Note;
using test::Notes;
using test::Robot;

constexpr const char* kRestIsLost = "a lossless subscriber of channel \"notes\" does not take its messages";

// With its first report, also of a suppressed race, ThreadSanitizer reads the symbols of the program. That stops a
// thread for longer than a session waits for a subscriber. Then the session may give up, but never without a word.
#ifdef __SANITIZE_THREAD__
constexpr bool kThreadsMayStop = true;
#else
constexpr bool kThreadsMayStop = false;
#endif

class SessionEnd : public test::DomainFixture, public testing::WithParamInterface<std::string> {
 protected:
  [[nodiscard]] std::unique_ptr<Robot> MakeTalker() const {
    if (GetParam() == "SharedMemory") return std::make_unique<Robot>("");
    const std::string endpoint = GetParam() == "Tcp" ? "tcp://127.0.0.1:*" : bus_.Endpoint("talker");
    return std::make_unique<Robot>("network: {publisher: {ip: \"" + endpoint + "\"}}\n" + kAlone);
  }
  [[nodiscard]] std::unique_ptr<Robot> MakeListener(Robot& talker) const {
    if (GetParam() == "SharedMemory") return std::make_unique<Robot>("");
    const std::string endpoint = talker->PublisherEndpoints().at(0);
    return std::make_unique<Robot>("network: {subscribers: [{ip: \"" + endpoint + "\"}]}\n" + kAlone);
  }

 private:
  static constexpr const char* kAlone = "discovery: {local: false}\n";
  const test::Bus bus_;
};

INSTANTIATE_TEST_SUITE_P(Transports, SessionEnd, testing::Values("SharedMemory", "Ipc", "Tcp"),
                         [](const auto& one) { return one.param; });

TEST_P(SessionEnd, LosslessSubscribersGetWhatWasPublishedJustBefore) {
  for (int round = 0; round < 40; ++round) {
    auto talker = MakeTalker();
    const auto listener = MakeListener(*talker);
    Notes notes;
    const auto subscription =
        (*listener)->FromAny<Note>("notes", kSerial, std::ref(notes), {.queue = Queue::KeepAll(1000)});
    (void)(*talker)->Advertise<Note>("notes");
    ASSERT_TRUE((*talker)->WaitForSubscribers("notes", 1, kPatience));
    for (int i = 0; i < 100; ++i) ASSERT_EQ((*talker)->ToAny("notes", Note(std::to_string(i))), PublishStatus::kOk);
    talker.reset();
    ASSERT_TRUE(Await([&] { return notes.size() == 100; })) << "round " << round << ": " << notes.size();
  }
}

// Latched messages wait for the credit of a new subscriber, here for each one.
TEST_P(SessionEnd, WaitsForTheCreditOfASubscriber) {
  const auto talker = MakeTalker();
  const auto publish = (*talker)->Advertise<Note>("notes", {.latched = 10});
  for (int i = 0; i < 10; ++i) ASSERT_EQ(publish(Note(std::to_string(i))), PublishStatus::kOk);
  const auto listener = MakeListener(*talker);
  Notes notes;
  const auto subscription = (*listener)->FromAny<Note>("notes", kSerial, std::ref(notes), {.queue = Queue::KeepAll(1)});
  ASSERT_TRUE(Await([&] { return notes.size() > 0; }));
  talker->session.reset();
  if (kThreadsMayStop && talker->Count(kRestIsLost) == 1) return;
  EXPECT_TRUE(Await([&] { return notes.size() == 10; })) << notes.size();
  EXPECT_EQ(talker->Count(kRestIsLost), 0U);
}

TEST_P(SessionEnd, WaitsForASlowSubscriberWhileItTakesMessages) {
  const auto talker = MakeTalker();
  const auto publish = (*talker)->Advertise<Note>("notes", {.latched = 10});
  for (int i = 0; i < 10; ++i) ASSERT_EQ(publish(Note(std::to_string(i))), PublishStatus::kOk);
  const auto listener = MakeListener(*talker);
  std::atomic<int> taken{0};
  const auto take = [&](const Note&) {
    test::Linger(std::chrono::milliseconds(150));
    ++taken;
  };
  const auto subscription =
      (*listener)->FromAny<Note>("notes", kSerial, take, {{}, Queue::KeepAll(1), Executor::Dedicated()});
  ASSERT_TRUE(Await([&] { return taken > 0; }));
  talker->session.reset();
  if (kThreadsMayStop && talker->Count(kRestIsLost) == 1) return;
  EXPECT_TRUE(Await([&] { return taken == 10; })) << taken;
  EXPECT_EQ(talker->Count(kRestIsLost), 0U);
}

TEST_P(SessionEnd, SaysOnceThatASubscriberTakesNothing) {
  const auto talker = MakeTalker();
  const auto publish = (*talker)->Advertise<Note>("notes", {.latched = 10});
  for (int i = 0; i < 10; ++i) ASSERT_EQ(publish(Note(std::to_string(i))), PublishStatus::kOk);
  const auto listener = MakeListener(*talker);
  test::Door door;
  std::atomic<bool> came{false};
  const auto hold = [&](const Note&) {
    came = true;
    door.Pass();
  };
  const auto subscription =
      (*listener)->FromAny<Note>("notes", kSerial, hold, {{}, Queue::KeepAll(1), Executor::Dedicated()});
  ASSERT_TRUE(Await([&] { return came && (*talker)->Snapshot().traffic.at(0).out.queued_bytes > 0; }));
  talker->session.reset();
  EXPECT_EQ(talker->Count(kRestIsLost), 1U);
  door.Open();
}

// The talker reaches the listener through a cable that can break.
class SessionEndWithoutConnection : public test::DomainFixture {
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

TEST_F(SessionEndWithoutConnection, SaysThatAMessageOnItsWayIsLost) {
  ASSERT_NO_FATAL_FAILURE(Break());
  talker_.session.reset();
  EXPECT_EQ(talker_.Count(kRestIsLost), 1U);
}

TEST_F(SessionEndWithoutConnection, SaysOnceThatTheRestIsLost) {
  ASSERT_NO_FATAL_FAILURE(Break());
  const std::uint64_t on_its_way = Out().queued_bytes;
  ASSERT_EQ(publish_(Note("y")), PublishStatus::kOk);
  EXPECT_GT(Out().queued_bytes, on_its_way);
  talker_.session.reset();
  EXPECT_EQ(talker_.Count(kRestIsLost), 1U);
}

}  // namespace
}  // namespace hgros
