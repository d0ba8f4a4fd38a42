#include "transport/leader_pool.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <queue>
#include <thread>

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
    ready.wait(lock, [this] { return woken || !tasks.empty(); });
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

std::chrono::steady_clock::time_point Never() { return std::chrono::steady_clock::now() + test::kPatience; }

TEST(LeaderPool, RunsEveryTaskOnceWithOneLeaderAtATime) {
  Queue queue;
  LeaderPool pool(queue);
  pool.Start();
  std::atomic<int> ran{0};
  for (int i = 0; i < 2000; ++i) queue.Put([&] { ++ran; });
  EXPECT_TRUE(Eventually([&] { return ran == 2000; }));
  EXPECT_FALSE(queue.two_leaders);
}

TEST(LeaderPool, RunsFurtherTasksWhileOthersBlock) {
  Queue queue;
  LeaderPool pool(queue);
  pool.Start();
  std::mutex mutex;
  std::condition_variable go;
  bool open = false;
  std::atomic<int> blocked{0}, ran{0};
  for (int i = 0; i < 8; ++i) {
    queue.Put([&] {
      std::unique_lock lock(mutex);
      ++blocked;
      go.wait(lock, [&] { return open; });
    });
  }
  queue.Put([&] { ++ran; });
  EXPECT_TRUE(Eventually([&] { return ran == 1 && blocked == 8; }));
  EXPECT_GE(pool.thread_count(), 9u);
  {
    const std::scoped_lock lock(mutex);
    open = true;
  }
  go.notify_all();
}

TEST(LeaderPool, StopWaitsForRunningTasks) {
  Queue queue;
  std::atomic<bool> started{false}, ended{false};
  {
    LeaderPool pool(queue);
    pool.Start();
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
  auto pool = std::make_unique<LeaderPool>(queue);
  pool->Start();
  std::atomic<bool> destroyed{false};
  queue.Put([&] {
    pool.reset();
    destroyed = true;
  });
  EXPECT_TRUE(Eventually([&] { return destroyed.load(); }));
}

TEST(LeaderPool, VisitorReadsTasksAndPoolThreadsRunThem) {
  SilentQueue queue;
  LeaderPool pool(queue);
  pool.Start();
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
  LeaderPool pool(queue);
  pool.Start();
  test::Door door;
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
  LeaderPool pool(queue);
  pool.Start();
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(2);
  pool.Receive({.done = [] { return false; }, .until = until});
  EXPECT_GE(std::chrono::steady_clock::now(), until);
  queue.askable = false;
  pool.Receive({.done = [] { return false; }, .until = Never()});  // Returns at once: visitors cannot read.
  EXPECT_EQ(queue.ended, 1);
}

TEST(LeaderPool, HasOneVisitorAtATimeAndStopWaitsForIt) {
  SilentQueue queue;
  auto pool = std::make_unique<LeaderPool>(queue);
  pool->Start();
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

}  // namespace
}  // namespace hgros
