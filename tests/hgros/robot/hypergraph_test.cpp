#include "robot/hypergraph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drawing/graph_drawing.hpp"

namespace hgros::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

ChannelUser User(std::uint64_t session, const std::string& process, const std::string& host = "robot") {
  const auto pid = static_cast<std::int64_t>(session);
  return {.session = {session}, .process = process, .host = host, .pid = pid, .type_name = {}};
}

// zlidar -> scan -> mapper -> map -> viewer; the viewer sends goals back to the mapper.
std::vector<KnownChannel> Channels() {
  KnownChannel scan{.name = "scan",
                    .type_name = "foxglove.LaserScan",
                    .publishers = {User(3, "zlidar")},
                    .subscribers = {User(1, "mapper")}};
  KnownChannel map{.name = "map",
                   .type_name = "foxglove.Grid",
                   .publishers = {User(1, "mapper")},
                   .subscribers = {User(2, "viewer", "desk")}};
  KnownChannel goal{.name = "goal",
                    .type_name = "foxglove.Pose",
                    .publishers = {User(2, "viewer", "desk")},
                    .subscribers = {User(1, "mapper")}};
  return {goal, map, scan};
}

AllCounters Counters() {
  auto mapper = std::make_shared<Snapshot>();
  Snapshot::Channel& map = *mapper->add_channels();
  map.set_name("map");
  map.set_rate_hz(2);
  Snapshot::Channel& scan = *mapper->add_channels();
  scan.set_name("scan");
  Snapshot::Node& node = *scan.add_nodes();
  node.set_name("match \x1b[31m");
  node.set_dropped(7);
  Snapshot::Peer& peer = *mapper->add_peers();
  peer.set_session(3);
  peer.set_transport("shared memory");
  return {{SessionId{1}, mapper}};
}

std::vector<std::string> NamesOf(const Hypergraph& graph) {
  std::vector<std::string> names;
  for (const Hypergraph::Process& process : graph.processes) names.push_back(process.name);
  return names;
}

TEST(Hypergraph, PutsSourcesFirstAlsoWithACycle) {
  const Hypergraph graph = Hypergraph::Of(Channels(), Counters());
  EXPECT_THAT(NamesOf(graph), ElementsAre("viewer:2", "zlidar:3", "mapper:1"));  // By host first.
  EXPECT_EQ(graph.processes[1].rank, 0U);
  EXPECT_EQ(graph.processes[2].rank, 1U);
  ASSERT_EQ(graph.channels.size(), 3U);
  const Hypergraph::Channel& scan = graph.channels[1];
  EXPECT_EQ(scan.name, "scan");
  ASSERT_EQ(scan.subscribers.size(), 1U);
  EXPECT_THAT(scan.subscribers[0].transports, ElementsAre("shared memory"));
  ASSERT_NE(graph.NodeOf(scan.subscribers[0]), nullptr);
  EXPECT_EQ(graph.NodeOf(scan.subscribers[0])->dropped, 7U);
}

TEST(Hypergraph, KeepsOnlyWhatIsNear) {
  const Hypergraph graph = Hypergraph::Of(Channels(), Counters());
  const auto near = graph.Around("zlidar", 1);
  ASSERT_TRUE(near);
  EXPECT_THAT(NamesOf(*near), ElementsAre("zlidar:3", "mapper:1"));
  ASSERT_EQ(near->channels.size(), 1U);
  EXPECT_EQ(near->channels[0].subscribers[0].process, 1U);
  EXPECT_EQ(graph.Around("zlidar", 2)->processes.size(), 3U);
  EXPECT_EQ(graph.Around("scan", 0)->channels.size(), 1U);
  EXPECT_EQ(graph.Around("match \x1b[31m", 0)->processes.size(), 1U);
  EXPECT_FALSE(graph.Around("nothing", 3));
}

TEST(Hypergraph, IsDrawnWithoutWhatATerminalOrXmlWouldObey) {
  std::vector<KnownChannel> channels = Channels();
  channels[2].name = "<scan>&\"\x1b[2J";
  const Hypergraph graph = Hypergraph::Of(channels, Counters());
  setenv("NO_COLOR", "1", 1);
  const Console console;
  for (const std::string& drawing : {DrawText(graph, console, {}), DrawDot(graph, {}), DrawSvg(graph, {})}) {
    EXPECT_THAT(drawing, Not(HasSubstr("\x1b")));
    EXPECT_THAT(drawing, HasSubstr("mapper:1"));
  }
  EXPECT_THAT(DrawSvg(graph, {}), HasSubstr("&lt;scan&gt;&amp;&quot;\\x1b[2J"));
  EXPECT_THAT(DrawDot(graph, {}), HasSubstr("\"<scan>&\\\"\\\\x1b[2J\""));
}

TEST(Hypergraph, OfNothingIsDrawn) {
  const Hypergraph graph = Hypergraph::Of({}, {});
  EXPECT_EQ(DrawText(graph, Console(), {}), "");
  EXPECT_THAT(DrawSvg(graph, {}), HasSubstr("</svg>"));
  EXPECT_THAT(DrawDot(graph, {}), HasSubstr("digraph"));
}

}  // namespace
}  // namespace hgros::cli
