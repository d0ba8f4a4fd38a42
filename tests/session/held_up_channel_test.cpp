#include <gtest/gtest.h>

#include <string>

#include "session/domain_fixture.hpp"
#include "session/session_fixture.hpp"

namespace hgros {
namespace {

using test::Await;
using test::kPatience;
using test::kSerial;
using test::Note;
using test::Robot;

// The transport of the channel: shared_memory or zmq.
class HeldUpChannel : public test::DomainFixture, public testing::WithParamInterface<std::string> {};

INSTANTIATE_TEST_SUITE_P(Transports, HeldUpChannel, testing::Values("shared_memory", "zmq"),
                         [](const auto& one) { return one.param == "zmq" ? "Zmq" : "SharedMemory"; });

TEST_P(HeldUpChannel, IsLoggedWithTheSubscriberForWhichItWaits) {
  const test::Bus bus;
  const std::string rule = "channels: {notes: {transports: [" + GetParam() + "]}}\n";
  Robot talker(bus.Publishing("robot") + rule);
  Robot listener(bus.Subscribing("robot") + rule, "holder");
  test::Door door;
  const auto subscription = listener->FromAny<Note>("notes", kSerial, [&](const Note&) { door.Pass(); },
                                                    {{}, Queue::KeepAll(1), Executor::Dedicated()});
  const auto publish = talker->Advertise<Note>("notes");
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  EXPECT_TRUE(Await([&] {
    (void)publish(Note("x"));
    return talker.Said("Channel \"notes\" waits for ");
  }));
  EXPECT_TRUE(talker.Said("holder"));
  door.Open();
}

}  // namespace
}  // namespace hgros
