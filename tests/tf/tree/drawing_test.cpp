#include <gtest/gtest.h>

#include "hgros/tf/transform_tree.hpp"
#include "hgros/tf/tree_drawing.hpp"
#include "tf/tf_fixture.hpp"

namespace hgros {
namespace {

using test::Shift;

void SetSmallTree(TransformTree& tree) {
  for (int i = 0; i <= 50; ++i) {
    ASSERT_TRUE(tree.Set("map", "base", Time{i * 20'000'000LL}, Shift(i), "localizer"));
  }
  ASSERT_TRUE(tree.SetStatic("base", "laser", Shift(1), "robot"));
  ASSERT_TRUE(tree.Set("base", "arm", Time{500'000'000}, Shift(1)));
}

TEST(Drawing, ShowsRateAgeAndPublisherOfEachEdge) {
  TransformTree tree;
  SetSmallTree(tree);
  EXPECT_EQ(DrawText(tree.Edges(), Time{1'250'000'000}),
            "map\n"
            "  base     50.0 Hz, 0.250 s old, by localizer\n"
            "    arm    once, 0.750 s old\n"
            "    laser  static, by robot\n");
  EXPECT_EQ(DrawText({}, Time{}), "");
}

TEST(Drawing, CanBeWrittenForGraphviz) {
  TransformTree tree;
  SetSmallTree(tree);
  EXPECT_EQ(DrawGraphviz(tree.Edges(), Time{1'250'000'000}),
            "digraph transforms {\n"
            "  node [shape=box];\n"
            "  \"map\" -> \"base\" [label=\"50.0 Hz\\n0.250 s old\\nby localizer\"];\n"
            "  \"base\" -> \"arm\" [label=\"once\\n0.750 s old\"];\n"
            "  \"base\" -> \"laser\" [label=\"static\\nby robot\", style=dashed];\n"
            "}\n");
  EXPECT_EQ(DrawGraphviz({}, Time{}), "digraph transforms {\n  node [shape=box];\n}\n");
}

TEST(Drawing, IsAnImageWithABoxForEachFrame) {
  TransformTree tree;
  SetSmallTree(tree);
  ASSERT_TRUE(tree.SetStatic("<other>", "a&b", Shift(1)));
  const std::string svg = DrawSvg(tree.Edges(), Time{1'250'000'000});
  for (const char* part : {">map<", ">base<", ">50.0 Hz<", ">0.250 s old<", ">by localizer<", ">laser<", ">static<",
                           ">&lt;other&gt;<", ">a&amp;b<"}) {
    EXPECT_NE(svg.find(part), std::string::npos) << part;
  }
  const auto count = [&svg](std::string_view part) {
    std::size_t found = 0;
    for (std::size_t at = 0; (at = svg.find(part, at)) != std::string::npos; ++at) ++found;
    return found;
  };
  EXPECT_EQ(count("<rect x="), 6U);
  EXPECT_EQ(count("<path "), 4U);
  EXPECT_EQ(count("stroke-dasharray"), 2U);
}

TEST(Edges, ReportTheRangeOfTheirBuffers) {
  TransformTree tree;
  SetSmallTree(tree);
  const auto edges = tree.Edges();
  ASSERT_EQ(edges.size(), 3U);
  EXPECT_EQ(edges[0].transforms, 51U);
  EXPECT_EQ(edges[0].sets, 51U);
  EXPECT_EQ(edges[0].oldest, Time{0});
  EXPECT_EQ(edges[0].newest, Time{1'000'000'000});
  EXPECT_LT(test::Difference(edges[0].T_parent_child, Shift(50)), 1e-15);
  EXPECT_TRUE(edges[2].is_static);
}

}  // namespace
}  // namespace hgros
