#include <gmock/gmock.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "hgros/tf/transform_tree.hpp"
#include "support/await.hpp"
#include "tf/tf_fixture.hpp"

namespace hgros {
namespace {

using namespace std::chrono_literals;
using test::kPatience;
using test::Shift;
using ::testing::HasSubstr;

class Waiting : public testing::Test {
 protected:
  Waiting() { tree.Set("map", "base", Time{100}, Shift(1)); }
  TransformQuery Base(std::int64_t stamp) { return {tree.Frame("map"), tree.Frame("base"), Time{stamp}}; }
  TransformTree tree;
};

TEST_F(Waiting, ReturnsAtOnceIfTheTransformIsThere) {
  EXPECT_TRUE(tree.Wait(Base(100), 0s));
  int calls = 0;
  const auto pending = tree.WhenAvailable(Base(100), [&](const TransformResult&) { ++calls; });
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(tree.Wait(Base(50), kPatience).fault(), TransformFault::kTooOld) << "That transform can no longer come.";
}

TEST_F(Waiting, EndsAtItsDeadlineAndReportsWhatIsMissing) {
  const auto result = tree.Wait(Base(200), 1ms);
  EXPECT_EQ(result.fault(), TransformFault::kTimeout);
  EXPECT_THAT(result.text(), HasSubstr("Nothing has come within 0.001 s. There is no transform"));
  EXPECT_EQ(result.failure().newest, Time{100});
  EXPECT_THAT(tree.Wait(Base(200), Duration::min()).text(), HasSubstr("Nothing has come within 0 s. There is no"));
}

TEST_F(Waiting, WakesWhenTheTransformComes) {
  std::jthread setter([this] {
    for (std::int64_t stamp = 110; stamp <= 200; stamp += 10) tree.Set("map", "base", Time{stamp}, Shift(2));
  });
  const auto result = tree.Wait(Base(195), kPatience);
  ASSERT_TRUE(result) << result.text();
  EXPECT_EQ(result->stamp, Time{195});
}

TEST_F(Waiting, WakesWhenFramesAreAddedAndConnected) {
  std::jthread setter([this] {
    tree.SetStatic("tool", "tip", Shift(1));
    tree.Set("arm", "tool", Time{150}, Shift(1));
    tree.Set("base", "arm", Time{150}, Shift(1));
    tree.Set("map", "base", Time{150}, Shift(1));
    tree.Set("arm", "tool", Time{160}, Shift(1));
  });
  const auto result = tree.Wait({tree.Frame("map"), tree.Frame("tip"), Time{150}}, kPatience);
  ASSERT_TRUE(result) << result.text();
  EXPECT_LT(test::Difference(result->T_target_source, Shift(4)), 1e-12);
}

TEST_F(Waiting, StopsOnRequest) {
  std::stop_source stop;
  std::jthread stopper([&] { stop.request_stop(); });
  EXPECT_EQ(tree.Wait(Base(200), kPatience, stop.get_token()).fault(), TransformFault::kStopped);
}

TEST_F(Waiting, CallsBackOnceOnTheThreadThatSets) {
  int calls = 0;
  double x = 0;
  const auto pending = tree.WhenAvailable(Base(150), [&](const TransformResult& result) {
    ++calls;
    x = result->T_target_source.translation.x();
  });
  EXPECT_TRUE(pending.pending());
  tree.Set("map", "base", Time{140}, Shift(1));
  EXPECT_EQ(calls, 0);
  tree.Set("map", "base", Time{160}, Shift(3));
  EXPECT_EQ(calls, 1);
  EXPECT_DOUBLE_EQ(x, 2);
  tree.Set("map", "base", Time{170}, Shift(3));
  EXPECT_EQ(calls, 1);
  EXPECT_FALSE(pending.pending());
}

TEST_F(Waiting, DoesNotCallBackAfterTheHandleOrTheTreeIsGone) {
  int calls = 0;
  {
    auto first = tree.WhenAvailable(Base(150), [&](const TransformResult&) { ++calls; });
    auto second = tree.WhenAvailable(Base(150), [&](const TransformResult&) { ++calls; });
    first = std::move(second);
  }
  tree.Set("map", "base", Time{160}, Shift(3));
  EXPECT_EQ(calls, 0);
  PendingTransform outlives;
  {
    TransformTree other;
    outlives = other.WhenAvailable({other.Frame("a"), other.Frame("b")}, [&](const TransformResult&) { ++calls; });
  }
  outlives.Cancel();
  EXPECT_EQ(calls, 0);
}

TEST_F(Waiting, WaitsForACallbackInFlightBeforeTheHandleIsGone) {
  test::Door entered;
  test::Door leave;
  std::atomic<bool> left{false};
  auto pending = std::make_unique<PendingTransform>(tree.WhenAvailable(Base(150), [&](const TransformResult&) {
    entered.Open();
    leave.Pass();
    left = true;
  }));
  std::jthread setter([this] { tree.Set("map", "base", Time{160}, Shift(3)); });
  entered.Pass();
  std::jthread opener([&] { leave.Open(); });
  pending.reset();
  EXPECT_TRUE(left);
}

TEST_F(Waiting, ACallbackMayUseTheTreeAndItsOwnHandleAndThrow) {
  PendingTransform pending;
  bool set = false;
  pending = tree.WhenAvailable(Base(150), [&](const TransformResult&) {
    set = bool(tree.Set("map", "base", Time{170}, Shift(5)));
    pending.Cancel();
  });
  tree.Set("map", "base", Time{160}, Shift(3));
  EXPECT_TRUE(set);
  EXPECT_TRUE(tree.Lookup("map", "base", Time{170}));
  pending =
      tree.WhenAvailable(Base(180), [](const TransformResult&) { throw std::runtime_error("as it is meant to"); });
  EXPECT_NO_THROW(tree.Set("map", "base", Time{190}, Shift(3)));
}

TEST_F(Waiting, WaitForTheLatestWaitsForTheSlowestEdge) {
  tree.Set("base", "arm", Time{200}, Shift(1));
  EXPECT_EQ(tree.Lookup("map", "arm").fault(), TransformFault::kTooOld);
  std::int64_t found = 0;
  const auto pending = tree.WhenAvailable({tree.Frame("map"), tree.Frame("arm")},
                                          [&](const TransformResult& result) { found = result->stamp.nanoseconds; });
  tree.Set("map", "base", Time{150}, Shift(1));
  EXPECT_TRUE(pending.pending());
  tree.Set("map", "base", Time{210}, Shift(1));
  EXPECT_EQ(found, 200);
}

TEST_F(Waiting, WaitForTheLatestEndsWhenAllEdgesHaveRestarted) {
  tree.Set("base", "arm", Time{200}, Shift(1));  // Now the first edge has no transform for the latest time.
  tree.Set("map", "base", Time{90}, Shift(1));
  int calls = 0;
  const auto pending = tree.WhenAvailable({tree.Frame("map"), tree.Frame("arm")}, [&](const TransformResult& result) {
    ++calls;
    EXPECT_EQ(result->stamp, Time{5});
  });
  ASSERT_TRUE(pending.pending());
  tree.RestartTime();
  tree.Set("map", "base", Time{5}, Shift(1));
  EXPECT_EQ(calls, 0);
  tree.Set("base", "arm", Time{5}, Shift(1));
  EXPECT_EQ(calls, 1);
}

TEST_F(Waiting, WaitForAnOldStampContinuesAfterARestart) {
  tree.RestartTime();
  EXPECT_EQ(tree.Lookup(tree.Frame("map"), tree.Frame("base"), Time{50}).fault(), TransformFault::kTooOld);
  int calls = 0;
  const auto pending = tree.WhenAvailable(Base(50), [&](const TransformResult& result) {
    ++calls;
    EXPECT_TRUE(result);
  });
  EXPECT_TRUE(pending.pending());
  tree.Set("map", "base", Time{40}, Shift(1));
  EXPECT_EQ(calls, 0);
  tree.Set("map", "base", Time{60}, Shift(1));
  EXPECT_EQ(calls, 1);
}

TEST_F(Waiting, ManyThreadsWaitForManyStamps) {
  constexpr int kWaiters = 8;
  std::atomic<int> found{0};
  std::vector<std::jthread> threads;
  for (int i = 0; i < kWaiters; ++i) {
    threads.emplace_back([&, i] {
      for (std::int64_t stamp = 100 + i; stamp < 1000; stamp += kWaiters) {
        if (tree.Wait(Base(stamp), kPatience)) ++found;
      }
    });
  }
  for (std::int64_t stamp = 101; stamp <= 1000; ++stamp) tree.Set("map", "base", Time{stamp}, Shift(1));
  threads.clear();
  EXPECT_EQ(found, 900);
}

}  // namespace
}  // namespace hgros
