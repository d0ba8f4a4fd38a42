#include "graph/nodes/queued_node.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "graph/nodes/polled_node.hpp"

namespace hgros {
namespace {

// A publisher that has found the queue full waits for on_room.
TEST(QueuedNode, TellsOfTheRoomThatWasReservedBeforeItClosed) {
  int told = 0;
  NodeSetting setting;
  setting.queue = Queue::KeepAll(1);
  setting.executor = Executor::Polled();
  setting.on_room = [&told] { ++told; };
  PolledNode node(std::move(setting), [](const AnyMessage&, const MessageInfo&) {});
  ASSERT_TRUE(node.Reserve(0));
  node.Close(false);
  ASSERT_FALSE(node.Reserve(0)) << "The other publisher's message may still come.";
  const int before = told;
  AnyMessage message = std::make_shared<const int>(1);
  const MessageInfo info;
  const std::shared_ptr<const void> no_credit;
  std::int64_t now = 0;
  node.Deliver({message, info, no_credit}, true, now);
  EXPECT_EQ(told, before + 1);
  EXPECT_TRUE(node.Reserve(0));
}

}  // namespace
}  // namespace hgros
