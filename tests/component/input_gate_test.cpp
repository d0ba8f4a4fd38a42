#include "component/input_gate.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include <foxglove/PoseInFrame.pb.h>

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
  InputGate gate_{"relay/in", TypeOf<foxglove::PoseInFrame>(), true,
                  [this](const AnyMessage&, const MessageInfo& info) { handled_.push_back(info.number); },
                  std::make_shared<ComponentGuard>(true, std::chrono::nanoseconds(0), nullptr, nullptr)};
};

TEST_P(InputGateTest, KnowsWhichMessagesWereOvertaken) {
  for (const std::uint64_t number : {1, 2, 6, 4}) Take(number);
  const auto positions = gate_.Positions();
  ASSERT_EQ(positions.size(), 1U);
  EXPECT_EQ(positions.front().last.number, 6U);
  for (const std::uint64_t number : {1, 2, 3, 4, 5, 6, 7}) {
    EXPECT_EQ(positions.front().gaps.Has(number), number == 3 || number == 5) << number;
  }
}

// Several threads bring messages of a concurrent input, so a late one can come behind a newer one.
TEST_P(InputGateTest, HandlesEachMessageOnceAfterAMove) {
  gate_.Hold([] {}, InputGate::Full::kWaits);
  for (const std::uint64_t number : {1, 2, 3, 5}) gate_.Handle(Message(number));  // From the other place.
  gate_.Pass([](const InputGate::Waiting&) {}, true);
  handled_.clear();
  for (const std::uint64_t number : {7, 5, 4, 3, 6}) Take(number);
  EXPECT_THAT(handled_, ElementsAre(7, 4, 6));
  gate_.Hold([] {}, InputGate::Full::kWaits);  // It moves on.
  Take(2);
  EXPECT_FALSE(gate_.Next()) << "It would be handed over and handled again.";
}

INSTANTIATE_TEST_SUITE_P(Publisher, InputGateTest, testing::Bool(),
                         [](const auto& one) { return one.param ? "elsewhere" : "here"; });

}  // namespace
}  // namespace hgros::test
