#include <gtest/gtest.h>

#include <random>

#include "viewer/data/channels/hypergraph.hpp"
#include "viewer/data/channels/hypergraph_layout.hpp"
#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

using Column = HypergraphLayout::Column;

ChannelUser User(std::uint64_t session, const std::string& process, const std::string& type = "T") {
  ChannelUser user;
  user.session = {session};
  user.process = process;
  user.type_name = type;
  return user;
}

KnownChannel Channel(const std::string& name, std::vector<ChannelUser> publishers,
                     std::vector<ChannelUser> subscribers) {
  KnownChannel channel;
  channel.name = name;
  channel.type_name = "T";
  channel.publishers = std::move(publishers);
  channel.subscribers = std::move(subscribers);
  return channel;
}

/// Adds the channel "scan" to a snapshot of that second.
Snapshot::Channel& AddScan(Snapshot& snapshot, std::uint64_t second) {
  snapshot.set_steady_ns(static_cast<std::int64_t>(1'000'000'000 * second));
  Snapshot::Channel& channel = *snapshot.add_channels();
  channel.set_name("scan");
  return channel;
}

TEST(ViewerHypergraph, ConnectsProcessesByTheirChannels) {
  const auto graph = MakeHypergraph({Channel("scan", {User(2, "lidar")}, {User(1, "viewer"), User(3, "slam")}),
                                     Channel("map", {User(3, "slam")}, {})},
                                    {1}, {}, {});
  ASSERT_EQ(graph.processes.size(), 3U);
  EXPECT_EQ(graph.processes[0].name, "lidar");
  EXPECT_EQ(graph.processes[2].name, "viewer");
  EXPECT_TRUE(graph.processes[2].own);
  ASSERT_EQ(graph.channels.size(), 2U);
  ASSERT_EQ(graph.lines.size(), 4U);
  EXPECT_TRUE(graph.lines[0].publishes);
  EXPECT_EQ(graph.lines[0].process, 0U);
  EXPECT_EQ(graph.lines[1].process, 2U);
  EXPECT_EQ(graph.lines[3].channel, 1U);
  EXPECT_FALSE(graph.lines[0].counts) << "its counts are unknown";
}

TEST(ViewerHypergraph, ShowsTheCountsOfProcesses) {
  SessionCounts counts;
  for (const std::uint64_t second : {0U, 1U}) {
    Snapshot lidar;
    Snapshot::Channel& published = AddScan(lidar, second);
    published.set_published(100 + 10 * second);
    published.set_refused(3);
    published.set_send_dropped(4);
    counts.Add(2, lidar);
    Snapshot slam;
    Snapshot::Channel& received = AddScan(slam, second);
    received.set_received(50 + 9 * second);
    received.set_lost(5);
    received.set_faults(7);
    for (const char* name : {"slow", "scan#1"}) {
      Snapshot::Node& node = *received.add_nodes();
      node.set_name(name);
      node.set_received(50 + 9 * second);
      node.set_dropped(6);
      node.set_failed(1);
      node.set_run_p99_ns(name[1] == 'l' ? 2000 : 1000);
    }
    counts.Add(3, slam);
  }
  const std::vector<KnownChannel> channels{Channel("scan", {User(2, "lidar")}, {User(3, "slam")})};

  const auto graph = MakeHypergraph(channels, {1}, counts, {});
  ASSERT_EQ(graph.lines.size(), 2U);
  ASSERT_TRUE(graph.lines[0].counts && graph.lines[1].counts && graph.channels[0].per_second);
  EXPECT_DOUBLE_EQ(*graph.channels[0].per_second, 10);
  EXPECT_EQ(graph.lines[0].counts->messages, 110U);
  EXPECT_EQ(graph.lines[0].counts->refused, 3U);
  EXPECT_EQ(graph.lines[0].counts->dropped, 4U);
  EXPECT_DOUBLE_EQ(graph.lines[1].counts->per_second.value(), 9);
  EXPECT_EQ(graph.lines[1].counts->lost, 5U);
  EXPECT_EQ(graph.lines[1].counts->unreadable, 7U);
  EXPECT_EQ(graph.lines[1].counts->dropped, 12U);
  EXPECT_EQ(graph.lines[1].counts->failed, 2U);
  EXPECT_EQ(graph.lines[1].counts->run_p99_ns, 2000);

  const auto by_node = MakeHypergraph(channels, {1}, counts, {.inner = false, .nodes = true});
  ASSERT_EQ(by_node.processes.size(), 3U);
  EXPECT_EQ(by_node.processes[1].node, "#1") << "the process has no name";
  EXPECT_EQ(by_node.processes[2].node, "slow");
  ASSERT_EQ(by_node.lines.size(), 3U);
  EXPECT_EQ(by_node.lines[2].process, 2U);
  EXPECT_EQ(by_node.lines[2].counts->dropped, 6U);
}

TEST(ViewerHypergraph, EstimatesTheRateOfSilentPublishersFromSubscribers) {
  SessionCounts counts;
  for (const std::uint64_t second : {0U, 1U}) {
    Snapshot own;
    AddScan(own, second).set_received(7 * second);
    counts.Add(1, own);
  }
  const auto graph = MakeHypergraph({Channel("scan", {User(2, "driver")}, {User(1, "viewer")})}, {1}, counts, {});
  EXPECT_DOUBLE_EQ(graph.channels[0].per_second.value(), 7);
}

TEST(ViewerHypergraph, CutsLongProcessNames) {
  const auto graph = MakeHypergraph({Channel("scan", {User(2, std::string(60'000, 'x'))}, {})}, {}, {}, {});
  ASSERT_EQ(graph.processes.size(), 1U);
  EXPECT_EQ(graph.processes[0].name.size(), kMaxShownBytes);
}

TEST(ViewerHypergraph, OmitsTheLibrarysOwnChannels) {
  const std::vector<KnownChannel> channels{Channel("hgros/call/add", {}, {User(2, "server")})};
  EXPECT_TRUE(MakeHypergraph(channels, {}, {}, {}).processes.empty());
  EXPECT_EQ(MakeHypergraph(channels, {}, {}, {.inner = true}).lines.size(), 1U);
}

TEST(ViewerHypergraph, MarksChannelsWithDifferentTypes) {
  const auto graph = MakeHypergraph(
      {Channel("a", {User(1, "x")}, {User(2, "y", "Other")}), Channel("b", {User(1, "x")}, {User(2, "y", "")})}, {}, {},
      {.inner = true});
  EXPECT_TRUE(graph.channels[0].types_differ);
  EXPECT_FALSE(graph.channels[1].types_differ) << "a subscriber of any type fits";
}

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
