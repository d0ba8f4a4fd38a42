#include "hgros/internal/base/listeners.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>

namespace hgros {
namespace {

TEST(Listeners, AreToldInTheirOrder) {
  Listeners<int> listeners;
  std::vector<int> told;
  const Listening first = listeners.Add([&](int event) { told.push_back(event); });
  const Listening second = listeners.Add([&](int event) { told.push_back(-event); });
  listeners.Tell(1);
  listeners.Tell(2);
  EXPECT_EQ(told, (std::vector{1, -1, 2, -2}));
}

TEST(Listeners, AreAllToldAlthoughOneThrows) {
  Listeners<int> listeners;
  int told = 0;
  const Listening first = listeners.Add([](int) { throw std::runtime_error("the first"); });
  const Listening second = listeners.Add([](int) { throw std::logic_error("the second"); });
  const Listening third = listeners.Add([&](int event) { told = event; });
  EXPECT_THROW(listeners.Tell(7), std::runtime_error);
  EXPECT_EQ(told, 7);
}

// The telling thread keeps its list of them a moment longer.
TEST(Listeners, DestroyTheCapturesBeforeTheirEndReturns) {
  Listeners<int> listeners;
  std::atomic<bool> done{false};
  std::thread tells([&] {
    while (!done) listeners.Tell(1);
  });
  for (int round = 0; round < 20000; ++round) {
    const auto held = std::make_shared<int>(round);
    Listening listening = listeners.Add([held](int) {});
    listening.Reset();
    EXPECT_EQ(held.use_count(), 1) << "round " << round;
  }
  done = true;
  tells.join();
}

TEST(Listeners, DestroyTheCapturesOfOneThatEndsInItsOwnCallAfterIt) {
  Listeners<int> listeners;
  auto held = std::make_shared<int>(7);
  const std::weak_ptr<int> alive = held;
  Listening listening;
  int seen = 0;
  listening = listeners.Add([&listening, &seen, held = std::move(held)](int depth) {
    listening.Reset();
    seen = *held + depth;  // Its captures are still here.
  });
  listeners.Tell(1);
  EXPECT_EQ(seen, 8);
  EXPECT_TRUE(alive.expired());
  listeners.Tell(2);
  EXPECT_EQ(seen, 8);
}

TEST(Listeners, StayAfterAnException) {
  Listeners<int> listeners;
  auto held = std::make_shared<int>(0);
  Listening listening = listeners.Add([held](int) {
    ++*held;
    throw std::runtime_error("no");
  });
  EXPECT_THROW(listeners.Tell(1), std::runtime_error);
  EXPECT_THROW(listeners.Tell(1), std::runtime_error);
  listening.Reset();
  EXPECT_EQ(*held, 2);
  EXPECT_EQ(held.use_count(), 1);
}

}  // namespace
}  // namespace hgros
