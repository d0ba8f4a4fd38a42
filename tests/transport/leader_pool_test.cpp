#include "transport/leader_pool.hpp"

#include <gtest/gtest.h>

#include <queue>

#include "conformance/transport_conformance.hpp"
#include "support/await.hpp"

namespace hgros {
namespace {

using conformance::Eventually;

/// Returns queued tasks one by one, and notes if there are two leaders at once.
class Queue : public LeaderPool::Input {
 public:
  void Wait() noexcept override {
    std::unique_lock lock(mutex);
    ++waiting;
    ready.wait(lock, [this] { return woken || !tasks.empty(); });
    --waiting;
    woken = false;
  }
  LeaderPool::Task Lead() noexcept override {
    if (++leaders > 1) two_leaders = true;
    LeaderPool::Task task;
    {
      const std::scoped_lock lock(mutex);
      if (!tasks.empty()) {
        task = std::move(tasks.front());
        tasks.pop();
      }
    }
    --leaders;
    return task;
  }
  void Wake() noexcept override {
    {
      const std::scoped_lock lock(mutex);
      woken = true;
    }
    ready.notify_one();
  }
  void Put(LeaderPool::Task task) {
    {
      const std::scoped_lock lock(mutex);
      tasks.push(std::move(task));
    }
    ready.notify_one();
  }

  mutable std::mutex mutex;
  std::condition_variable ready;
  std::queue<LeaderPool::Task> tasks;
  bool woken = false;
  std::atomic<int> waiting{0};
  std::atomic<int> leaders{0};
  std::atomic<bool> two_leaders{false};
};

/// A queue that a visitor can read, and that wakes no thread when a task comes.
class SilentQueue : public Queue {
 public:
  bool BeginAsking() noexcept override { return askable; }
  [[nodiscard]] bool MayRead() const noexcept override {
    const std::scoped_lock lock(mutex);
    return !tasks.empty();
  }
  void EndAsking() noexcept override { ++ended; }
  void PutSilently(LeaderPool::Task task) {
    const std::scoped_lock lock(mutex);
    tasks.push(std::move(task));
  }

  std::atomic<bool> askable{true};
  std::atomic<int> ended{0};
};

/// A queue for which one thread can wait first.
class QueueForFirst : public SilentQueue {
 public:
  [[nodiscard]] bool CanWaitFirst() const noexcept override { return can; }
  bool WaitFirst(const std::function<bool()>& ends, std::chrono::steady_clock::time_point until) noexcept override {
    std::unique_lock lock(mutex);
    while (tasks.empty() && !woken && !disturbed) {
      looks_again = false;
      lock.unlock();
      const bool over = ends();
      lock.lock();
      if (over) return true;
      const auto has_something = [this] { return !tasks.empty() || woken || disturbed || looks_again; };
      if (!first.wait_until(lock, until, has_something)) return true;
    }
    woken = false;
    return !disturbed.exchange(false);
  }
  void WakeFirst() noexcept override {
    const std::scoped_lock lock(mutex);
    looks_again = true;
    first.notify_all();
  }
  void PutForFirst(LeaderPool::Task task) {
    PutSilently(std::move(task));
    first.notify_all();
  }
  void Disturb() {
    const std::scoped_lock lock(mutex);
    disturbed = true;
    first.notify_all();
  }

  std::atomic<bool> can{true};
  std::atomic<bool> disturbed{false};
  bool looks_again = false;
  std::condition_variable first;
};

/// A pool that has started.
struct Pool : LeaderPool {
  explicit Pool(Input& input) : LeaderPool(input) { Start(); }
};

// Far beyond the time that a test may take: it hangs if nothing ends the visit.
std::chrono::steady_clock::time_point Never() { return std::chrono::steady_clock::now() + std::chrono::hours(1); }

TEST(LeaderPool, RunsEveryTaskOnceWithOneLeaderAtATime) {
  Queue queue;
  Pool pool(queue);
  std::atomic<int> ran{0};
  for (int i = 0; i < 2000; ++i) queue.Put([&] { ++ran; });
  EXPECT_TRUE(Eventually([&] { return ran == 2000; }));
  EXPECT_FALSE(queue.two_leaders);
}

TEST(LeaderPool, RunsFurtherTasksWhileOthersBlock) {
  Queue queue;
  test::Door door;
  Pool pool(queue);
  std::atomic<int> blocked{0}, ran{0};
  for (int i = 0; i < 8; ++i) {
    queue.Put([&] {
      ++blocked;
      door.Pass();
    });
  }
  queue.Put([&] { ++ran; });
  EXPECT_TRUE(Eventually([&] { return ran == 1 && blocked == 8; }));
  EXPECT_GE(pool.thread_count(), 9u);
  door.Open();
}

TEST(LeaderPool, StopWaitsForRunningTasks) {
  Queue queue;
  std::atomic<bool> started{false}, ended{false};
  {
    Pool pool(queue);
    queue.Put([&] {
      started = true;
      test::Linger(std::chrono::milliseconds(20));
      ended = true;
    });
    ASSERT_TRUE(Eventually([&] { return started.load(); }));
  }
  EXPECT_TRUE(ended);
}

TEST(LeaderPool, MayBeDestroyedByItsOwnTask) {
  Queue queue;
  auto pool = std::make_unique<Pool>(queue);
  std::atomic<bool> destroyed{false};
  queue.Put([&] {
    pool.reset();
    destroyed = true;
  });
  EXPECT_TRUE(Eventually([&] { return destroyed.load(); }));
}

TEST(LeaderPool, VisitorReadsTasksAndPoolThreadsRunThem) {
  SilentQueue queue;
  Pool pool(queue);
  std::atomic<int> ran{0};
  std::atomic<bool> ran_here{false};
  const auto visitor = std::this_thread::get_id();
  for (int i = 0; i < 100; ++i) {
    queue.PutSilently([&] {
      if (std::this_thread::get_id() == visitor || Transport::IsVisitor()) ran_here = true;
      ++ran;
    });
  }
  bool knows = false;
  const auto all_ran = [&] {
    knows = Transport::IsVisitor();
    return ran == 100;
  };
  pool.Receive({.done = all_ran, .until = Never()});
  EXPECT_EQ(ran, 100);
  EXPECT_TRUE(knows);
  EXPECT_FALSE(Transport::IsVisitor());
  EXPECT_FALSE(ran_here);
  EXPECT_FALSE(queue.two_leaders);
  EXPECT_EQ(queue.ended, 1);
}

TEST(LeaderPool, TasksReadByAVisitorRunWhileOthersBlock) {
  SilentQueue queue;
  test::Door door;
  Pool pool(queue);
  std::atomic<int> blocked{0};
  std::atomic<bool> ran{false};
  for (int i = 0; i < 4; ++i) {
    queue.PutSilently([&] {
      ++blocked;
      door.Pass();
    });
  }
  queue.PutSilently([&] { ran = true; });
  pool.Receive({.done = [&] { return ran && blocked == 4; }, .until = Never()});
  EXPECT_TRUE(ran);
  EXPECT_EQ(blocked, 4);
  door.Open();
}

TEST(LeaderPool, VisitEndsAtItsDeadline) {
  SilentQueue queue;
  Pool pool(queue);
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(2);
  pool.Receive({.done = [] { return false; }, .until = until});
  EXPECT_GE(std::chrono::steady_clock::now(), until);
  queue.askable = false;
  pool.Receive({.done = [] { return false; }, .until = Never()});  // Returns at once: visitors cannot read.
  EXPECT_EQ(queue.ended, 1);
}

TEST(LeaderPool, HasOneVisitorAtATimeAndStopWaitsForIt) {
  SilentQueue queue;
  auto pool = std::make_unique<Pool>(queue);
  std::atomic<bool> inside{false}, leave{false};
  std::jthread visitor([&] {
    const auto told_to_leave = [&] {
      inside = true;
      return leave.load();
    };
    pool->Receive({.done = told_to_leave, .until = Never()});
  });
  ASSERT_TRUE(Eventually([&] { return inside.load(); }));
  pool->Receive({.done = [] { return false; }, .until = Never()});  // Returns at once: there already is a visitor.
  EXPECT_EQ(queue.ended, 0);
  std::atomic<bool> stopped{false};
  std::jthread stopping([&] {
    pool->Stop();
    stopped = true;
  });
  test::Linger(std::chrono::milliseconds(20));
  EXPECT_FALSE(stopped);
  leave = true;
  EXPECT_TRUE(Eventually([&] { return stopped.load(); }));
  EXPECT_EQ(queue.ended, 1);
  pool->Receive({.done = [] { return false; }, .until = Never()});  // Returns at once: the pool has stopped.
}

TEST(LeaderPool, AThreadThatReceivesHereRunsTheTasksThatItReads) {
  QueueForFirst queue;
  Pool pool(queue);
  ASSERT_TRUE(Eventually([&] { return queue.waiting == 2; }));
  std::atomic<int> ran{0}, elsewhere{0};
  std::atomic<bool> received{false};
  std::jthread receiver([&] { received = pool.ReceiveHere({.done = [&] { return ran == 500; }, .until = Never()}); });
  for (int i = 1; i <= 500; ++i) {
    queue.PutForFirst([&] {
      if (std::this_thread::get_id() != receiver.get_id()) ++elsewhere;
      if (Transport::IsVisitor()) ++elsewhere;
      ++ran;
    });
    if (i % 2 == 0) {
      EXPECT_TRUE(Eventually([&] { return ran >= i; }));
    }
  }
  receiver.join();
  EXPECT_TRUE(received);
  EXPECT_EQ(ran, 500);
  EXPECT_EQ(elsewhere, 0);
  EXPECT_FALSE(queue.two_leaders);
  EXPECT_EQ(queue.ended, 1);
}

TEST(LeaderPool, ATaskOfReceivingHereMayLeaveTheRestToAnotherThread) {
  EXPECT_FALSE(Transport::LeaveRest());
  QueueForFirst queue;
  Pool pool(queue);
  ASSERT_TRUE(Eventually([&] { return queue.waiting == 2; }));
  std::atomic<int> here{0}, elsewhere{0};
  std::atomic<bool> received{false};
  const auto is_left = [&] { return elsewhere > 0; };
  std::jthread receiver([&] { received = pool.ReceiveHere({.done = is_left, .until = Never()}); });
  queue.PutForFirst([&] {
    if (Transport::LeaveRest()) {
      EXPECT_TRUE(LeaderPool::LeftRest());
      ++here;
    } else {
      EXPECT_FALSE(LeaderPool::LeftRest());
      ++elsewhere;
      pool.WakeReceiver();
    }
  });
  receiver.join();
  EXPECT_TRUE(received);
  EXPECT_GE(here, 1);
  EXPECT_EQ(elsewhere, 1);
}

TEST(LeaderPool, ReceivingHereEndsAtItsDeadlineWhenWokenAndAfterASignal) {
  QueueForFirst queue;
  Pool pool(queue);
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(2);
  EXPECT_TRUE(pool.ReceiveHere({.done = [] { return false; }, .until = until}));
  EXPECT_GE(std::chrono::steady_clock::now(), until);
  EXPECT_TRUE(pool.ReceiveHere({.done = [] { return true; }, .until = Never()}));

  std::atomic<int> ended{0};
  std::atomic<bool> done{false}, inside{false};
  const auto receive = [&] {
    const auto is_done = [&] {
      inside = true;
      return done.load();
    };
    EXPECT_TRUE(pool.ReceiveHere({.done = is_done, .until = Never()}));
    ++ended;
  };
  std::jthread woken(receive);
  ASSERT_TRUE(Eventually([&] { return inside.load(); }));
  EXPECT_FALSE(pool.ReceiveHere({.done = [] { return false; }, .until = Never()}));  // Another thread does.
  done = true;
  pool.WakeReceiver();
  EXPECT_TRUE(Eventually([&] { return ended == 1; }));
  woken.join();
  done = false;
  std::jthread disturbed(receive);
  queue.Disturb();
  EXPECT_TRUE(Eventually([&] { return ended == 2; }));
  queue.can = false;
  EXPECT_FALSE(pool.ReceiveHere({.done = [] { return false; }, .until = Never()}));
}

TEST(LeaderPool, StopEndsReceivingHereAlsoInItsOwnTask) {
  for (const bool in_task : {false, true}) {
    QueueForFirst queue;
    auto pool = std::make_unique<Pool>(queue);
    std::atomic<bool> inside{false}, ended{false};
    std::jthread receiver([&] {
      const auto never = [&] {
        inside = true;
        return false;
      };
      EXPECT_TRUE(pool->ReceiveHere({.done = never, .until = Never()}));
      ended = true;
    });
    ASSERT_TRUE(Eventually([&] { return inside.load(); }));
    if (in_task) {
      queue.PutForFirst([&] { pool->Stop(); });
    } else {
      pool->Stop();
      EXPECT_TRUE(ended || Eventually([&] { return ended.load(); }));
    }
    EXPECT_TRUE(Eventually([&] { return ended.load(); }));
    EXPECT_FALSE(pool->ReceiveHere({.done = [] { return false; }, .until = Never()}));
    receiver.join();
  }
}

TEST(LeaderPool, AThreadThatReceivesHereRunsWhatAVisitorHasHandedOver) {
  QueueForFirst queue;
  test::Door door;
  Pool pool(queue);
  std::atomic<int> ran{0};
  for (int i = 0; i < 2; ++i) {
    queue.Put([&] {
      ++ran;
      door.Pass();
    });
  }
  ASSERT_TRUE(Eventually([&] { return ran == 2; }));  // Both threads that the pool had are busy.
  for (int i = 0; i < 48; ++i) {
    queue.PutSilently([&] {
      ++ran;
      pool.WakeReceiver();  // It may run on a thread of the pool.
    });
  }
  std::atomic<int> seen{0};
  pool.Receive({.done = [&] { return ++seen > 60; }, .until = Never()});
  EXPECT_TRUE(pool.ReceiveHere({.done = [&] { return ran == 50; }, .until = Never()}));
  EXPECT_EQ(ran, 50);
  door.Open();
}

/// A queue whose reading can be held up.
class HeldUpQueue : public QueueForFirst {
 public:
  LeaderPool::Task Lead() noexcept override {
    if (holds_up.exchange(false)) {
      held_up = true;
      door.Pass();
    }
    return QueueForFirst::Lead();
  }

  std::atomic<bool> holds_up{false};
  std::atomic<bool> held_up{false};
  test::Door door;
};

TEST(LeaderPool, AThreadThatReceivesHereHasItsTurnAfterTheLastThreadOfThePool) {
  HeldUpQueue queue;
  test::Door busy;
  Pool pool(queue);
  ASSERT_TRUE(Eventually([&] { return queue.waiting == 2; }));
  std::atomic<bool> began{false};
  queue.Put([&] {
    began = true;
    busy.Pass();
  });
  ASSERT_TRUE(Eventually([&] { return began && queue.waiting == 1; }));
  queue.holds_up = true;
  queue.Wake();  // The other thread of the pool leads now.
  ASSERT_TRUE(Eventually([&] { return queue.held_up.load(); }));
  std::atomic<bool> done{false}, ended{false};
  queue.Wake();  // There is input, so the next thread waits for its turn.
  std::jthread receiver([&] {
    EXPECT_TRUE(pool.ReceiveHere({.done = [&] { return done.load(); }, .until = Never()}));
    ended = true;
  });
  test::Linger(std::chrono::milliseconds(20));  // It does by then.
  queue.door.Open();
  test::Linger(std::chrono::milliseconds(20));
  done = true;
  pool.WakeReceiver();
  EXPECT_TRUE(Eventually([&] { return ended.load(); }));
  busy.Open();
  receiver.join();
}

}  // namespace
}  // namespace hgros
