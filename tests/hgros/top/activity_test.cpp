#include "top/activity.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace hgros::cli {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

// A session that has published `messages` of 100 bytes on "scan" and received as many on "odom", of which its node has
// dropped a tenth and took 5 ms for each.
std::shared_ptr<Snapshot> SnapshotAt(std::int64_t seconds, std::uint64_t messages) {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->set_session(1);
  snapshot->set_process("talker");
  snapshot->set_pid(42);
  snapshot->set_steady_ns(seconds * kSecondNs);
  snapshot->set_cpu_ns(seconds * kSecondNs / 4);
  snapshot->set_memory_bytes(2'000'000);
  Snapshot::Channel* odom = snapshot->add_channels();
  odom->set_name("odom");
  odom->set_received(messages);
  Snapshot::Node* node = odom->add_nodes();
  node->set_name("filter");
  node->set_run(messages);
  node->set_dropped(messages / 10);
  node->set_run_sum_ns(messages * 5'000'000);
  node->set_wait_p99_ns(7'000'000);
  Snapshot::Channel* scan = snapshot->add_channels();
  scan->set_name("scan");
  scan->set_published(messages);
  scan->set_rate_hz(19.8);
  scan->set_encoded(messages);
  scan->set_encoded_bytes(messages * 100);
  return snapshot;
}

std::vector<KnownChannel> BusyChannels() {
  const ChannelUser user{.session = {1}, .process = "talker", .host = "desk", .pid = 42, .type_name = {}};
  std::vector<KnownChannel> channels(3);
  channels[0].name = "hgros/snapshots";
  channels[0].publishers = {user};
  channels[1].name = "odom";
  channels[1].subscribers = {user};
  channels[2].name = "scan";
  channels[2].publishers = {user};
  return channels;
}

// What a column of the row shows.
std::string Shown(const TopRow& row, std::string_view key) {
  const std::vector<Column>& columns = TopColumns(row.kind);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].key == key) return row.cells[i].Shown();
  }
  return "no such column";
}

TEST(Activity, ShowsWhatItKnowsWithoutCountersThenOfOneSnapshotThenOfTheLastTwo) {
  Activity activity({}, false);
  activity.Update({}, BusyChannels());
  ASSERT_EQ(activity.Rows(TopKind::kSessions).size(), 1U);
  EXPECT_TRUE(activity.Rows(TopKind::kSessions).front().silent);
  EXPECT_EQ(Shown(activity.Rows(TopKind::kSessions).front(), "cpu_percent"), "");
  EXPECT_EQ(activity.Rows(TopKind::kSessions).front().cells.size(), TopColumns(TopKind::kSessions).size());

  AllCounters counters{{SessionId{1}, SnapshotAt(1000, 500)}};
  activity.Update(counters, BusyChannels());
  EXPECT_EQ(Shown(activity.Rows(TopKind::kSessions).front(), "cpu_percent"), "");
  EXPECT_EQ(Shown(activity.Rows(TopKind::kSessions).front(), "published_hz"), "19.8 Hz");
  EXPECT_EQ(Shown(activity.Rows(TopKind::kNodes).front(), "rate_hz"), "");

  counters[SessionId{1}] = SnapshotAt(1002, 540);
  activity.Update(counters, BusyChannels());

  ASSERT_EQ(activity.Rows(TopKind::kSessions).size(), 1U);
  const TopRow& session = activity.Rows(TopKind::kSessions).front();
  EXPECT_EQ(session.cells.front().Shown(), "talker:42");
  EXPECT_EQ(Shown(session, "process"), "talker");
  EXPECT_EQ(Shown(session, "host"), "desk");
  EXPECT_EQ(Shown(session, "cpu_percent"), "25.0 %");
  EXPECT_EQ(Shown(session, "run_percent"), "10.0 %");
  EXPECT_EQ(Shown(session, "wait_p99_ns"), "7.00 ms");
  EXPECT_EQ(Shown(session, "published_hz"), "19.8 Hz");
  EXPECT_EQ(Shown(session, "received_hz"), "20.0 Hz");
  EXPECT_EQ(Shown(session, "drops_hz"), "2.0");
  EXPECT_EQ(Shown(session, "dropped"), "54");

  ASSERT_EQ(activity.Rows(TopKind::kNodes).size(), 1U);
  const TopRow& node = activity.Rows(TopKind::kNodes).front();
  EXPECT_EQ(Shown(node, "node"), "filter");
  EXPECT_EQ(Shown(node, "process"), "talker");
  EXPECT_EQ(Shown(node, "pid"), "42");
  EXPECT_EQ(Shown(node, "rate_hz"), "20.0 Hz");
  EXPECT_EQ(Shown(node, "run_percent"), "10.0 %");

  ASSERT_EQ(activity.Rows(TopKind::kChannels).size(), 2U) << "Those of the library are hidden.";
  const TopRow& scan = activity.Rows(TopKind::kChannels).back();
  EXPECT_EQ(Shown(scan, "rate_hz"), "19.8 Hz");
  EXPECT_EQ(Shown(scan, "mean_bytes"), "100 B");
  EXPECT_EQ(Shown(scan, "bytes_per_second"), "1.98 kB/s");
}

TEST(Activity, ShowsTheSameRateOfASlowChannelEachSecond) {
  Activity activity({}, false);
  std::uint64_t published = 0;
  for (std::int64_t second = 0; second < 12; ++second) {
    if (second % 3 == 0) ++published;
    auto snapshot = SnapshotAt(1000 + second, published);
    snapshot->mutable_channels(1)->set_rate_hz(1.0 / 3);
    activity.Update({{SessionId{1}, snapshot}}, BusyChannels());
    EXPECT_EQ(Shown(activity.Rows(TopKind::kChannels).back(), "rate_hz"), "0.33 Hz") << second;
    EXPECT_EQ(Shown(activity.Rows(TopKind::kSessions).back(), "published_hz"), "0.33 Hz") << second;
  }
}

TEST(Activity, CallsASessionSilentWhenItsCountersStayTheSame) {
  Activity activity({}, false);
  const AllCounters counters{{SessionId{1}, SnapshotAt(1000, 500)}};
  for (int i = 0; i < 4; ++i) {
    activity.Update(counters, BusyChannels());
    EXPECT_FALSE(activity.Rows(TopKind::kSessions).front().silent) << i;
  }
  activity.Update(counters, BusyChannels());
  EXPECT_TRUE(activity.Rows(TopKind::kSessions).front().silent);
  EXPECT_EQ(Shown(activity.Rows(TopKind::kSessions).front(), "published_hz"), "");
}

TEST(Activity, TellsNodesOfTheSameNameApart) {
  auto before = SnapshotAt(1000, 500);
  *before->mutable_channels(0)->add_nodes() = before->channels(0).nodes(0);
  auto after = SnapshotAt(1001, 510);
  *after->mutable_channels(0)->add_nodes() = before->channels(0).nodes(0);
  Activity activity({}, false);
  activity.Update({{SessionId{1}, before}}, BusyChannels());
  activity.Update({{SessionId{1}, after}}, BusyChannels());
  const std::vector<TopRow>& nodes = activity.Rows(TopKind::kNodes);
  ASSERT_EQ(nodes.size(), 2U);
  EXPECT_NE(nodes[0].id, nodes[1].id);
  EXPECT_EQ(Shown(nodes[0], "rate_hz"), "10.0 Hz");
  EXPECT_EQ(Shown(nodes[1], "rate_hz"), "-");
}

}  // namespace
}  // namespace hgros::cli
