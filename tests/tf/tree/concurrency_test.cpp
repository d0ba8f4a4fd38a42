// Readers and writers at the same time. Every transform contains its own stamp, so that a mixture of two is detected.

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "hgros/tf/transform_tree.hpp"
#include "tf/tf_fixture.hpp"

namespace hgros {
namespace {

using test::Shift;

constexpr int kEdges = 3;
constexpr std::int64_t kStep = 1000;
constexpr int kSets = 20'000;

// At stamp t every edge is (t, 2 t, 3 t) / 1e6, also between stamps.
RigidTransform PoseAt(std::int64_t stamp) {
  const double t = static_cast<double>(stamp) / 1e6;
  return Shift(t, 2 * t, 3 * t);
}

// Number of the three edges whose values do not match their stamp.
bool IsWhole(const StampedTransform& found) {
  const double t = kEdges * static_cast<double>(found.stamp.nanoseconds) / 1e6;
  return test::Difference(found.T_target_source, Shift(t, 2 * t, 3 * t)) < 1e-9 * (1 + t);
}

class Concurrency : public testing::TestWithParam<int> {};

TEST_P(Concurrency, ReadersSeeWholeTransformsWhileOthersWrite) {
  // Few transforms, so that memory is reused often.
  TransformTree tree({.buffer = Duration(100 * kStep), .max_transforms_per_edge = 80});
  std::vector<FrameId> ids;
  for (int i = 0; i <= kEdges; ++i) ids.push_back(tree.Frame("frame" + std::to_string(i)));
  const auto set = [&](int edge, std::int64_t stamp) {
    return tree.Set(ids[static_cast<std::size_t>(edge)], ids[static_cast<std::size_t>(edge) + 1], Time{stamp},
                    PoseAt(stamp));
  };
  for (int edge = 0; edge < kEdges; ++edge) ASSERT_TRUE(set(edge, 0));

  std::atomic<int> writing{kEdges};
  std::atomic<int> broken{0};
  std::atomic<std::uint64_t> found{0};
  {
    std::vector<std::jthread> threads;
    for (int edge = 0; edge < kEdges; ++edge) {
      threads.emplace_back([&, edge] {
        std::mt19937_64 random(static_cast<unsigned>(edge));
        for (std::int64_t i = 1; i <= kSets; ++i) {
          if (!set(edge, i * kStep)) ++broken;
          // Some transforms come out of order.
          if (i % 50 == 0) set(edge, i * kStep - static_cast<std::int64_t>(random() % (20 * kStep)));
        }
        --writing;
      });
    }
    for (int reader = 0; reader < GetParam(); ++reader) {
      threads.emplace_back([&, reader] {
        std::mt19937_64 random(static_cast<unsigned>(100 + reader));
        std::int64_t last = 0;
        while (writing > 0) {
          const TransformResult latest = tree.Lookup(ids.front(), ids.back());
          // If the stamps of the writers are far apart, one edge has already forgotten the latest time of another.
          if (latest) {
            ++found;
            if (!IsWhole(*latest) || latest->stamp.nanoseconds < last) ++broken;
            last = latest->stamp.nanoseconds;
          } else if (latest.fault() != TransformFault::kTooOld) {
            ++broken;
          }
          const Time before{last - static_cast<std::int64_t>(random() % (30 * kStep))};
          const TransformResult at = tree.Lookup(ids.front(), ids.back(), before);
          if (at && !IsWhole(*at)) ++broken;
          if (!at && at.fault() != TransformFault::kTooOld) ++broken;
        }
      });
    }
  }
  EXPECT_EQ(broken, 0);
  const TransformResult end = tree.Lookup(ids.front(), ids.back());
  ASSERT_TRUE(end) << end.text();
  EXPECT_EQ(end->stamp.nanoseconds, kSets * kStep);
}

TEST_P(Concurrency, FramesAreFoundAndConnectedWhileOthersAddThem) {
  constexpr int kFrames = 500;
  TransformTree tree;
  std::atomic<bool> done{false};
  std::atomic<int> broken{0};
  {
    std::vector<std::jthread> threads;
    for (int reader = 0; reader < GetParam(); ++reader) {
      threads.emplace_back([&, reader] {
        std::mt19937_64 random(static_cast<unsigned>(reader));
        while (!done) {
          const std::string name = "frame" + std::to_string(random() % kFrames);
          const TransformResult found = tree.Lookup("frame0", name);
          if (found && test::Difference(found->T_target_source, Shift(std::stod(name.substr(5)))) > 1e-9) ++broken;
          if (!found && found.fault() != TransformFault::kUnknownFrame &&
              found.fault() != TransformFault::kNotConnected) {
            ++broken;
          }
        }
      });
    }
    {
      std::vector<std::jthread> writers;
      for (int writer = 0; writer < 2; ++writer) {
        writers.emplace_back([&, writer] {
          // One thread puts the even frames below the odd ones, the other thread the odd ones below the even ones.
          for (int i = writer; i + 1 < kFrames; i += 2) {
            if (!tree.SetStatic("frame" + std::to_string(i), "frame" + std::to_string(i + 1), Shift(1))) ++broken;
          }
        });
      }
    }
    done = true;
  }
  EXPECT_EQ(broken, 0);
  EXPECT_LT(test::Difference(tree.Lookup("frame0", "frame499")->T_target_source, Shift(499)), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Readers, Concurrency, testing::Values(1, 2, 4));

}  // namespace
}  // namespace hgros
