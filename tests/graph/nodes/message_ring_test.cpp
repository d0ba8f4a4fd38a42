#include "graph/nodes/message_ring.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <random>

#include "support/seed.hpp"

namespace hgros {
namespace {

QueuedMessage Make(int value, std::size_t bytes = 0) {
  QueuedMessage message;
  message.message = std::make_shared<const int>(value);
  message.bytes = bytes;
  return message;
}

std::optional<QueuedMessage> Push(MessageRing& ring, QueuedMessage message) {
  return ring.Push({message.message, message.info, message.credit, message.bytes, true});
}

int ValueOf(const QueuedMessage& message) { return *static_cast<const int*>(message.message.get()); }

TEST(MessageRing, DropsOldestWhenQueueIsFull) {
  MessageRing ring(Queue::KeepLast(2));
  EXPECT_FALSE(Push(ring, Make(1)));
  EXPECT_FALSE(Push(ring, Make(2)));
  const auto dropped = Push(ring, Make(3));
  ASSERT_TRUE(dropped);
  EXPECT_EQ(ValueOf(*dropped), 1);
  EXPECT_EQ(ValueOf(ring.Pop()), 2);
  EXPECT_EQ(ValueOf(ring.Pop()), 3);
  EXPECT_TRUE(ring.empty());
}

TEST(MessageRing, KeepAllRefusesBeyondItsMessageLimit) {
  MessageRing ring(Queue::KeepAll(2));
  EXPECT_TRUE(ring.Reserve(0));
  EXPECT_TRUE(ring.Reserve(0));
  EXPECT_FALSE(ring.Reserve(0));
  ring.Cancel(0);
  EXPECT_TRUE(ring.Reserve(0));
}

TEST(MessageRing, KeepAllAcceptsASingleMessageOfAnySize) {
  MessageRing ring(Queue::KeepAll(100, 1000));
  EXPECT_TRUE(ring.Reserve(5000));
  ring.Cancel(5000);
  Push(ring, Make(1, 5000));
  EXPECT_FALSE(ring.Reserve(1));
  ring.Pop();
  EXPECT_TRUE(ring.Reserve(600));
  EXPECT_FALSE(ring.Reserve(600));
}

TEST(MessageRing, ReleasesPoppedMessages) {
  MessageRing ring(Queue::KeepLast(4));
  QueuedMessage message = Make(1);
  const std::weak_ptr<const void> watch = message.message;
  Push(ring, message);
  message.message.reset();
  EXPECT_FALSE(watch.expired());
  ring.Pop();
  EXPECT_TRUE(watch.expired());
}

TEST(MessageRing, PopsBlocksInOrder) {
  MessageRing ring(Queue::KeepAll(1000));
  for (int i = 0; i < 100; ++i) Push(ring, Make(i));
  EXPECT_EQ(ValueOf(ring.Pop()), 0);
  int pushed = 100;
  int next = 1;
  while (next < 300) {
    std::unique_ptr<MessageRing::Block> block = ring.PopBlock();
    ASSERT_FALSE(block->messages().empty());
    if (pushed < 300) Push(ring, Make(pushed++));  // While the popped block is in use.
    for (QueuedMessage& message : block->messages()) {
      ASSERT_EQ(ValueOf(message), next++);
      message.message.reset();
    }
    ASSERT_EQ(ring.size(), static_cast<std::size_t>(pushed - next));
    ring.GiveBack(std::move(block));
    while (pushed < 300 && pushed - next < 5) Push(ring, Make(pushed++));
  }
  EXPECT_TRUE(ring.empty());
}

TEST(MessageRing, BehavesAsANaiveModelUnderRandomOperations) {
  std::mt19937_64 random(test::Seed());
  for (int round = 0; round < 200; ++round) {
    const bool lossless = random() % 2 == 0;
    const std::size_t depth = 1 + random() % 20;
    const std::size_t limit = 1 + random() % 500;
    MessageRing ring(lossless ? Queue::KeepAll(depth, limit) : Queue::KeepLast(depth));
    std::deque<std::pair<int, std::size_t>> model;
    std::size_t model_bytes = 0;
    for (int i = 0; i < 300; ++i) {
      const std::size_t bytes = random() % 100;
      if (random() % 3 != 0) {
        const bool room = !lossless || model.empty() || (model.size() < depth && model_bytes + bytes <= limit);
        ASSERT_EQ(ring.Reserve(bytes), room);
        if (!room) continue;
        ring.Cancel(bytes);
        const auto dropped = Push(ring, Make(i, bytes));
        if (!lossless && model.size() == depth) {
          ASSERT_TRUE(dropped);
          ASSERT_EQ(ValueOf(*dropped), model.front().first);
          model_bytes -= model.front().second;
          model.pop_front();
        } else {
          ASSERT_FALSE(dropped);
        }
        const std::size_t counted = lossless ? bytes : 0;  // A keep-last queue has no byte limit.
        model.emplace_back(i, counted);
        model_bytes += counted;
      } else if (!model.empty()) {
        ASSERT_EQ(ValueOf(ring.Pop()), model.front().first);
        model_bytes -= model.front().second;
        model.pop_front();
      }
      ASSERT_EQ(ring.size(), model.size());
      ASSERT_EQ(ring.bytes(), model_bytes);
    }
  }
}

}  // namespace
}  // namespace hgros
