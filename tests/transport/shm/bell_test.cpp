#include "transport/shm/memory/bell.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <csignal>
#include <future>
#include <random>
#include <thread>
#include <vector>

#include "support/await.hpp"
#include "support/seed.hpp"

namespace hgros::shm {
namespace {

using test::Await;

struct Ringer {
  explicit Ringer(const SessionBell& bell, std::uint32_t number) {
    std::string fault;
    peer = PeerBell::Open(*bell.handle(), number, fault);
    EXPECT_NE(peer, nullptr) << fault;
    page = MapForeign(*bell.handle(), sizeof(BellPage), true, fault);
  }
  std::unique_ptr<PeerBell> peer;
  std::shared_ptr<Mapping> page;
};

/// Each ringer rings again only after its last ring was seen. So it stops if one ring is lost.
enum class Visitor { kNone, kLooks, kWaitsFirst };

void RingAndWait(Patience patience, int ringers, int waiters, Visitor visitor) {
  const int rounds = test::Rounds(400, 1500);
  SessionBell bell(patience);
  std::vector<std::atomic<int>> seen(static_cast<std::size_t>(ringers));
  std::atomic<bool> stop{false};
  std::vector<std::jthread> threads;
  for (int i = 0; i < waiters; ++i) {
    threads.emplace_back([&] {
      while (!stop) {
        bell.Wait();
        (void)bell.CollectRings([&](std::uint32_t number) { ++seen[number]; });
      }
      bell.Wake();
    });
  }
  // A visitor looks for a moment from time to time and takes nothing. At the end of its look it wakes a thread that
  // has gone to sleep meanwhile.
  if (visitor == Visitor::kLooks) {
    threads.emplace_back([&] {
      while (!stop) {
        if (bell.BeginLooking()) {
          std::this_thread::yield();
          bell.EndLooking();
        }
        std::this_thread::yield();
      }
    });
  }
  // Another one sleeps, takes what it was woken for, and then lets the others wait for a moment.
  if (visitor == Visitor::kWaitsFirst) {
    threads.emplace_back([&] {
      while (!stop) {
        (void)bell.WaitFirst([&] { return stop.load(); }, std::chrono::steady_clock::time_point::max());
        (void)bell.CollectRings([&](std::uint32_t number) { ++seen[number]; });
        bell.EndLooking();
        std::this_thread::yield();
      }
      bell.Wake();
    });
  }
  std::atomic<int> done{0};
  for (int i = 0; i < ringers; ++i) {
    threads.emplace_back([&, i] {
      const Ringer ringer(bell, static_cast<std::uint32_t>(i));
      std::minstd_rand random(static_cast<unsigned>(i));
      for (int round = 1; round <= rounds && !stop; ++round) {
        ringer.peer->Ring();
        while (seen[static_cast<std::size_t>(i)] < round && !stop) std::this_thread::yield();
        for (auto pause = random() % 300; pause > 0; --pause) std::atomic_signal_fence(std::memory_order_seq_cst);
      }
      ++done;
    });
  }
  EXPECT_TRUE(Await([&] { return done == ringers; }))
      << "a ring was lost: " << ringers << " ringers, " << waiters << " waiters, visitor " << static_cast<int>(visitor)
      << (patience.spin.count() > 0 ? ", spins" : "");
  stop = true;
  bell.Wake();
}

TEST(ShmBell, NoRingIsLostAlsoWhileWaitersSpinOrAVisitorLooksOrWaitsFirst) {
  const Patience sleeps{};
  const Patience spins{.busy = false, .spin = std::chrono::microseconds(5)};
  for (const int ringers : {1, 2, 5}) {
    for (const int waiters : {1, 2, 3}) RingAndWait(sleeps, ringers, waiters, Visitor::kNone);
  }
  for (const int waiters : {1, 2, 3}) RingAndWait(spins, 2, waiters, Visitor::kNone);
  for (const int waiters : {1, 2}) {
    for (const Patience patience : {sleeps, spins}) RingAndWait(patience, 2, waiters, Visitor::kLooks);
  }
  for (const int ringers : {1, 3}) {
    for (const int waiters : {0, 1, 2}) RingAndWait(sleeps, ringers, waiters, Visitor::kWaitsFirst);
  }
}

/// A thread that waits and counts.
struct Waiter {
  explicit Waiter(SessionBell& waits_for) : bell(waits_for) {}
  ~Waiter() {
    stop = true;
    bell.Wake();
  }
  SessionBell& bell;
  std::atomic<int> seen{0};
  std::atomic<bool> stop{false};
  std::jthread thread{[this] {
    while (!stop) {
      bell.Wait();
      (void)bell.CollectRings([&](std::uint32_t) { ++seen; });
    }
  }};
};

constexpr auto kForever = std::chrono::steady_clock::time_point::max();

TEST(ShmBell, ARingWakesTheThreadThatWaitsFirstAndNoOther) {
  SessionBell bell({});
  std::atomic<int> others{0}, first{0};
  std::atomic<bool> stop{false};
  std::vector<std::jthread> threads;
  for (int i = 0; i < 2; ++i) {
    threads.emplace_back([&] {
      while (!stop) {
        bell.Wait();
        if (bell.CollectRings([](std::uint32_t) {})) ++others;
      }
      bell.Wake();
    });
  }
  threads.emplace_back([&] {
    while (!stop) {
      (void)bell.WaitFirst([&] { return stop.load(); }, kForever);
      if (bell.CollectRings([](std::uint32_t) {})) ++first;
    }
    bell.Wake();  // What was for the others may have woken this one.
  });
  const Ringer ringer(bell, 1);
  for (int round = 1; round <= 200; ++round) {
    test::Linger(std::chrono::milliseconds(1));  // All sleep by then, if the machine is not busy.
    ringer.peer->Ring();
    ASSERT_TRUE(Await([&] { return first + others == round; })) << round;
  }
  EXPECT_GT(first, others);
  stop = true;
  bell.WakeFirst();
  bell.Wake();
}

TEST(ShmBell, WaitingFirstEndsByWakeFirstAtItsTimeAndAfterASignal) {
  SessionBell bell({});
  EXPECT_TRUE(bell.WaitFirst([] { return true; }, kForever));
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(5);
  EXPECT_TRUE(bell.WaitFirst([] { return false; }, until));
  EXPECT_GE(std::chrono::steady_clock::now(), until);
  EXPECT_TRUE(bell.WaitFirst([] { return false; }, std::chrono::steady_clock::now() - std::chrono::seconds(1)));

  std::atomic<bool> ends{false}, undisturbed{false};
  std::jthread waiter([&] {
    while (!ends) undisturbed = bell.WaitFirst([&] { return ends.load(); }, kForever);
  });
  test::Linger(std::chrono::milliseconds(20));
  ends = true;
  bell.WakeFirst();
  waiter.join();
  EXPECT_TRUE(undisturbed);

  struct sigaction action {};
  struct sigaction old {};
  action.sa_handler = [](int) {};
  sigaction(SIGUSR1, &action, &old);
  std::atomic<bool> disturbed{false};
  waiter = std::jthread([&] {
    while (!disturbed) disturbed = !bell.WaitFirst([] { return false; }, kForever);
  });
  EXPECT_TRUE(Await([&] {
    pthread_kill(waiter.native_handle(), SIGUSR1);
    return disturbed.load();
  }));
  waiter.join();
  sigaction(SIGUSR1, &old, nullptr);
}

TEST(ShmBell, NextRingWakesTheSleeperIfAPeerDiedBeforeItsWakeUp) {
  SessionBell bell({});
  const Waiter waiter(bell);
  const Ringer living(bell, 1);
  auto& page = living.page->as<BellPage>();
  for (int step = 0; step < 50; ++step) {
    ASSERT_TRUE(Await([&] { return (page.asleep.load() & 1) != 0; }));
    // A peer does this before it wakes a thread; then it is killed.
    page.ready[0].fetch_or(4);
    page.asleep.fetch_add(2);
    const int before = waiter.seen;
    living.peer->Ring();
    ASSERT_TRUE(Await([&] { return waiter.seen >= before + 2; })) << step;
  }
}

TEST(ShmBell, MendRepairsAPageThatAPeerHasDamaged) {
  SessionBell bell({});
  const Waiter waiter(bell);
  const Ringer liar(bell, 1);
  auto& page = liar.page->as<BellPage>();
  ASSERT_TRUE(Await([&] { return (page.asleep.load() & 1) != 0; }));
  page.asleep.fetch_and(~1u);
  page.magic = 0;
  bell.Ring(7);
  bell.Mend();
  EXPECT_TRUE(Await([&] { return waiter.seen == 1; }));
  std::string fault;
  EXPECT_NE(PeerBell::Open(*bell.handle(), 2, fault), nullptr) << fault;
}

TEST(ShmBell, PassOnWakesAnotherWaiterForARing) {
  for (const Patience patience : {Patience{}, Patience{.busy = false, .spin = std::chrono::microseconds(5)}}) {
    SessionBell bell(patience);
    std::atomic<bool> waiting{false};
    for (int round = 0; round < 200; ++round) {
      auto other = std::async(std::launch::async, [&] {
        waiting = true;
        bell.Wait();
      });
      ASSERT_TRUE(Await([&] { return waiting.load(); }));
      bell.Ring(3);
      bell.PassOn();
      const bool woken = other.wait_for(test::kPatience) == std::future_status::ready;
      if (!woken) bell.Wake();
      ASSERT_TRUE(woken);
      waiting = false;
      ASSERT_TRUE(bell.CollectRings([](std::uint32_t number) { EXPECT_EQ(number, 3u); }));
    }
  }
}

TEST(ShmBell, EachWakeUpEndsOneWait) {
  SessionBell bell({});
  std::atomic<int> ended{0};
  std::vector<std::jthread> waiters;
  for (int i = 0; i < 3; ++i) {
    waiters.emplace_back([&] {
      bell.Wait();
      ++ended;
      bell.Wake();  // Each thread that ends wakes the next one.
    });
  }
  bell.Wake();
  EXPECT_TRUE(Await([&] { return ended == 3; }));
}

TEST(ShmBell, RefusesPeerNumbersBeyondItsBits) {
  SessionBell bell({});
  std::string fault;
  EXPECT_NE(PeerBell::Open(*bell.handle(), kMaxPeers - 1, fault), nullptr);
  EXPECT_EQ(PeerBell::Open(*bell.handle(), kMaxPeers, fault), nullptr);
  EXPECT_NE(fault.find("1024"), std::string::npos) << fault;
}

}  // namespace
}  // namespace hgros::shm
