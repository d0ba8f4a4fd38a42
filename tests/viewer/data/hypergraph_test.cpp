#include "viewer/data/hypergraph.hpp"

#include <gtest/gtest.h>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

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

TEST(Hypergraph, ConnectsProcessesByTheirChannels) {
  SessionSnapshot own;
  own.id = {1};
  NodeSnapshot node;
  node.dropped = 5;
  own.graph.channels.push_back({.name = "scan", .type = "T", .nodes = {node}});
  const auto graph = MakeHypergraph({Channel("scan", {User(2, "lidar")}, {User(1, "viewer"), User(3, "slam")}),
                                     Channel("map", {User(3, "slam")}, {})},
                                    own, Inner::kLeftOut);
  ASSERT_EQ(graph.processes.size(), 3U);
  EXPECT_EQ(graph.processes[0].name, "lidar");
  EXPECT_EQ(graph.processes[2].name, "viewer");
  EXPECT_TRUE(graph.processes[2].own);
  ASSERT_EQ(graph.channels.size(), 2U);
  ASSERT_EQ(graph.lines.size(), 4U);
  EXPECT_TRUE(graph.lines[0].publishes);
  EXPECT_EQ(graph.lines[0].process, 0U);
  EXPECT_EQ(graph.lines[1].dropped, 5U) << "by the viewer's own node";
  EXPECT_EQ(graph.lines[2].dropped, 0U);
  EXPECT_EQ(graph.lines[3].channel, 1U);
}

TEST(Hypergraph, CutsLongNamesOfProcesses) {
  const auto graph = MakeHypergraph({Channel("scan", {User(2, std::string(60'000, 'x'))}, {})}, {}, Inner::kLeftOut);
  ASSERT_EQ(graph.processes.size(), 1U);
  EXPECT_EQ(graph.processes[0].name.size(), kMaxShownBytes);
}

TEST(Hypergraph, LeavesOutWhatIsTheLibrarysOwn) {
  const std::vector<KnownChannel> channels{Channel("hgros/call/add", {}, {User(2, "server")})};
  EXPECT_TRUE(MakeHypergraph(channels, {}, Inner::kLeftOut).processes.empty());
  EXPECT_EQ(MakeHypergraph(channels, {}, Inner::kShown).lines.size(), 1U);
}

TEST(Hypergraph, MarksChannelsOnWhichTypesDiffer) {
  const auto graph = MakeHypergraph(
      {Channel("a", {User(1, "x")}, {User(2, "y", "Other")}), Channel("b", {User(1, "x")}, {User(2, "y", "")})}, {},
      Inner::kShown);
  EXPECT_TRUE(graph.channels[0].types_differ);
  EXPECT_FALSE(graph.channels[1].types_differ) << "who takes any type fits";
}

}  // namespace
}  // namespace hgros::viewer
