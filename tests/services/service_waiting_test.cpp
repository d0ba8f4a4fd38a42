// Waiting for replies inside callbacks, with as few threads as possible.
#include "services/services_fixture.hpp"

namespace hgros::test {
namespace {

const std::string kAlone = "discovery: {local: false}\ndata_graph: {threads: 1}\n";

struct Hosting {
  std::string name;
  Executor executor;
  Invoke invoke;
};

class WaitingInACallback : public DomainFixture, public testing::WithParamInterface<Hosting> {
 protected:
  [[nodiscard]] static NodeOptions Options() { return {.executor = GetParam().executor}; }
  [[nodiscard]] static bool HandlesOneAtATime() {
    return GetParam().invoke == Invoke::kSerial || GetParam().executor.kind() == Executor::Kind::kDedicated;
  }
};

TEST_P(WaitingInACallback, ReceivesTheReplyOfAServiceOfItsOwnSession) {
  Robot robot(kAlone);
  const Service service = robot->Serve<Sum, Total>("add", Add, GetParam().invoke, Options());
  for (const Executor& executor : {Executor::Tbb(), Executor::Inline(), Executor::Dedicated()}) {
    std::atomic<int> sum{0};
    const auto call = [&](const Sum& in) {
      const auto result = robot->Call<Sum, Total>("add", in, kLong).Wait();
      sum = result ? result->value : -1;
    };
    const auto node = robot->FromAny<Sum>("in", Invoke::kSerial, call, {.executor = executor});
    robot->ToAny("in", Sum{4, 5});
    EXPECT_TRUE(Await([&] { return sum == 9; })) << sum;
  }
  std::atomic<int> sum{0};  // In the callback of a call.
  robot->Call<Sum, Total>("add", Sum{1, 1}, kLong, [&](const CallResult<Total>& first) {
    const auto second = robot->Call<Sum, Total>("add", Sum{first->value, 1}, kLong).Wait();
    sum = second ? second->value : -1;
  });
  EXPECT_TRUE(Await([&] { return sum == 3; })) << sum;
  const auto call_twice = [&](const Sum& in) {  // In the handler of another service.
    const auto once = robot->Call<Sum, Total>("add", in, kLong).Wait();
    return Total{once ? 2 * once->value : -1};
  };
  const Service twice = robot->Serve<Sum, Total>("twice", call_twice, GetParam().invoke, Options());
  const auto outer = robot->Call<Sum, Total>("twice", Sum{2, 3}, kLong).Wait();
  ASSERT_TRUE(outer);
  EXPECT_EQ(outer->value, 10);
}

TEST_P(WaitingInACallback, ForItsOwnServiceWorksOrFailsAtOnce) {
  Robot robot(kAlone);
  std::atomic<int> refused{0};
  const auto add_rest = [&](const Sum& to) {
    if (to.a == 0) return Total{0};
    const auto rest = robot->Call<Sum, Total>("sum", Sum{to.a - 1, 0}, kLong).Wait();
    if (!rest) {
      EXPECT_EQ(rest.failure().kind, Kind::kWouldDeadlock) << rest.failure().reason;
      ++refused;
      return Total{-1};
    }
    return Total{to.a + rest->value};
  };
  const Service sum_up = robot->Serve<Sum, Total>("sum", add_rest, GetParam().invoke, Options());
  const auto result = robot->Call<Sum, Total>("sum", Sum{40, 0}, kLong).Wait();
  ASSERT_TRUE(result) << result.failure().reason;
  EXPECT_EQ(result->value, HandlesOneAtATime() ? -1 : 40 * 41 / 2);
  EXPECT_EQ(refused, HandlesOneAtATime() ? 1 : 0);
}

TEST_P(WaitingInACallback, EndsInManyHandlersAtOnce) {
  Robot robot(kAlone);
  const Service add = robot->Serve<Sum, Total>("add", Add, GetParam().invoke, Options());
  const auto call_add = [&](const Sum& sum) {
    const auto inner = robot->Call<Sum, Total>("add", sum, kLong).Wait();
    return inner ? *inner : Total{-1};
  };
  const Service outer = robot->Serve<Sum, Total>("outer", call_add, Invoke::kConcurrent);
  std::vector<CallFuture<Total>> calls;
  for (int i = 0; i < 2000; ++i) calls.push_back(robot->Call<Sum, Total>("outer", Sum{i, 1}, kLong));
  for (int i = 0; i < 2000; ++i) ASSERT_EQ(calls[static_cast<std::size_t>(i)].Wait()->value, i + 1);
}

TEST_P(WaitingInACallback, EndsWhenTheOtherSessionCallsBack) {
  Robot left("data_graph: {threads: 1}\n", "left");
  Robot right("data_graph: {threads: 1}\n", "right");
  const Service add = left->Serve<Sum, Total>("add", Add, GetParam().invoke, Options());
  const auto call_add = [&](const Sum& sum) {
    const auto there = right->Call<Sum, Total>("add", sum, kLong).Wait();
    return there ? *there : Total{-1};
  };
  const Service forward = right->Serve<Sum, Total>("forward", call_add, GetParam().invoke, Options());
  std::atomic<int> sum{0};
  // Occupies the only worker of the left session until the right session has called back.
  const auto node = left->FromAny<Sum>("in", Invoke::kSerial, [&](const Sum& in) {
    const auto result = left->Call<Sum, Total>("forward", in, kLong).Wait();
    sum = result ? result->value : -1;
  });
  left->ToAny("in", Sum{2, 6});
  EXPECT_TRUE(Await([&] { return sum == 8; })) << sum;
}

INSTANTIATE_TEST_SUITE_P(Hosted, WaitingInACallback,
                         testing::Values(Hosting{"tbbserial", Executor::Tbb(), Invoke::kSerial},
                                         Hosting{"tbbconcurrent", Executor::Tbb(), Invoke::kConcurrent},
                                         Hosting{"inlineserial", Executor::Inline(), Invoke::kSerial},
                                         Hosting{"inlineconcurrent", Executor::Inline(), Invoke::kConcurrent},
                                         Hosting{"dedicatedserial", Executor::Dedicated(), Invoke::kSerial},
                                         Hosting{"dedicatedconcurrent", Executor::Dedicated(), Invoke::kConcurrent}),
                         [](const auto& hosted) { return hosted.param.name; });

}  // namespace
}  // namespace hgros::test
