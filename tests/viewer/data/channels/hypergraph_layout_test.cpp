#include "viewer/data/channels/hypergraph_layout.hpp"

#include <gtest/gtest.h>

#include <random>

namespace hgros::viewer {
namespace {

using Column = HypergraphLayout::Column;

Hypergraph Graph(std::size_t processes, std::size_t channels) {
  Hypergraph graph;
  graph.processes.resize(processes);
  graph.channels.resize(channels);
  return graph;
}

int Crossings(const HypergraphLayout& layout) {
  int crossings = 0;
  for (const auto& a : layout.links) {
    for (const auto& b : layout.links) {
      if (layout.boxes[a.from].column != layout.boxes[b.from].column) continue;
      const float left = layout.boxes[a.from].row - layout.boxes[b.from].row;
      const float right = layout.boxes[a.to].row - layout.boxes[b.to].row;
      crossings += left * right < 0 ? 1 : 0;
    }
  }
  return crossings / 2;
}

TEST(HypergraphLayout, ShowsAProcessThatPublishesAndSubscribesTwice) {
  Hypergraph graph = Graph(1, 2);
  graph.lines = {{0, 0, true, false}, {0, 1, false, false}};
  const HypergraphLayout layout = LayOut(graph);
  ASSERT_EQ(layout.boxes.size(), 4U);
  ASSERT_EQ(layout.links.size(), 2U);
  EXPECT_EQ(layout.boxes[layout.links[0].from].column, Column::kPublishers);
  EXPECT_EQ(layout.boxes[layout.links[0].to].column, Column::kChannels);
  EXPECT_EQ(layout.boxes[layout.links[1].to].column, Column::kSubscribers);
  EXPECT_EQ(layout.rows, 2U);
}

TEST(HypergraphLayout, IsEmptyForAnEmptyGraph) {
  EXPECT_TRUE(LayOut({}).boxes.empty());
  EXPECT_EQ(LayOut({}).rows, 0U);
}

TEST(HypergraphLayout, AvoidsCrossingsThatAreNotNecessary) {
  // Process i publishes channel 9 - i.
  Hypergraph graph = Graph(10, 10);
  for (std::size_t i = 0; i < 10; ++i) graph.lines.push_back({i, 9 - i, true, false});
  EXPECT_EQ(Crossings(LayOut(graph)), 0);
}

TEST(HypergraphLayout, GivesEachBoxOfAColumnItsOwnRow) {
  std::mt19937 random(3);
  Hypergraph graph = Graph(50, 40);
  for (int i = 0; i < 150; ++i) graph.lines.push_back({random() % 50, random() % 40, random() % 2 == 0, false});
  const HypergraphLayout layout = LayOut(graph);
  for (std::size_t i = 0; i < layout.boxes.size(); ++i) {
    EXPECT_GE(layout.boxes[i].row, 0);
    EXPECT_LE(layout.boxes[i].row, static_cast<float>(layout.rows - 1));
    for (std::size_t j = 0; j < i; ++j) {
      if (layout.boxes[i].column == layout.boxes[j].column) {
        EXPECT_GE(std::abs(layout.boxes[i].row - layout.boxes[j].row), 0.99F);
      }
    }
  }
}

}  // namespace
}  // namespace hgros::viewer
