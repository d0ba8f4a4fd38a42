// Threads of the program that receive messages themselves.
#include "session/domain_fixture.hpp"

namespace hgros::test {
namespace {

constexpr auto kForever = std::chrono::steady_clock::time_point::max();

const NodeOptions kInline{.queue = Queue::KeepAll(1000), .executor = Executor::Inline()};
const NodeOptions kOnWorkers{.queue = Queue::KeepAll(1000)};

class ReceiveHere : public DomainFixture {
 protected:
  Robot sender{""};
  Robot robot{""};
};

TEST_F(ReceiveHere, RunsInlineCallbacksOnThisThreadAndOthersOnWorkers) {
  std::atomic<int> here{0}, elsewhere{0}, on_workers{0}, on_this_thread{0};
  const auto self = std::this_thread::get_id();
  const auto first = robot->FromAny<Note>(
      "near", Invoke::kSerial, [&](const Note&) { ++(std::this_thread::get_id() == self ? here : elsewhere); },
      kInline);
  const auto second = robot->FromAny<Note>(
      "far", Invoke::kSerial,
      [&](const Note&) { ++(std::this_thread::get_id() == self ? on_this_thread : on_workers); }, kOnWorkers);
  const auto near = sender->Advertise<Note>("near");
  const auto far = sender->Advertise<Note>("far");
  ASSERT_TRUE(sender->WaitForSubscribers("near", 1, kPatience));
  ASSERT_TRUE(sender->WaitForSubscribers("far", 1, kPatience));
  // Which thread wakes up first is up to the system, so this goes on until the receiver has received something.
  constexpr int kMessages = 300;
  std::atomic<int> sent{0};
  std::atomic<bool> all_sent{false};
  std::jthread talker([&] {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (sent < kMessages || (here == 0 && std::chrono::steady_clock::now() < deadline)) {
      EXPECT_EQ(near.Wait(std::make_unique<Note>("a"), deadline), PublishStatus::kOk);
      EXPECT_EQ(far.Wait(std::make_unique<Note>("b"), deadline), PublishStatus::kOk);
      if (++sent % 3 == 0) {
        EXPECT_TRUE(Await([&] { return here + elsewhere >= sent; }));
      }
      if (HasFailure()) break;
    }
    all_sent = true;
  });
  const auto all = [&] { return all_sent && here + elsewhere == sent; };
  while (!all() && !HasFailure()) {
    ASSERT_TRUE(robot->ReceiveHere(all, std::chrono::steady_clock::now() + std::chrono::milliseconds(20)));
  }
  talker.join();
  EXPECT_TRUE(Await([&] { return on_workers == sent; }));
  EXPECT_EQ(on_this_thread, 0);
  EXPECT_GT(here, 0);
}

TEST_F(ReceiveHere, LosesNothingWhileThreadsComeAndGo) {
  std::atomic<int> seen{0};
  std::atomic<bool> in_order{true};
  const auto check_order = [&](const Note& note) {
    if (note.text != std::to_string(seen)) in_order = false;
    ++seen;
  };
  const auto subscription = robot->FromAny<Note>("notes", Invoke::kSerial, check_order, kInline);
  const auto publish = sender->Advertise<Note>("notes");
  ASSERT_TRUE(sender->WaitForSubscribers("notes", 1, kPatience));
  constexpr int kMessages = 20'000;
  std::jthread talker([&] {
    for (int i = 0; i < kMessages; ++i) {
      ASSERT_EQ(publish.Wait(std::make_unique<Note>(std::to_string(i)), std::chrono::steady_clock::now() + kPatience),
                PublishStatus::kOk);
      if (i % 100 == 0) {  // Then everybody sleeps.
        EXPECT_TRUE(Await([&] { return seen > i; }));
      }
    }
  });
  std::atomic<bool> over{false};
  std::vector<std::jthread> receivers;
  for (int i = 0; i < 2; ++i) {
    receivers.emplace_back([&, i] {
      while (!over) {
        const int before = seen;
        const bool could = robot->ReceiveHere([&] { return over || seen > before + 10 * i; },
                                              std::chrono::steady_clock::now() + std::chrono::milliseconds(5 + i));
        if (!could) std::this_thread::yield();  // The other one does.
      }
    });
  }
  talker.join();
  EXPECT_TRUE(Await([&] { return seen == kMessages; }));
  EXPECT_TRUE(in_order);
  over = true;
  robot->WakeReceiver();
}

TEST_F(ReceiveHere, ACallbackMayWaitForOthersHoweverManyMessagesFollow) {
  std::atomic<int> seen{0};
  std::atomic<bool> all_sent{false}, found{false};
  const auto meet_another = [&](const Note&) {
    EXPECT_TRUE(Await([&] { return all_sent.load(); }));
    if (++seen != 100) return;
    const Robot late("");  // Meeting another session takes the thread on which this one does errands.
    const auto publish = late->Advertise<Note>("late");
    found = late->WaitForSubscribers("late", 1, kPatience);
  };
  const auto subscription = robot->FromAny<Note>("notes", Invoke::kSerial, meet_another, kInline);
  const auto second = robot->FromAny<Note>(
      "late", Invoke::kSerial, [](const Note&) {}, kInline);
  const auto publish = sender->Advertise<Note>("notes");
  ASSERT_TRUE(sender->WaitForSubscribers("notes", 1, kPatience));
  std::jthread talker([&] {
    for (int i = 0; i < 200; ++i) publish(Note("a"));
    all_sent = true;
  });
  const auto all = [&] { return seen == 200; };
  while (!all()) {
    ASSERT_TRUE(robot->ReceiveHere(all, std::chrono::steady_clock::now() + std::chrono::milliseconds(20)));
  }
  EXPECT_TRUE(found);
}

TEST_F(ReceiveHere, EndsWhenWokenAndAtItsDeadline) {
  const auto subscription = robot->FromAny<Note>(
      "notes", Invoke::kSerial, [](const Note&) {}, kInline);
  const auto publish = sender->Advertise<Note>("notes");
  ASSERT_TRUE(sender->WaitForSubscribers("notes", 1, kPatience));
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(10);
  while (std::chrono::steady_clock::now() < until) ASSERT_TRUE(robot->ReceiveHere([] { return false; }, until));
  std::atomic<bool> done{false}, asked{false};
  std::jthread waker([&] {
    EXPECT_TRUE(Await([&] { return asked.load(); }));
    Linger(std::chrono::milliseconds(10));
    EXPECT_FALSE(robot->ReceiveHere([] { return true; }, kForever));  // Another thread does.
    done = true;
    robot->WakeReceiver();
  });
  while (!done) {
    ASSERT_TRUE(robot->ReceiveHere(
        [&] {
          asked = true;
          return done.load();
        },
        kForever));
  }
}

TEST_F(ReceiveHere, IsRefusedWithoutSharedMemory) {
  Robot isolated("discovery: {local: false}");
  EXPECT_FALSE(isolated->ReceiveHere([] { return true; }, kForever));
  isolated->WakeReceiver();
}

}  // namespace
}  // namespace hgros::test
