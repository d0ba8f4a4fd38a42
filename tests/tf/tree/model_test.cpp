// Compares the tree with a naive one for random trees, stamps and queries.
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "hgros/tf/transform_tree.hpp"
#include "tf/tf_fixture.hpp"
#include "tf/tree/naive_tree.hpp"

namespace hgros {
namespace {

using test::Difference;
using test::NaiveTree;

class Model : public testing::TestWithParam<unsigned> {};

std::int64_t Within(std::mt19937_64& random, std::int64_t from, std::int64_t to) {
  return std::uniform_int_distribution<std::int64_t>(from, to)(random);
}

// 20 trees with 5000 queries each.
TEST_P(Model, AgreesWithTheNaiveTree) {
  const unsigned seed = GetParam();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  constexpr std::size_t kFrames = 24;
  constexpr std::int64_t kBuffer = 1'000'000;
  const auto count = static_cast<std::size_t>(Within(random, 2, 300));
  TransformTree tree({.buffer = Duration(kBuffer), .max_transforms_per_edge = count});
  NaiveTree naive(kFrames, kBuffer, count);
  std::vector<FrameId> ids;
  for (std::size_t i = 0; i < kFrames; ++i) ids.push_back(tree.Frame("frame" + std::to_string(i)));
  // Every frame is below an earlier one; there are some roots and some static edges. The last frame has no edge.
  std::vector<int> parents(kFrames, -1);
  std::vector<std::int64_t> clocks(kFrames, 0);
  for (std::size_t i = 1; i + 1 < kFrames; ++i) {
    if (Within(random, 0, 9) == 0) continue;
    parents[i] = static_cast<int>(
        Within(random, std::max<std::int64_t>(0, static_cast<std::int64_t>(i) - 4), static_cast<std::int64_t>(i) - 1));
    if (Within(random, 0, 4) == 0) {
      const RigidTransform T = test::RandomTransform(random);
      ASSERT_TRUE(tree.SetStatic(ids[static_cast<std::size_t>(parents[i])], ids[i], T));
      naive.SetStatic(static_cast<std::size_t>(parents[i]), i, T);
      parents[i] = -2;
    }
  }
  int found_count = 0;
  for (int query = 0; query < 5000; ++query) {
    for (int set = 0; set < 4; ++set) {
      const auto child = static_cast<std::size_t>(Within(random, 1, kFrames - 2));
      if (parents[child] < 0) continue;
      std::int64_t stamp = clocks[child] += Within(random, 0, 9'000);
      const std::int64_t kind = Within(random, 0, 19);
      if (kind == 0) stamp -= Within(random, 0, 1'200'000);                // Out of order, some too old.
      if (kind == 1) stamp = clocks[child] += Within(random, 0, 700'000);  // A gap.
      // Transforms that follow each other in time are sometimes close together and sometimes far apart.
      const RigidTransform T = test::RandomTransform(random);
      const auto parent = static_cast<std::size_t>(parents[child]);
      ASSERT_EQ(bool(tree.Set(ids[parent], ids[child], Time{stamp}, T)), naive.Set(parent, child, stamp, T));
    }
    const auto target = static_cast<std::size_t>(Within(random, 0, kFrames - 1));
    const auto source = static_cast<std::size_t>(Within(random, 0, kFrames - 1));
    const bool latest = Within(random, 0, 3) == 0;
    const std::int64_t newest = clocks[Within(random, 0, 1) == 0 ? target : source];
    const std::int64_t stamp = newest - Within(random, -20'000, Within(random, 0, 3) == 0 ? 1'100'000 : 100'000);
    const NaiveTree::Found expected = naive.Lookup(target, source, latest ? std::nullopt : std::optional(stamp));
    const TransformResult found =
        latest ? tree.Lookup(ids[target], ids[source]) : tree.Lookup(ids[target], ids[source], Time{stamp});
    const bool either_end = expected.fault == TransformFault::kTooOld || expected.fault == TransformFault::kTooNew;
    if (either_end) {
      // If the time is too old for one edge and too new for another, either may be named.
      ASSERT_TRUE(found.fault() == TransformFault::kTooOld || found.fault() == TransformFault::kTooNew) << found.text();
      continue;
    }
    ASSERT_EQ(found.fault(), expected.fault) << found.text() << " query " << query;
    if (!found) continue;
    ++found_count;
    ASSERT_EQ(found->stamp.nanoseconds, expected.stamp);
    ASSERT_LT(Difference(found->T_target_source, expected.T_target_source), 1e-9) << "query " << query;
  }
  EXPECT_GT(found_count, 200);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Model, testing::Range(1U, 21U));

}  // namespace
}  // namespace hgros
