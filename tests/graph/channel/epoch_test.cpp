#include "graph/channel/epoch.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "support/await.hpp"

namespace hgros {
namespace {

TEST(Epoch, KeepsARetiredObjectUntilItsReadersHaveLeft) {
  auto object = std::make_shared<const int>(1);
  const std::weak_ptr<const int> watch = object;
  {
    const epoch::Guard guard;
    epoch::Retire(std::move(object));
    EXPECT_FALSE(watch.expired());
  }
  epoch::Collect();
  EXPECT_TRUE(watch.expired());
}

TEST(Epoch, NestedGuardsCountAsOne) {
  auto object = std::make_shared<const int>(1);
  const std::weak_ptr<const int> watch = object;
  {
    const epoch::Guard outer;
    { const epoch::Guard inner; }
    epoch::Retire(std::move(object));
    EXPECT_FALSE(watch.expired());
  }
  epoch::Collect();
  EXPECT_TRUE(watch.expired());
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
}  // namespace hgros
