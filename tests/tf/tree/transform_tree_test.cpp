#include "hgros/tf/transform_tree.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <string>

#include "hgros/base/error.hpp"
#include "tf/tf_fixture.hpp"

namespace hgros {
namespace {

using namespace std::chrono_literals;
using test::Difference;
using test::Shift;
using test::TurnZ;
using ::testing::HasSubstr;

Time At(double seconds) { return Time{static_cast<std::int64_t>(std::llround(seconds * 1e9))}; }

TEST(TransformTree, InterpolatesRotationsOfAnySizeLikeSlerp) {
  for (const double angle : {0.0, 1e-9, 1e-4, 0.005, 0.01, 0.09, 0.2, 0.8, 0.9, 2.0, 3.0, 3.14159}) {
    for (const double sign : {1.0, -1.0}) {
      TransformTree tree;
      RigidTransform end = TurnZ(0.3) * TurnZ(angle);
      end.rotation.coeffs() *= 1.0001 * sign;  // The same rotation by another quaternion, to be normalized.
      ASSERT_TRUE(tree.Set("map", "base", At(0), TurnZ(0.3)));
      ASSERT_TRUE(tree.Set("map", "base", At(1), end));
      for (const double t : {0.001, 0.25, 0.5, 0.875, 0.999, 1.0}) {
        const auto found = tree.Lookup("map", "base", At(t));
        ASSERT_TRUE(found);
        EXPECT_LT(Difference(found->T_target_source, TurnZ(0.3 + t * angle)), 1e-12) << angle << " at " << t;
        EXPECT_NEAR(found->T_target_source.rotation.norm(), 1, 1e-14);
      }
    }
  }
}

TEST(TransformTree, StaticEdgesHoldAtAllTimes) {
  TransformTree tree;
  ASSERT_TRUE(tree.SetStatic("base", "laser", Shift(1)));
  ASSERT_TRUE(tree.SetStatic("base", "camera", Shift(0, 2)));
  EXPECT_LT(Difference(tree.Lookup("laser", "camera", At(1e6))->T_target_source, Shift(-1, 2)), 1e-15);
  EXPECT_EQ(tree.Lookup("laser", "camera")->stamp, Time{});
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(tree.SetStatic("base", "laser", Shift(i)));
  EXPECT_LT(Difference(tree.Lookup("base", "laser")->T_target_source, Shift(19)), 1e-15)
      << "The newest transform counts.";
}

TEST(TransformTree, TravelsThroughAFixedFrame) {
  TransformTree tree;
  for (int i = 0; i <= 5; ++i) ASSERT_TRUE(tree.Set("map", "base", At(i), Shift(i)));
  ASSERT_TRUE(tree.SetStatic("base", "laser", Shift(0, 1)));
  // A point that the laser saw 1 m ahead at 1 s is 3 m behind it at 5 s.
  const auto found = tree.Lookup("laser", At(5), "laser", At(1), "map");
  ASSERT_TRUE(found) << found.text();
  EXPECT_LT(((found->T_target_source * Eigen::Vector3d(1, 0, 0)) - Eigen::Vector3d(-3, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(found->stamp, At(5));
  EXPECT_EQ(tree.Lookup("laser", At(5), "laser", At(6), "map").fault(), TransformFault::kTooNew);
  EXPECT_EQ(tree.Lookup("laser", At(5), "laser", At(1), "mp").failure().nearest_name, "map");
}

TEST(TransformTree, NamesTheNearestKnownFrame) {
  TransformTree tree;
  EXPECT_EQ(tree.Lookup("map", "base").text(),
            "No transforms received yet: a session listens from its first use of them on. Pass a timeout to wait.");
  ASSERT_TRUE(tree.Set("map", "base_link", At(1), Shift(1)));
  const auto found = tree.Lookup("map", "base_lnk");
  EXPECT_EQ(found.fault(), TransformFault::kUnknownFrame);
  EXPECT_EQ(found.failure().nearest_name, "base_link");
  EXPECT_EQ(found.text(), "No edge has a frame \"base_lnk\"; the nearest name is \"base_link\".");
  EXPECT_THROW((void)*found, Error);
  (void)tree.Frame("base_lnks");  // Frame() does not add an edge with this name.
  EXPECT_EQ(tree.Lookup("map", "base_lnks").failure().nearest_name, "base_link");
  EXPECT_EQ(tree.Lookup("map", "base_lnks").fault(), TransformFault::kUnknownFrame);
  EXPECT_EQ(tree.Lookup(FrameId{77}, FrameId{78}).fault(), TransformFault::kUnknownFrame);
}

TEST(TransformTree, NamesBothRootsOfUnconnectedFrames) {
  TransformTree tree;
  ASSERT_TRUE(tree.Set("map", "base", At(1), Shift(1)));
  ASSERT_TRUE(tree.Set("world", "drone", At(1), Shift(1)));
  const auto found = tree.Lookup("base", "drone");
  EXPECT_EQ(found.fault(), TransformFault::kNotConnected);
  EXPECT_EQ(found.failure().target_root, "map");
  EXPECT_EQ(found.failure().source_root, "world");
  EXPECT_THAT(found.text(), HasSubstr("\"map\""));
  EXPECT_THAT(found.text(), HasSubstr("\"world\""));
  ASSERT_TRUE(tree.SetStatic("map", "world", Shift(5)));
  EXPECT_TRUE(tree.Lookup("base", "drone"));
}

TEST(TransformTree, ReportsTheRangeOfAnEdgeWhenATimeIsTooOldOrTooNew) {
  TransformTree tree;
  ASSERT_TRUE(tree.Set("map", "base", At(1.5), Shift(1)));
  ASSERT_TRUE(tree.Set("map", "base", At(2.25), Shift(1)));
  const auto old = tree.Lookup("map", "base", At(1));
  EXPECT_EQ(old.fault(), TransformFault::kTooOld);
  EXPECT_EQ(old.failure().oldest, At(1.5));
  EXPECT_EQ(old.failure().newest, At(2.25));
  EXPECT_EQ(
      old.text(),
      "There is no transform from \"base\" to \"map\" at 1.000000000 s, which is too old: the edge from \"map\" to "
      "\"base\" has 1.500000000 s to 2.250000000 s.");
  const auto young = tree.Lookup("map", "base", At(3));
  EXPECT_EQ(young.fault(), TransformFault::kTooNew);
  EXPECT_THAT(young.text(), HasSubstr("too new"));
  EXPECT_TRUE(tree.CanTransform("map", "base", At(2)));
  EXPECT_FALSE(tree.CanTransform("map", "base", At(3)));
  EXPECT_FALSE(tree.CanTransform("map", "bse"));
}

TEST(TransformTree, KeepsTransformsAsOldAsItsBufferAndNoneOlder) {
  TransformTree tree({.buffer = 2s});
  for (const int i : {7, 8, 9, 10}) ASSERT_TRUE(tree.Set("map", "base", At(i), Shift(i)));
  EXPECT_TRUE(tree.Lookup("map", "base", At(8)));
  const auto old = tree.Lookup("map", "base", At(7.999));
  EXPECT_EQ(old.fault(), TransformFault::kTooOld);
  EXPECT_EQ(old.failure().oldest, At(8));
  EXPECT_TRUE(tree.Set("map", "base", At(8), Shift(1)));
  const auto late = tree.Set("map", "base", At(7.995), Shift(0));
  EXPECT_EQ(late.fault(), SetFault::kTooOld);
  EXPECT_THAT(late.text(), HasSubstr("is older than the buffer, which has 8.000000000 s to 10.000000000 s."));
}

TEST(TransformTree, DoesNotInterpolateOverAGapLongerThanItsBuffer) {
  TransformTree tree;
  ASSERT_TRUE(tree.Set("map", "base", At(0), Shift(1)));
  ASSERT_TRUE(tree.Set("map", "base", At(100), Shift(2)));
  EXPECT_EQ(tree.Lookup("map", "base", At(95)).fault(), TransformFault::kTooOld);
  EXPECT_TRUE(tree.Lookup("map", "base", At(100)));
}

TEST(TransformTree, AcceptsStampsInAnyOrderAndReplacesEqualOnes) {
  TransformTree tree;
  for (const int i : {0, 4, 2, 8, 6, 7, 1, 3, 5}) ASSERT_TRUE(tree.Set("map", "base", At(i), Shift(i * i)));
  for (int i = 0; i < 8; ++i) {
    EXPECT_LT(
        Difference(tree.Lookup("map", "base", At(i + 0.5))->T_target_source, Shift((i * i + (i + 1) * (i + 1)) / 2.0)),
        1e-12);
  }
  ASSERT_TRUE(tree.Set("map", "base", At(8), Shift(-8)));
  ASSERT_TRUE(tree.Set("map", "base", At(3), Shift(-3)));
  EXPECT_LT(Difference(tree.Lookup("map", "base")->T_target_source, Shift(-8)), 1e-15);
  EXPECT_LT(Difference(tree.Lookup("map", "base", At(3))->T_target_source, Shift(-3)), 1e-15);
  EXPECT_EQ(tree.Edges().front().transforms, 9U);
}

TEST(TransformTree, RefusesFramesMoreThanAThousandEdgesBelowTheirRoot) {
  const auto name = [](int i) { return "f" + std::to_string(i); };
  for (const bool downwards : {true, false}) {
    TransformTree tree;
    const auto set = [&](int parent, int child) { return tree.SetStatic(name(parent), name(child), Shift(1)); };
    for (int i = 0; i < 1000; ++i) ASSERT_TRUE(downwards ? set(i, i + 1) : set(1000 - i - 1, 1000 - i)) << i;
    EXPECT_TRUE(set(999, 2000)) << "beside the last";
    const SetResult below = set(1000, 1001);
    EXPECT_EQ(below.fault(), SetFault::kTooDeep);
    EXPECT_EQ(below.text(),
              "The transform from \"f1000\" to \"f1001\" was refused: frames would be more than 1000 edges below their "
              "root. Set frames below a nearer one.");
    EXPECT_EQ(set(3000, 0).fault(), SetFault::kTooDeep);
    for (const int refused : {1001, 3000}) EXPECT_FALSE(tree.Find(name(refused)));
    ASSERT_TRUE(set(4000, 4001));
    EXPECT_EQ(set(4001, 0).fault(), SetFault::kTooDeep);
    EXPECT_EQ(set(1000, 4000).fault(), SetFault::kTooDeep);
    EXPECT_TRUE(tree.Lookup(name(0), name(1000)));
  }
}

TEST(TransformTree, NamesSomeOfTheFramesOfALongCycle) {
  TransformTree tree;
  for (int i = 0; i < 900; ++i) {
    ASSERT_TRUE(tree.SetStatic("f" + std::to_string(i), "f" + std::to_string(i + 1), Shift(1)));
  }
  const SetResult set = tree.SetStatic("f900", "f0", Shift(1));
  EXPECT_EQ(set.fault(), SetFault::kCycle);
  EXPECT_LT(set.text().size(), 1000U);
  EXPECT_TRUE(set.text().ends_with("which is below \"f880\", which is below others, which are below \"f0\"."))
      << set.text();
}

TEST(TransformTree, RefusesInvalidTransformsWithAReasonAndKeepsNoneOfTheirFrames) {
  TransformTree tree;
  ASSERT_TRUE(tree.Set("map", "base", At(1), Shift(1)));
  ASSERT_TRUE(tree.Set("base", "arm", At(1), Shift(1)));
  ASSERT_TRUE(tree.SetStatic("base", "laser", Shift(1)));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto turned = [](double w) {
    return RigidTransform(RigidTransform::Rotation(w, 0, 0, 0), Eigen::Vector3d::Zero());
  };
  struct Case {
    std::string parent;
    std::string child;
    RigidTransform T;
    SetFault fault;
    std::string reason;
  };
  const std::string name = "name is invalid: it is empty";
  const Case moving[] = {
      {"a", "b", turned(1.01), SetFault::kRotation,
       "its rotation is a quaternion of length 1.01, not 1. Normalize it."},
      {"a", "b", turned(kNan), SetFault::kRotation, ""},
      {"a", "b", turned(0), SetFault::kRotation, ""},
      {"a", "b", turned(2), SetFault::kRotation, ""},
      {"a", "b", Shift(0, kNan), SetFault::kTranslation, ""},
      {"a", "b", Shift(0, kInfinity), SetFault::kTranslation, ""},
      {"a", "b", Shift(0, -kInfinity), SetFault::kTranslation, ""},
      {"a", "b", Shift(0, 1e308), SetFault::kTranslation, ""},
      {"a", "b", Shift(0, -1.1e12), SetFault::kTranslation,
       "its translation (0, -1.1e+12, 0) is not finite, or above 1e12 m."},
      {"", "b", Shift(1), SetFault::kName, "the parent's " + name},
      {"a", "", Shift(1), SetFault::kName, "the child's " + name},
      {"map", "two words", Shift(1), SetFault::kName, ""},
      {"a", "base", Shift(1), SetFault::kTwoParents,
       "\"base\" is below \"map\" already, and a frame keeps its parent."},
      {"a", "a", Shift(1), SetFault::kCycle, "a frame cannot be below itself."},
      {"arm", "map", Shift(1), SetFault::kCycle,
       "it would close a cycle: \"arm\" is below \"base\", which is below \"map\"."},
      {"base", "laser", Shift(1), SetFault::kStatic, "it is a static edge. Set it without a stamp, as a static one."}};
  for (const Case& one : moving) {
    const SetResult result = tree.Set(one.parent, one.child, At(1), one.T);
    EXPECT_EQ(result.fault(), one.fault) << result.text();
    const std::string text = "from \"" + one.parent + "\" to \"" + one.child + "\" was refused: " + one.reason;
    EXPECT_THAT(result.text(), HasSubstr(text));
    if (one.reason.ends_with('.')) {
      EXPECT_EQ(result.text(), "The transform " + text);
    }
  }
  EXPECT_EQ(tree.SetStatic("map", "base", Shift(1)).fault(), SetFault::kStatic);
  EXPECT_EQ(tree.SetStatic("map", "b", Shift(kInfinity)).fault(), SetFault::kTranslation);
  EXPECT_EQ(tree.Set(FrameId{75}, FrameId{76}, At(1), Shift(1)).fault(), SetFault::kName);
  EXPECT_THROW((void)tree.Frame(""), Error);
  EXPECT_EQ(tree.Lookup("", "base").fault(), TransformFault::kUnknownFrame);
  for (const char* refused : {"a", "b"}) EXPECT_FALSE(tree.Find(refused)) << refused;
  EXPECT_EQ(tree.Edges().size(), 3U);
}

TEST(TransformTree, IdsMeanTheSameAsNames) {
  TransformTree tree;
  const FrameId map = tree.Frame("map");
  const FrameId base = tree.Frame("base");
  ASSERT_TRUE(tree.Set(map, base, At(1), Shift(1)));
  ASSERT_TRUE(tree.Set("map", "base", At(2), Shift(2)));
  EXPECT_EQ(tree.Find("base"), base);
  EXPECT_EQ(tree.Find("nobody"), std::nullopt);
  EXPECT_EQ(tree.Name(map), "map");
  EXPECT_EQ(tree.Name(FrameId{}), "");
  EXPECT_LT(Difference(tree.Lookup(map, base, At(1.5))->T_target_source, Shift(1.5)), 1e-12);
}

TEST(TransformTree, HandlesVeryDeepAndVeryWideTrees) {
  TransformTree tree;
  constexpr int kDepth = 300;
  for (int i = 0; i < kDepth; ++i) {
    ASSERT_TRUE(tree.Set("f" + std::to_string(i), "f" + std::to_string(i + 1), At(1), Shift(1)));
    ASSERT_TRUE(tree.Set(i == 0 ? "f0" : "g" + std::to_string(i), "g" + std::to_string(i + 1), At(1), Shift(0, 1)));
  }
  const auto found = tree.Lookup("g300", "f300", At(1));
  ASSERT_TRUE(found) << found.text();
  EXPECT_LT(Difference(found->T_target_source, Shift(300, -300)), 1e-9);
  for (const int depth : {15, 16, 17, 31, 32, 33, 34, 40}) {
    const std::string name = std::to_string(depth);
    EXPECT_LT(Difference(tree.Lookup("f" + name, "f" + std::to_string(depth + 32))->T_target_source, Shift(32)), 1e-9);
    EXPECT_LT(Difference(tree.Lookup("g" + name, "f1")->T_target_source, Shift(1, -depth)), 1e-9);
  }
}

TEST(TransformTree, AcceptsEveryStampValue) {
  TransformTree tree;
  const Time first{std::numeric_limits<std::int64_t>::min()};
  ASSERT_TRUE(tree.Set("map", "base", first, Shift(1)));
  ASSERT_TRUE(tree.Set("map", "base", first + 1s, Shift(2)));
  EXPECT_TRUE(tree.Lookup("map", "base", first + 500ms));
  ASSERT_TRUE(tree.Set("map", "base", Time{std::numeric_limits<std::int64_t>::max()}, Shift(3)));
  EXPECT_EQ(tree.Lookup("map", "base", first + 1s).fault(), TransformFault::kTooOld);
  EXPECT_LT(Difference(tree.Lookup("map", "base")->T_target_source, Shift(3)), 1e-15);
}

TEST(TransformTree, TreeIgnoresMemosOfAnEarlierTreeAtTheSameAddress) {
  for (int i = 0; i < 100; ++i) {
    TransformTree tree;
    ASSERT_TRUE(tree.Set("map", "base", At(1), Shift(i)));
    EXPECT_LT(Difference(tree.Lookup("map", "base")->T_target_source, Shift(i)), 1e-15);
    EXPECT_LT(Difference(tree.Lookup("map", "base")->T_target_source, Shift(i)), 1e-15);
  }
}

TEST(TransformTree, RestartReplacesOldTransformsAfterTimeJumpedBack) {
  TransformTree tree;
  ASSERT_TRUE(tree.SetStatic("base", "laser", Shift(1)));
  ASSERT_TRUE(tree.Set("map", "base", At(100), Shift(1)));
  ASSERT_TRUE(tree.Set("map", "base", At(101), Shift(2)));
  EXPECT_EQ(tree.Set("map", "base", At(1), Shift(3)).fault(), SetFault::kTooOld);
  tree.RestartTime();
  EXPECT_EQ(tree.Lookup("map", "base")->stamp, At(101)) << "until a transform is set";
  ASSERT_TRUE(tree.Set("map", "base", At(1), Shift(3)));
  EXPECT_EQ(tree.Lookup("map", "laser")->stamp, At(1));
  EXPECT_EQ(tree.Lookup("map", "base", At(100)).fault(), TransformFault::kTooNew);
  ASSERT_TRUE(tree.Set("map", "base", At(2), Shift(4)));
  EXPECT_LT(Difference(tree.Lookup("map", "base", At(1.5))->T_target_source, Shift(3.5)), 1e-12);
  EXPECT_EQ(tree.Edges().at(0).transforms, 2U);
  for (int i = 0; i < 300; ++i) {  // Uses all memory of both buffers several times.
    tree.RestartTime();
    for (int stamp = 1; stamp <= i; ++stamp) ASSERT_TRUE(tree.Set("map", "base", At(stamp * 0.01), Shift(stamp + i)));
    if (i < 2) continue;
    ASSERT_LT(Difference(tree.Lookup("map", "base", At(0.015))->T_target_source, Shift(1.5 + i)), 1e-9);
  }
}

TEST(TransformTree, TransformsFromBeforeTheJumpDoNotRestartAnEdge) {
  TransformTree tree;
  ASSERT_TRUE(tree.Set("map", "base", At(100), Shift(1)));
  ASSERT_TRUE(tree.Set("map", "arm", At(100), Shift(1)));
  tree.RestartTime(At(50));
  ASSERT_TRUE(tree.Set("map", "base", At(100.1), Shift(2)));
  EXPECT_EQ(tree.Lookup("map", "base", At(100.05))->stamp, At(100.05)) << "with the earlier transforms";
  ASSERT_TRUE(tree.Set("map", "base", At(0), Shift(3)));
  EXPECT_EQ(tree.Lookup("map", "base")->stamp, At(0));
  ASSERT_TRUE(tree.Set("map", "arm", At(60), Shift(4))) << "the edge was not set for long";
  EXPECT_EQ(tree.Lookup("map", "arm")->stamp, At(60));
}

TEST(TransformTree, AnEdgeBeginsAgainIfItHasStampsThatCannotBe) {
  TransformTree tree;
  ASSERT_TRUE(tree.SetStatic("base", "laser", Shift(1)));
  ASSERT_TRUE(tree.Set("map", "base", At(100), Shift(1)));
  EXPECT_FALSE(tree.RestartEdge("base", At(100)));
  EXPECT_FALSE(tree.RestartEdge("laser", At(0))) << "it does not move";
  EXPECT_FALSE(tree.RestartEdge("map", At(0)));
  EXPECT_FALSE(tree.RestartEdge("unknown", At(0)));
  EXPECT_EQ(tree.Set("map", "base", At(1), Shift(2)).fault(), SetFault::kTooOld);
  EXPECT_TRUE(tree.RestartEdge("base", At(99)));
  EXPECT_EQ(tree.Lookup("map", "base")->stamp, At(100)) << "until a transform is set";
  ASSERT_TRUE(tree.Set("map", "base", At(1), Shift(2)));
  EXPECT_EQ(tree.Lookup("map", "laser")->stamp, At(1));
  EXPECT_EQ(tree.Edges().at(0).transforms, 1U);
  ASSERT_TRUE(tree.Set("map", "base", At(20), Shift(3)));
  EXPECT_EQ(tree.Set("map", "base", At(1), Shift(2)).fault(), SetFault::kTooOld);
}

TEST(TransformTree, HasAtMostTheMaximumOfFrames) {
  TransformTree tree({.max_frames = 3});
  ASSERT_TRUE(tree.Set("map", "base", At(1), Shift(1)));
  ASSERT_TRUE(tree.Set("base", "arm", At(1), Shift(1)));
  const SetResult result = tree.Set("arm", "hand", At(1), Shift(1));
  EXPECT_EQ(result.fault(), SetFault::kTooManyFrames);
  EXPECT_THAT(result.text(), HasSubstr("from \"arm\" to \"hand\" was refused: the tree has 3 frames"));
  EXPECT_THROW((void)tree.Frame("hand"), Error);
  EXPECT_TRUE(tree.Set("base", "arm", At(2), Shift(1))) << "existing frames can still be set";
}

}  // namespace
}  // namespace hgros
