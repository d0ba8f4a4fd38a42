// Running sessions that others change: how their logs, their programs and hanging callbacks take part.
#include "session/control/steering.hpp"

#include <gmock/gmock.h>
#include <signal.h>

#include <array>
#include <atomic>
#include <functional>

#include "hgros/base/error.hpp"
#include "hgros/session/session_control.hpp"
#include "hgros/session/session_parts.hpp"
#include "session/domain_fixture.hpp"
#include "session/session_core.hpp"

namespace hgros::steering_test {
namespace {

using test::Await;
using test::kPatience;
using test::kSerial;
using test::Note;
using test::Robot;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class SteeringTest : public test::DomainFixture {
 protected:
  static ControlAnswer Order(Robot& from, const Robot& robot, const ControlOrder& order) {
    const std::array asked{robot.session->id()};
    return AskSessions(*from.session, asked, order, kPatience).at(0);
  }
};

std::string WhyRefused(const std::function<void()>& use) {
  try {
    use();
  } catch (const Error& error) {
    return error.what();
  }
  return "not refused";
}

TEST_F(SteeringTest, ProgramCannotUseTheChannelOfRequests) {
  Robot robot("");
  Robot other("", "other");
  const auto publish = robot->Advertise<Note>("notes");
  const auto says_what_to_use = AllOf(HasSubstr("hgros control"), HasSubstr("control: off"));
  const auto ignore = [](const Note&) {};
  for (int i = 0; i < 2; ++i) {
    EXPECT_THAT(WhyRefused([&] { (void)robot->FromAny<Note>("hgros/control", kSerial, ignore); }), says_what_to_use);
  }
  EXPECT_THAT(WhyRefused([&] { (void)robot->AwaitSchema("hgros/control", std::chrono::nanoseconds(0)); }),
              says_what_to_use);
  EXPECT_THAT(WhyRefused([&] { (void)robot->Advertise<Note>("hgros/control"); }), HasSubstr("belongs to the library"));
  EXPECT_THAT(WhyRefused([&] { (void)robot->Advertise<Note>("hgros/control/replies"); }),
              HasSubstr("belongs to the library"));
  for (const ChannelSnapshot& channel : robot->Snapshot().graph.channels) {
    EXPECT_THAT(channel.name, Not(StartsWith("hgros/control")));
  }
  EXPECT_TRUE(Order(other, robot, {ControlAction::kClose, "notes", {}}).answered);
  EXPECT_TRUE(Order(robot, other, {ControlAction::kClose, "notes", {}}).answered);
}

TEST_F(SteeringTest, SubscriptionThatFailsLeavesNothingBehind) {
  Robot robot("");
  Robot other("", "other");
  const auto first = robot->Advertise<Note>("first");
  ServicePlace& place = SessionParts(*robot.session).core().place();
  for (int i = 0; i < 2; ++i) {  // The desk subscribes to it already.
    EXPECT_THROW((void)place.Listen(
                     "hgros/control", TypeOf<ControlRequest>(), [](const AnyMessage&, const MessageInfo&) {}, 1),
                 Error);
  }
  const auto second = robot->Advertise<Note>("second");
  const auto lists = [&](const std::string& name) {
    const auto channels = other->Channels();
    return std::ranges::find(channels, name, &KnownChannel::name) != channels.end();
  };
  EXPECT_TRUE(Await([&] { return lists("second"); }));
  EXPECT_FALSE(lists("hgros/control"));
}

TEST_F(SteeringTest, LogSaysWhoHasChangedWhatAtEveryLevel) {
  Robot robot("");
  Robot owner("", "owner");
  const auto publish = robot->Advertise<Note>("notes");
  EXPECT_TRUE(Order(owner, robot, {ControlAction::kLog, {}, LogLevel::kError}).answered);
  EXPECT_TRUE(Order(owner, robot, {ControlAction::kClose, "notes", {}}).answered);
  EXPECT_TRUE(robot.Said("has steered this session. Log lines below the level error"));
  EXPECT_TRUE(robot.Said("has steered this session. Channel \"notes\" is closed"));
}

std::atomic<int> stops{0};

TEST_F(SteeringTest, StopsAProgramWhoseForbiddenCallbackHangs) {
  Robot robot("");
  Robot listener("", "listener");
  Robot owner("", "owner");
  test::Door door;
  std::atomic<bool> hangs{false};
  const Subscription heard = listener->FromAny<Note>(
      "notes", kSerial,
      [&](const Note&) {
        hangs = true;
        door.Pass();
      },
      test::Inline());
  const auto publish = robot->Advertise<Note>("notes");
  ASSERT_TRUE(robot->WaitForSubscribers("notes", 1, kPatience));
  publish(Note("endless"));
  ASSERT_TRUE(Await([&] { return hangs.load(); }));
  EXPECT_THAT(Order(owner, listener, {ControlAction::kForbid, "notes", {}}).done, HasSubstr("callback"));
  EXPECT_TRUE(Order(owner, listener, {ControlAction::kLog, {}, LogLevel::kInfo}).answered);
  struct sigaction before {};
  struct sigaction counts {};
  counts.sa_handler = [](int) { ++stops; };
  ASSERT_EQ(sigaction(SIGTERM, &counts, &before), 0);
  EXPECT_THAT(Order(owner, listener, {ControlAction::kStop, {}, {}}).done, HasSubstr("gets SIGTERM"));
  EXPECT_TRUE(Await([] { return stops == 1; }, kPatience / 2));
  EXPECT_EQ(sigaction(SIGTERM, &before, nullptr), 0);
  door.Open();
  EXPECT_TRUE(Await([&] { return !robot->WaitForSubscribers("notes", 1, std::chrono::nanoseconds(0)); }));
}

}  // namespace
}  // namespace hgros::steering_test
