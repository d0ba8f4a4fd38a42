#include "hgros/graph/ready_node_slot.hpp"

#include <optional>

#include "graph/graph_fixture.hpp"

namespace hgros::test {
namespace {

class ReadyNodeSlotTest : public testing::Test {
 protected:
  /// A node that counts its runs and notes the thread of the last one.
  struct Node {
    std::atomic<int> count{0};
    std::atomic<std::thread::id> thread;
    Subscription subscription;
  };
  void Subscribe(Node& node, const std::string& channel, Executor executor = Executor::Tbb()) {
    const auto record = [&node](const int&) {
      node.thread = std::this_thread::get_id();
      ++node.count;
    };
    node.subscription = graph.FromGraph<int>(channel, Invoke::kSerial, record, Options(std::move(executor)));
  }
  void Publish(const std::string& channel) { (void)graph.ToGraph(channel, std::make_unique<int>(1)); }
  [[nodiscard]] static bool RanHere(const Node& node) { return node.thread == std::this_thread::get_id(); }

  ReadyNodeSlotTest() {
    Subscribe(one, "one");
    Subscribe(two, "two");
  }

  DataGraph graph;
  Node one, two;
};

TEST_F(ReadyNodeSlotTest, RunsTheFirstReadyNodeOnlyInRunKept) {
  ReadyNodeSlot slot(true);
  Publish("one");
  Publish("two");
  EXPECT_TRUE(Await([&] { return two.count == 1; }));
  EXPECT_EQ(one.count, 0);
  slot.RunKept();
  EXPECT_EQ(one.count, 1);
  EXPECT_TRUE(RanHere(one));
  EXPECT_FALSE(RanHere(two)) << "a worker ran it";
  Publish("one");
  EXPECT_TRUE(Await([&] { return one.count == 2; }));
  EXPECT_FALSE(RanHere(one)) << "the slot is closed";
}

TEST_F(ReadyNodeSlotTest, WorkerRunsHandedOverAndAbandonedNodes) {
  Node node;
  Subscribe(node, "c");
  {
    ReadyNodeSlot slot(true);
    Publish("c");
    slot.HandToWorkers();
    EXPECT_TRUE(Await([&] { return node.count == 1; }));
    // Before its callback has returned, its thread would take the next message, too.
    ASSERT_TRUE(WaitIdle(graph));
    Publish("c");
    EXPECT_EQ(node.count, 1) << "the slot keeps a node again";
  }
  EXPECT_TRUE(Await([&] { return node.count == 2; }));
  EXPECT_FALSE(RanHere(node));
  ReadyNodeSlot unwanted(false);
  Publish("c");
  EXPECT_TRUE(Await([&] { return node.count == 3; }));
}

TEST_F(ReadyNodeSlotTest, OnlyOneThreadKeepsANodeAtATime) {
  ReadyNodeSlot slot(true);
  Publish("one");
  std::jthread([&] {
    ReadyNodeSlot second(true);
    Publish("two");
    EXPECT_TRUE(Await([&] { return two.count == 1; })) << "a worker must run it";
    EXPECT_FALSE(RanHere(two));
  }).join();
  slot.RunKept();
  EXPECT_TRUE(RanHere(one));
}

TEST_F(ReadyNodeSlotTest, WorkersRunNodesThatTheKeptNodeMakesReady) {
  Node next;
  Subscribe(next, "next");
  const auto subscription = graph.FromGraph<int>("first", Invoke::kSerial, [&](const int&) {
    Publish("next");
    EXPECT_TRUE(Await([&] { return next.count == 1; }));
  });
  ReadyNodeSlot slot(true);
  Publish("first");
  slot.RunKept();
  EXPECT_EQ(next.count, 1);
  EXPECT_FALSE(RanHere(next));
}

TEST_F(ReadyNodeSlotTest, OpenedKeepsANodeInAClosedSlot) {
  ReadyNodeSlot slot(false);
  {
    const ReadyNodeSlot::Opened opened;
    Publish("one");
  }
  Publish("two");
  EXPECT_TRUE(Await([&] { return two.count == 1; })) << "the slot is closed again";
  EXPECT_EQ(one.count, 0);
  slot.RunKept();
  EXPECT_EQ(one.count, 1);
  EXPECT_TRUE(RanHere(one));
  EXPECT_FALSE(RanHere(two));
}

TEST_F(ReadyNodeSlotTest, OpenedDoesNotCloseASlotThatWasOpen) {
  Node node;
  Subscribe(node, "c");
  ReadyNodeSlot slot(true);
  { const ReadyNodeSlot::Opened opened; }
  Publish("c");
  EXPECT_EQ(node.count, 0) << "the slot is still open";
  slot.RunKept();
  EXPECT_TRUE(RanHere(node));
}

TEST_F(ReadyNodeSlotTest, OpenedDoesNothingWithoutASlot) {
  Node node;
  Subscribe(node, "c");
  const ReadyNodeSlot::Opened lonely;
  Publish("c");
  EXPECT_TRUE(Await([&] { return node.count == 1; }));
  EXPECT_FALSE(RanHere(node));
  ReadyNodeSlot slot(false);
  slot.RunKept();
  const ReadyNodeSlot::Opened late;
  Publish("c");
  EXPECT_TRUE(Await([&] { return node.count == 2; })) << "it has run the kept node, and keeps no further one";
}

TEST_F(ReadyNodeSlotTest, DoesNotRunANodeThatHasEnded) {
  std::optional<Node> node(std::in_place);
  Subscribe(*node, "c");
  ReadyNodeSlot slot(true);
  Publish("c");
  node->subscription = {};
  slot.RunKept();
  EXPECT_EQ(node->count, 0);
}

TEST_F(ReadyNodeSlotTest, ChannelRequestsRunNodeOnlyIfAWorkerWouldHaveToBeWoken) {
  Channel& channel = graph.Open("c", TypeOf<int>(), CallSite::Current());
  EXPECT_EQ(DataGraph::UseOfThread(channel), ThreadUse::kNone);
  CountingDoor door;
  const auto subscription = graph.FromGraph<int>("c", Invoke::kSerial, [&](const int&) { door.Pass(); });
  EXPECT_EQ(DataGraph::UseOfThread(channel), ThreadUse::kRunNode);
  Publish("c");
  ASSERT_TRUE(door.AwaitOne());
  EXPECT_EQ(DataGraph::UseOfThread(channel), ThreadUse::kNone) << "the node already runs";
  door.Open();
  EXPECT_TRUE(Await([&] { return DataGraph::UseOfThread(channel) == ThreadUse::kRunNode; }));
  Node immediate;
  Subscribe(immediate, "c", Executor::Inline());
  EXPECT_EQ(DataGraph::UseOfThread(channel), ThreadUse::kInline);
}

}  // namespace
}  // namespace hgros::test
