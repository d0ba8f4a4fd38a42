#include "session/errand_thread.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <thread>

namespace hgros {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""h;

TEST(ErrandThread, RunsErrandsInOrderAndThoseThatAreDueLater) {
  std::string ran;
  {
    ErrandThread errands;
    std::atomic<bool> later{false};
    errands.PostIn(20ms, [&] {
      ran += "c";
      later = true;
    });
    errands.Post([&] { ran += "a"; });
    errands.Post([&] { ran += "b"; });
    while (!later) std::this_thread::yield();
  }
  EXPECT_EQ(ran, "abc");
}

TEST(ErrandThread, EndsWhenAllIsDoneThatErrandsPostButNotWhatIsDueLater) {
  int ran = 0;
  ErrandThread errands;
  errands.PostIn(1h, [&] { ran += 1000; });
  std::function<void(int)> post = [&](int left) {
    if (left == 0) return;
    errands.Post([&, left] {
      ++ran;
      std::this_thread::sleep_for(1ms);
      post(left - 1);
    });
  };
  post(20);
  errands.End();
  EXPECT_EQ(ran, 20);
}

TEST(ErrandThread, OnceEndedItTakesNothingAndEndsAgainAtOnce) {
  int ran = 0;
  ErrandThread errands;
  errands.End();
  errands.Post([&] { ++ran; });
  errands.PostIn(0ms, [&] { ++ran; });
  errands.End();
  EXPECT_EQ(ran, 0);
}

// As sessions hold it. The thread sanitizer sees whether the handle changes under the errand.
TEST(ErrandThread, ErrandsInFlightPostThroughTheOwnersHandle) {
  int ran = 0;
  std::optional<ErrandThread> errands;
  errands.emplace();
  std::atomic<bool> begun{false};
  errands->Post([&] {
    begun = true;
    std::this_thread::sleep_for(20ms);
    errands->Post([&] { ++ran; });
  });
  while (!begun) std::this_thread::yield();
  errands->End();
  EXPECT_EQ(ran, 1);
}

}  // namespace
}  // namespace hgros
