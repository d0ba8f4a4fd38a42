// Compares the tree with a naive one for random trees, stamps and queries.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hgros/tf/transform_tree.hpp"
#include "tf/tf_fixture.hpp"

namespace hgros {
namespace {

using test::Difference;

/// The expected results of a transform tree, computed in the simplest way: maps of stamps, Eigen's slerp, products
/// from the root.
class NaiveTree {
 public:
  struct Found {
    TransformFault fault = TransformFault::kNone;
    RigidTransform T_target_source;
    std::int64_t stamp = 0;
  };

  NaiveTree(std::size_t frames, std::int64_t buffer, std::size_t count)
      : parents_(frames), edges_(frames), buffer_(buffer), count_(count) {}

  void SetStatic(std::size_t parent, std::size_t child, const RigidTransform& T) {
    parents_[child] = parent;
    edges_[child].is_static = true;
    edges_[child].samples = {{0, T}};
  }
  /// False if it is too old.
  bool Set(std::size_t parent, std::size_t child, std::int64_t stamp, const RigidTransform& T) {
    parents_[child] = parent;
    auto& samples = edges_[child].samples;
    if (!samples.empty() && stamp < samples.rbegin()->first - buffer_) return false;
    const bool is_new = samples.find(stamp) == samples.end();
    if (is_new && samples.size() == count_ && stamp < samples.begin()->first) return false;
    samples[stamp] = T;
    while (samples.size() > count_ || samples.begin()->first < samples.rbegin()->first - buffer_) {
      samples.erase(samples.begin());
    }
    return true;
  }

  [[nodiscard]] Found Lookup(std::size_t target, std::size_t source, std::optional<std::int64_t> stamp) const {
    std::vector<std::size_t> from_target = Up(target);
    std::vector<std::size_t> from_source = Up(source);
    const auto root = [](const std::vector<std::size_t>& up) { return up.back(); };
    if (from_target.size() == 1 && !HasChild(target)) return {TransformFault::kUnknownFrame, {}, 0};
    if (from_source.size() == 1 && !HasChild(source)) return {TransformFault::kUnknownFrame, {}, 0};
    if (root(from_target) != root(from_source)) return {TransformFault::kNotConnected, {}, 0};
    while (from_target.size() > 1 && from_source.size() > 1 &&
           from_target[from_target.size() - 2] == from_source[from_source.size() - 2]) {
      from_target.pop_back();
      from_source.pop_back();
    }
    Found found;
    constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
    found.stamp = stamp.value_or(kMost);
    if (!stamp) {
      for (const auto& up : {from_target, from_source}) {
        for (std::size_t i = 0; i + 1 < up.size(); ++i) {
          const Edge& edge = edges_[up[i]];
          if (!edge.is_static) found.stamp = std::min(found.stamp, edge.samples.rbegin()->first);
        }
      }
      if (found.stamp == kMost) found.stamp = 0;
    }
    const RigidTransform target_pose = Compose(from_target, found);
    const RigidTransform source_pose = Compose(from_source, found);
    found.T_target_source = target_pose.Inverse() * source_pose;
    return found;
  }

 private:
  struct Edge {
    bool is_static = false;
    std::map<std::int64_t, RigidTransform> samples;
  };

  [[nodiscard]] std::vector<std::size_t> Up(std::size_t frame) const {
    std::vector<std::size_t> up{frame};
    while (parents_[up.back()]) up.push_back(*parents_[up.back()]);
    return up;
  }
  [[nodiscard]] bool HasChild(std::size_t frame) const {
    return std::find(parents_.begin(), parents_.end(), std::optional(frame)) != parents_.end();
  }
  [[nodiscard]] RigidTransform Compose(const std::vector<std::size_t>& up, Found& found) const {
    RigidTransform sum;
    for (std::size_t i = 0; i + 1 < up.size(); ++i) sum = At(edges_[up[i]], found) * sum;
    return sum;
  }
  [[nodiscard]] static RigidTransform At(const Edge& edge, Found& found) {
    if (edge.is_static) return edge.samples.begin()->second;
    const auto after = edge.samples.lower_bound(found.stamp);
    if (after == edge.samples.end()) {
      found.fault = TransformFault::kTooNew;
      return {};
    }
    if (after->first == found.stamp) return after->second;
    if (after == edge.samples.begin()) {
      found.fault = TransformFault::kTooOld;
      return {};
    }
    const auto before = std::prev(after);
    const double t =
        static_cast<double>(found.stamp - before->first) / static_cast<double>(after->first - before->first);
    const RigidTransform& a = before->second;
    const RigidTransform& b = after->second;
    return {a.rotation.slerp(t, b.rotation), a.translation + t * (b.translation - a.translation)};
  }

  std::vector<std::optional<std::size_t>> parents_;
  std::vector<Edge> edges_;
  std::int64_t buffer_;
  std::size_t count_;
};

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

INSTANTIATE_TEST_SUITE_P(Seeds, Model, testing::Range(1U, 7U));
INSTANTIATE_TEST_SUITE_P(MoreSeeds, Model, testing::Range(7U, 21U));

}  // namespace
}  // namespace hgros
