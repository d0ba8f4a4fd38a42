#include "graph/channel/epoch.hpp"

#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "support/await.hpp"

namespace hgros::test {
namespace {

TEST(Epoch, KeepsARetiredObjectUntilItsReadersHaveLeftOfWhichNestedOnesCountAsOne) {
  for (const bool nested : {false, true}) {
    auto object = std::make_shared<const int>(1);
    const std::weak_ptr<const int> watch = object;
    {
      const epoch::Guard outer;
      if (nested) const epoch::Guard inner;
      epoch::Retire(std::move(object));
      EXPECT_FALSE(watch.expired());
    }
    epoch::Collect();
    EXPECT_TRUE(watch.expired());
  }
}

// Destructors of thread-local and static objects may publish after the library's own thread-local objects have ended.
TEST(Epoch, AThreadThatEndsSharesItsReaderWithNoOther) {
  struct Late {
    ~Late() {
      Await([this] { return others->load(); });
      {
        const epoch::Guard guard;
        reader->store(&epoch::ThisThread());
        Await([this] { return !others->load(); });
      }
      const epoch::Guard again;  // It has given the first one back.
    }
    std::atomic<const epoch::Reader*>* reader = nullptr;
    std::atomic<bool>* others = nullptr;
  };
  std::atomic<const epoch::Reader*> late{nullptr};
  std::atomic<bool> others{false};
  std::jthread ending([&] {
    thread_local Late last;  // Constructed first, and so destroyed last.
    last.reader = &late;
    last.others = &others;
    (void)epoch::ThisThread();
  });
  std::vector<const epoch::Reader*> readers;
  others = true;
  ASSERT_TRUE(Await([&] { return late.load() != nullptr; }));
  for (int i = 0; i < 8; ++i) {
    std::jthread([&] { readers.push_back(&epoch::ThisThread()); }).join();
    EXPECT_NE(readers.back(), late.load());
  }
  others = false;
}

TEST(Epoch, ManyThreadsThatReadWhileTheyEndNeedFewReaders) {
  struct Late {
    ~Late() {
      const epoch::Guard guard;
      used->insert(&epoch::ThisThread());
    }
    std::set<const epoch::Reader*>* used = nullptr;
  };
  std::set<const epoch::Reader*> used;
  for (int i = 0; i < 50; ++i) {
    std::jthread([&] {
      thread_local Late last;
      last.used = &used;
      const epoch::Guard guard;
    }).join();
  }
  EXPECT_LE(used.size(), 2U);
}

TEST(Epoch, ReadersNeverSeeAFreedObject) {
  struct Value {
    explicit Value(int number) : first(number), second(number) {}
    ~Value() { first = -1; }
    std::atomic<int> first;
    int second;
  };
  for (const int threads : {1, 2, 3, 7, 16}) {
    auto current = std::make_shared<const Value>(0);
    std::atomic<const Value*> shown{current.get()};
    std::atomic<bool> stop{false};
    std::atomic<int> bad{0};
    std::vector<std::jthread> readers;
    for (int i = 0; i < threads; ++i) {
      readers.emplace_back([&] {
        while (!stop) {
          const epoch::Guard guard;
          const Value* value = shown.load(std::memory_order_seq_cst);
          if (value->first != value->second) ++bad;
        }
      });
    }
    for (int i = 1; i < 500; ++i) {
      auto next = std::make_shared<const Value>(i);
      shown.store(next.get(), std::memory_order_seq_cst);
      current.swap(next);
      epoch::Retire(std::move(next));
    }
    stop = true;
    readers.clear();
    EXPECT_EQ(bad, 0) << threads << " readers";
  }
  epoch::Collect();
}

}  // namespace
}  // namespace hgros::test
