#include "hgros/clock/errand_thread.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "support/await.hpp"

namespace hgros {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""h;

TEST(ErrandThread, RunsErrandsInOrderAndDelayedOnesWhenDue) {
  std::string ran;
  {
    ErrandThread errands;
    std::atomic<bool> later{false};
    errands.Post([&] { ran += "a"; });
    errands.Post([&] { ran += "b"; });
    errands.PostIn(1ms, [&] {
      ran += "c";
      later = true;
    });
    ASSERT_TRUE(test::Await([&] { return later.load(); }));
  }
  EXPECT_EQ(ran, "abc");
}

TEST(ErrandThread, EndRunsPostedErrandsButNotDelayedOrLaterOnes) {
  int ran = 0;
  ErrandThread errands;
  errands.PostIn(1h, [&] { ran += 1000; });
  std::function<void(int)> post = [&](int left) {
    if (left == 0) return;
    errands.Post([&, left] {
      ++ran;
      post(left - 1);
    });
  };
  post(1000);
  errands.End();
  EXPECT_EQ(ran, 1000);
  errands.Post([&] { ++ran; });
  errands.PostIn(0ms, [&] { ++ran; });
  errands.End();
  EXPECT_EQ(ran, 1000) << "posts after its end are ignored";
}

// Sessions hold the thread in an optional, too. The thread sanitizer reports if the handle changes while errands use
// it.
TEST(ErrandThread, ErrandsInFlightPostThroughTheOwnersHandle) {
  constexpr int kAfter = 1000;
  std::atomic<bool> ending{false};
  int after = 0;
  std::optional<ErrandThread> errands;
  errands.emplace();
  std::function<void()> again = [&] {
    if (ending && ++after == kAfter) return;
    errands->Post(again);
  };
  errands->Post(again);
  ending = true;
  errands->End();
  EXPECT_EQ(after, kAfter);
}

}  // namespace
}  // namespace hgros
