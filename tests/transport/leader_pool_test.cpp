#include "transport/leader_pool.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <queue>

#include "conformance/transport_conformance.hpp"
#include "support/await.hpp"

namespace hgros {
namespace {

using conformance::Eventually;

/// Hands out queued tasks; counts leaders.
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

  std::mutex mutex;
  std::condition_variable ready;
  std::queue<LeaderPool::Task> tasks;
  bool woken = false;
  std::atomic<int> leaders{0};
  std::atomic<bool> two_leaders{false};
};

TEST(LeaderPool, RunsEveryTaskOnceWithOneLeaderAtATime) {
  Queue queue;
  LeaderPool pool(queue);
  pool.Start();
  std::atomic<int> ran{0};
  for (int i = 0; i < 2000; ++i) queue.Put([&] { ++ran; });
  EXPECT_TRUE(Eventually([&] { return ran == 2000; }));
  EXPECT_FALSE(queue.two_leaders);
}

TEST(LeaderPool, BlockedTasksDoNotStopTheWaiting) {
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

TEST(LeaderPool, StopWaitsForTasks) {
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

}  // namespace
}  // namespace hgros
