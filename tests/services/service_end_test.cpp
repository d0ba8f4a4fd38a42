// The end of a service and of its session.
#include <stdexcept>

#include "services/services_fixture.hpp"

namespace hgros::test {
namespace {

class ServiceEnd : public DomainFixture {};

// Other threads use the service's inner parts meanwhile, as discovery does.
TEST_F(ServiceEnd, DestroysTheHandlersCaptures) {
  Session session;
  std::atomic<bool> done{false};
  std::thread looks([&] {
    while (!done) (void)session.Snapshot();
  });
  for (int round = 0; round < 2000; ++round) {
    const auto held = std::make_shared<int>(round);
    Service service = session.Serve<Sum, Total>("add", [held](const Sum& sum) { return Add(sum); });
    service.Reset();
    EXPECT_EQ(held.use_count(), 1) << "round " << round;
  }
  done = true;
  looks.join();
}

TEST_F(ServiceEnd, InsideTheHandlerDestroysItsCapturesLater) {
  Session session;
  auto held = std::make_shared<int>(0);
  const std::weak_ptr<int> alive = held;
  Service service;
  service = session.Serve<Sum, Total>("add", [held = std::move(held), &service](const Sum& sum) {
    service.Reset();
    return Total{*held + Add(sum).value};  // Its captures are still here.
  });
  (void)session.Call<Sum, Total>("add", Sum{}, kLong).Wait();
  EXPECT_TRUE(Await([&] { return alive.expired(); }));
}

TEST_F(ServiceEnd, OfTheSessionFailsPendingCalls) {
  auto session = std::make_unique<Session>();
  Door door;
  std::atomic<bool> begun{false};
  const Service service = session->Serve<Sum, Total>("slow", [&](const Sum& sum) {
    begun = true;
    door.Pass();
    return Add(sum);
  });
  const auto call = session->Call<Sum, Total>("slow", Sum{}, kLong);
  ASSERT_TRUE(Await([&] { return begun.load(); }));
  std::jthread end([&] { session.reset(); });
  EXPECT_EQ(call.Wait().failure().kind, Kind::kClosed);
  door.Open();
  end.join();
  EXPECT_TRUE(call.done());
}

TEST_F(ServiceEnd, OfTheSessionLogsWhatTheCallbacksOfItsCallsThrow) {
  Robot robot({}, "caller");
  const auto throwing = [](const CallResult<Total>& result) {
    if (!result) throw std::runtime_error(result.failure().reason);
  };
  (void)robot.session->Call<Sum, Total>("unserved", Sum{}, kLong, throwing);
  (void)robot.session->Call<Sum, Total>("unserved", Sum{}, kLong, [](const CallResult<Total>&) { throw 7; });
  robot.session.reset();
  EXPECT_TRUE(robot.Said("The session ended while"));
  EXPECT_TRUE(robot.Said("something that is not a std::exception"));
}

TEST_F(ServiceEnd, ACallbackThatThrowsIsLoggedWithItsService) {
  Robot robot("discovery: {local: false}", "caller");
  const Service service = robot.session->Serve<Sum, Total>("add", Add);
  (void)robot.session->Call<Sum, Total>("add", Sum{}, kLong,
                                        [](const CallResult<Total>&) { throw std::runtime_error("no use"); });
  EXPECT_TRUE(Await(
      [&] { return robot.Said("The callback of a call of service \"add\" threw: no use. The call has ended."); }));
  EXPECT_FALSE(robot.Said("hgros/answers"));
}

}  // namespace
}  // namespace hgros::test
