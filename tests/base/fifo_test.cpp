#include "hgros/base/fifo.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <random>

namespace hgros {
namespace {

TEST(Fifo, AgreesWithADequeUnderRandomOperations) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    Fifo<std::shared_ptr<int>> fifo;
    std::deque<int> model;
    for (int i = 0; i < 20'000; ++i) {
      // The queue grows and shrinks in long phases.
      const bool put = random() % 100 < ((i / 1000) % 2 == 0 ? 60U : 40U);
      if (put) {
        fifo.Put(std::make_shared<int>(i));
        model.push_back(i);
      } else if (!model.empty()) {
        ASSERT_EQ(*fifo.front(), model.front());
        ASSERT_EQ(*fifo.Take(), model.front());
        model.pop_front();
      }
      ASSERT_EQ(fifo.empty(), model.empty());
    }
  }
}

TEST(Fifo, ReleasesTakenElements) {
  Fifo<std::shared_ptr<int>> fifo;
  const auto first = std::make_shared<int>(1), second = std::make_shared<int>(2);
  fifo.Put(std::shared_ptr<int>(first));
  fifo.Put(std::shared_ptr<int>(second));
  EXPECT_EQ(fifo.Take(), first);
  EXPECT_EQ(first.use_count(), 1);
  EXPECT_EQ(second.use_count(), 2);
}

}  // namespace
}  // namespace hgros
