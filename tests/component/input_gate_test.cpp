#include "component/input_gate.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <cstdint>

#include <foxglove/PoseInFrame.pb.h>

#include "graph/graph_fixture.hpp"
#include "hgros/codec/message.hpp"

namespace hgros::test {
namespace {

using testing::ElementsAre;

// Messages of one publisher, which is in another process, or in this one.
class InputGateTest : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static InputGate::Waiting Message(std::uint64_t number) {
    InputGate::Waiting message{std::make_shared<foxglove::PoseInFrame>(), {}};
    message.info.id = {.publisher = 7, .incarnation = 1, .sequence = GetParam() ? number + 100 : number};
    message.info.number = number;
    message.info.remote = GetParam();
    return message;
  }
  void Take(std::uint64_t number) {
    const InputGate::Waiting message = Message(number);
    gate_.Take(message.message, message.info);
  }

  std::vector<std::uint64_t> handled_;
  InputGate gate_{"relay/in",
                  TypeOf<foxglove::PoseInFrame>(),
                  Invoke::kConcurrent,
                  Queue(),
                  [this](const AnyMessage&, const MessageInfo& info) { handled_.push_back(info.number); },
                  std::make_shared<ComponentGuard>(true, std::chrono::nanoseconds(0), nullptr, nullptr)};
};

TEST_P(InputGateTest, KnowsWhichMessagesWereOvertaken) {
  for (const std::uint64_t number : {1U, 2U, 6U, 4U}) Take(number);
  const auto positions = gate_.Positions();
  ASSERT_EQ(positions.size(), 1U);
  EXPECT_EQ(positions.front().last.number, 6U);
  for (const std::uint64_t number : {1U, 2U, 3U, 4U, 5U, 6U, 7U}) {
    EXPECT_EQ(positions.front().gaps.Has(number), number == 3 || number == 5) << number;
  }
}

// Several threads bring messages of a concurrent input, so a late one can come behind a newer one.
TEST_P(InputGateTest, HandlesEachMessageOnceAfterAMove) {
  gate_.Hold([] {}, InputGate::Full::kWaits);
  for (const std::uint64_t number : {1U, 2U, 3U, 5U}) gate_.LetPass(Message(number));  // From the other place.
  gate_.Pass([](const InputGate::Waiting&) {}, true);
  handled_.clear();
  for (const std::uint64_t number : {7U, 5U, 4U, 3U, 6U}) Take(number);
  EXPECT_THAT(handled_, ElementsAre(7, 4, 6));
  gate_.Hold([] {}, InputGate::Full::kWaits);  // It moves on.
  Take(2);
  EXPECT_FALSE(gate_.Next()) << "It would be handed over and handled again.";
}

INSTANTIATE_TEST_SUITE_P(Publisher, InputGateTest, testing::Bool(),
                         [](const auto& one) { return one.param ? "elsewhere" : "here"; });

// A callback that is slower than its publisher, on a thread of its own.
class SlowInputGate : public testing::TestWithParam<Queue> {
 protected:
  SlowInputGate() { gate_.Join(subscription_); }
  ~SlowInputGate() override { pass_ = true; }

  [[nodiscard]] bool Publish(int number) {
    return graph_.ToGraph("c", std::make_unique<int>(number)) == PublishStatus::kOk;
  }
  [[nodiscard]] std::vector<int> handled() const {
    const std::scoped_lock lock(mutex_);
    return handled_;
  }
  void LetAllPass() {
    gate_.Pass([this](InputGate::Waiting one) { gate_.LetPass(std::move(one)); }, true);
  }

  mutable std::mutex mutex_;
  std::vector<int> handled_;
  std::atomic<bool> begun_ = false;
  std::atomic<bool> pass_ = false;
  InputGate gate_{"relay/in",
                  TypeOf<int>(),
                  Invoke::kSerial,
                  GetParam(),
                  [this](const AnyMessage& message, const MessageInfo&) {
                    begun_ = true;
                    pass_.wait(false);
                    const std::scoped_lock lock(mutex_);
                    handled_.push_back(*static_cast<const int*>(message.get()));
                  },
                  std::make_shared<ComponentGuard>(true, std::chrono::nanoseconds(0), nullptr, nullptr)};
  DataGraph graph_;
  Subscription subscription_ = graph_.FromGraph<int>(
      "c", Invoke::kSerial,
      [this](const std::shared_ptr<const int>& message, const MessageInfo& info) { gate_.Take(message, info); },
      Options(Executor::Dedicated(), GetParam()));
};

// Many have waited, as during a move. It handles some of them for a moment, then its queue is as long as ever.
TEST_P(SlowInputGate, WorksOffWhatHasWaitedByItself) {
  gate_.Hold([] {}, InputGate::Full::kWaits);
  int sent = 0;
  const auto queued = [this] { return subscription_.stats().queued; };
  if (GetParam().lossless()) {
    ASSERT_TRUE(Await([&] {
      while (Publish(sent)) ++sent;
      return queued() == 5;
    }));
    EXPECT_LE(sent, 3 * 5) << "its limit holds while messages wait, too";
  } else {
    for (; sent < 200; ++sent) ASSERT_TRUE(Publish(sent) && Await([&] { return queued() == 0; }));
  }
  LetAllPass();  // Does not wait for the callback.
  EXPECT_TRUE(handled().empty());
  const auto late = std::chrono::steady_clock::now() + std::chrono::milliseconds(150);
  ASSERT_TRUE(Await([late] { return std::chrono::steady_clock::now() > late; }));
  pass_ = true;
  pass_.notify_all();
  ASSERT_TRUE(Await([&] { return !handled().empty() && handled().back() == sent - 1; }));
  if (GetParam().lossless()) {
    EXPECT_EQ(handled(), Counting(0, sent));
  } else {
    std::vector<int> newest = Counting(sent - static_cast<int>(GetParam().depth()), sent);
    newest.insert(newest.begin(), 0);  // It had begun.
    EXPECT_EQ(handled(), newest);
    EXPECT_EQ(subscription_.stats().dropped, static_cast<std::size_t>(sent) - newest.size());
  }
}

INSTANTIATE_TEST_SUITE_P(Queues, SlowInputGate, testing::Values(Queue::Latest(), Queue::KeepLast(3), Queue::KeepAll(5)),
                         [](const auto& one) {
                           return (one.param.lossless() ? "all" : "last") + std::to_string(one.param.depth());
                         });

class LosslessInputGate : public SlowInputGate {};

TEST_P(LosslessInputGate, HandlesInOrderWhatComesMeanwhile) {
  gate_.Hold([] {}, InputGate::Full::kWaits);
  int sent = 0;
  for (; sent < 3; ++sent) ASSERT_TRUE(Publish(sent));
  ASSERT_TRUE(Await([&] { return subscription_.stats().queued == 0; }));
  LetAllPass();
  ASSERT_TRUE(Await([&] { return begun_.load(); }));
  for (; sent < 5; ++sent) ASSERT_TRUE(Publish(sent));
  gate_.Hold([] {}, InputGate::Full::kWaits);  // Again, before all were handled.
  pass_ = true;
  pass_.notify_all();
  ASSERT_TRUE(Await([&] { return !handled().empty(); }));
  ASSERT_TRUE(Await([&] { return subscription_.stats().queued == 0; }));
  LetAllPass();
  for (; sent < 10; ++sent) ASSERT_TRUE(Await([&] { return Publish(sent); }));
  ASSERT_TRUE(Await([&] { return handled().size() == 10; }));
  EXPECT_EQ(handled(), Counting(0, 10));
}

TEST_P(LosslessInputGate, ManyThatWaitAgainHoldUpNoThread) {
  gate_.Hold([] {}, InputGate::Full::kWaits);
  for (int i = 0; i < 10; ++i) gate_.LetPass({std::make_shared<const int>(i), {}});
  ASSERT_TRUE(Await([&] { return begun_.load(); }));
  gate_.Hold([] {}, InputGate::Full::kWaits);
  pass_ = true;
  pass_.notify_all();
  ASSERT_TRUE(Await([&] { return handled().size() == 1; }));
  for (int i = 10; i < 15; ++i) ASSERT_TRUE(Await([&] { return Publish(i); })) << i;
  EXPECT_FALSE(Publish(15)) << "those before it wait in the queue";
  LetAllPass();
  ASSERT_TRUE(Await([&] { return handled().size() == 15; }));
  EXPECT_EQ(handled(), Counting(0, 15));
}

INSTANTIATE_TEST_SUITE_P(Queues, LosslessInputGate, testing::Values(Queue::KeepAll(5)));

}  // namespace
}  // namespace hgros::test
