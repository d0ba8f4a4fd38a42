#include "hgros/session/snapshot_message.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace hgros {
namespace {

TEST(SnapshotMessage, ContainsEveryCounterOfASession) {
  SessionSnapshot counted;
  counted.id = {7};
  counted.name = "robot";
  NodeSnapshot node;
  node.name = "n";
  node.invoke = Invoke::kConcurrent;
  node.queue = Queue::KeepLast(3);
  node.received = 10;
  node.dropped = 2;
  node.run = 8;
  node.failed = 1;
  node.queued = 4;
  node.queue_wait.Record(1000);
  node.run_time.Record(2000);
  node.ages.push_back({9, {}});
  node.ages[0].age.Record(5000);
  node.ages[0].age.Record(7000);
  counted.graph.channels.push_back(
      {.name = "a", .type = "T", .published = 11, .refused = 12, .received = 13, .nodes = {node}});
  counted.graph.channels.push_back({.name = "inside", .type = "U", .published = 1, .nodes = {}});
  ChannelTraffic traffic;
  traffic.channel = "a";
  traffic.encoded = 41;
  traffic.encoded_bytes = 4200;
  traffic.out.sent = 21;
  traffic.out.subscribers = 2;
  traffic.out.dropped = 22;
  traffic.out.missed = 1;
  traffic.in = {{.publisher = {8}, .lost = 3}, {.publisher = {9}, .lost = 4}};
  traffic.faults[0] = 5;
  traffic.faults[1] = 6;
  traffic.transport.Record(3000);
  counted.traffic = {traffic};
  counted.services = {{"add", 31, 32}};

  const Snapshot told = ToMessage(counted);
  EXPECT_EQ(told.session(), 7U);
  EXPECT_EQ(told.process(), "robot");
  EXPECT_EQ(told.pid(), getpid());
  EXPECT_FALSE(told.host().empty());
  EXPECT_GT(told.time_ns(), 0);
  EXPECT_GT(told.steady_ns(), 0);
  ASSERT_EQ(told.channels_size(), 2);
  ASSERT_EQ(told.channels(0).nodes(0).ages_size(), 1);
  const Snapshot::ChainAge& ages = told.channels(0).nodes(0).ages(0);
  EXPECT_EQ(ages.origin(), 9U);
  EXPECT_EQ(ages.count(), 2U);
  EXPECT_GE(ages.p50_ns(), 5000);
  EXPECT_LE(ages.p50_ns(), 5625);
  EXPECT_EQ(ages.p99_ns(), 7000);
  EXPECT_EQ(ages.max_ns(), 7000);
  const Snapshot::Channel& a = told.channels(0);
  EXPECT_EQ(a.name(), "a");
  EXPECT_EQ(a.type(), "T");
  EXPECT_EQ(a.published(), 11U);
  EXPECT_EQ(a.refused(), 12U);
  EXPECT_EQ(a.received(), 13U);
  EXPECT_EQ(a.encoded(), 41U);
  EXPECT_EQ(a.encoded_bytes(), 4200U);
  EXPECT_EQ(a.sent(), 21U);
  EXPECT_EQ(a.subscribers(), 2U);
  EXPECT_EQ(a.send_dropped(), 23U);
  EXPECT_EQ(a.lost(), 7U);
  EXPECT_EQ(a.faults(), 11U);
  EXPECT_GE(a.transport_p50_ns(), 3000);
  ASSERT_EQ(a.nodes_size(), 1);
  EXPECT_EQ(a.nodes(0).name(), "n");
  EXPECT_FALSE(a.nodes(0).serial());
  EXPECT_FALSE(a.nodes(0).lossless());
  EXPECT_EQ(a.nodes(0).queue_depth(), 3U);
  EXPECT_EQ(a.nodes(0).received(), 10U);
  EXPECT_EQ(a.nodes(0).dropped(), 2U);
  EXPECT_EQ(a.nodes(0).run(), 8U);
  EXPECT_EQ(a.nodes(0).failed(), 1U);
  EXPECT_EQ(a.nodes(0).queued(), 4U);
  EXPECT_GE(a.nodes(0).wait_p50_ns(), 1000);
  EXPECT_GE(a.nodes(0).run_p99_ns(), 2000);
  EXPECT_EQ(told.channels(1).sent(), 0U) << "it has no transport";
  ASSERT_EQ(told.services_size(), 1);
  EXPECT_EQ(told.services(0).name(), "add");
  EXPECT_EQ(told.services(0).unhandled_requests(), 31U);
  EXPECT_EQ(told.services(0).dropped_replies(), 32U);
}

}  // namespace
}  // namespace hgros
