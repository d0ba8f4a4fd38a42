// Names that are probably misspelled are reported.
#include "session/domain_fixture.hpp"

namespace hgros {
namespace {

using test::Await;
using test::Bus;
using test::kSerial;
using test::Note;
using test::Robot;

std::unique_ptr<Note> ANote() { return std::make_unique<Note>("x"); }

TEST(MisspelledNames, MisspelledChannelsOfTheConfigurationAreLoggedOnceWithTheNearestName) {
  const Bus bus;
  Robot robot("channels: {scna: {queue: latest}, lidar: {latched: 1}, pose: {latched: 1}}\n" +
              bus.Publishing("a", "scan, /odom, later"));
  (void)robot->ToAny("scan", ANote());
  (void)robot->ToAny("pose", ANote());
  (void)robot->ToAny("odom", ANote());
  robot.session.reset();
  EXPECT_TRUE(
      robot.Said("The configuration names channels that this session has not used so far: \"scna\" in channels (did "
                 "you mean \"scan\"?), \"/odom\" in network.publisher (did you mean \"odom\"?)."));
  EXPECT_EQ(robot.Count("has not used so far"), 1U);
}

TEST(MisspelledNames, MisspelledChannelsAreLoggedOnceSomeSecondsAfterTheStart) {
  Robot robot("data_graph: {close_channels: [pre_chanel]}");
  const auto subscription = robot->FromGraph<Note>("pre_channel", kSerial, [](const Note&) {});
  EXPECT_TRUE(
      Await([&] { return robot.Said("\"pre_chanel\" in data_graph.close_channels (did you mean \"pre_channel\"?)"); }));
  robot.session.reset();
  EXPECT_EQ(robot.Count("has not used so far"), 1U);
}

TEST(MisspelledNames, AMisspelledChannelThatIsUsedAfterTheFirstReportIsLoggedAtTheEnd) {
  Robot robot("data_graph: {close_channels: [pre_chanel]}\nchannels: {scna: {queue: latest}}");
  const auto subscription = robot->FromGraph<Note>("pre_channel", kSerial, [](const Note&) {});
  EXPECT_TRUE(Await([&] { return robot.Said("(did you mean \"pre_channel\"?)"); }));
  EXPECT_FALSE(robot.Said("scna"));
  (void)robot->ToAny("scan", ANote());
  robot.session.reset();
  EXPECT_TRUE(robot.Said("so far: \"scna\" in channels (did you mean \"scan\"?)."));
}

TEST(MisspelledNames, ListsMayHaveChannelsThatAreUsedLater) {
  const Bus bus;
  Robot robot(bus.Publishing("a", "camera_left, camera_right, camera/right/image, tf, map_state"));
  (void)robot->ToAny("camera_left", ANote());
  (void)robot->ToAny("camera/left/image", ANote());
  robot.session.reset();
  EXPECT_FALSE(robot.Said("has not used so far"));
}

TEST(MisspelledNames, ASessionNameMayNotHaveControlCharacters) {
  const auto fault = [](const std::string& name) -> std::string {
    try {
      const Session session({}, {name, nullptr});
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_EQ(fault("left arm"), "");
  EXPECT_NE(fault("a\nb").find("The session name \"a\\nb\" cannot be used"), std::string::npos) << fault("a\nb");
  EXPECT_NE(fault("a\xe2\x80\xae"
                  "b")
                .find("\\u202e"),
            std::string::npos);
}

class MisspelledNamesOfTwo : public test::DomainFixture {};

// Takes 30 s, because the others have that long to start.
TEST_F(MisspelledNamesOfTwo, AChannelWithoutAnotherEndIsLoggedWithTheNearestOneOfAnotherSession) {
  Robot driver("", "driver");
  Robot mapper("", "mapper");
  (void)driver->ToAny("/scan", ANote());
  (void)driver->ToAny("camera1", ANote());
  (void)driver->ToAny("camera/left/image", ANote());
  (void)driver->ToAny("params/driver/ask", ANote());
  (void)driver->ToAny("pose", ANote());
  (void)driver->ToAny("wheel_speed", ANote());
  (void)driver->ToAny("/local_goal", ANote());
  const auto ignore = [](const Note&) {};
  const auto scan = mapper->FromAny<Note>("scan", kSerial, ignore);
  const auto camera = mapper->FromAny<Note>("camera2", kSerial, ignore);
  const auto image = mapper->FromAny<Note>("camera/right/image", kSerial, ignore);
  const auto answer = mapper->FromAny<Note>("params/driver/answer", kSerial, ignore);
  const auto pose = mapper->FromAny<Note>("pose", kSerial, ignore);
  const auto speeds = mapper->FromAny<Note>("wheel_sped", kSerial, ignore);
  const auto goal = mapper->FromAny<Note>("local_goal", kSerial, ignore);
  (void)mapper->ToGraph("local_goal", ANote());
  test::Linger(std::chrono::seconds(7));
  EXPECT_FALSE(mapper.Said("Did you mean") || driver.Said("Did you mean")) << "others may start later";
  const auto late = mapper->FromAny<Note>("wheel_speed", kSerial, ignore);
  (void)driver->ToAny("wheel_sped", ANote());
  EXPECT_TRUE(Await(
      [&] {
        return mapper.Said(
            "\"scan\" is subscribed to here, but nobody publishes it. Did you mean \"/scan\", which driver");
      },
      std::chrono::seconds(60)));
  EXPECT_TRUE(Await([&] {
    return driver.Said("\"/scan\" is published here, but nobody subscribes to it. Did you mean \"scan\", which mapper");
  }));
  const auto again = mapper->FromAny<Note>("scan", kSerial, ignore);
  test::Linger(std::chrono::milliseconds(2500));  // Channels that were opened later are looked at 1 s later.
  driver.session.reset();
  mapper.session.reset();
  EXPECT_EQ(mapper.Count("Did you mean"), 1U) << "local_goal is published here";
  EXPECT_EQ(driver.Count("Did you mean \"scan\""), 1U);
  EXPECT_FALSE(driver.Said("wheel_sped"));
}

}  // namespace
}  // namespace hgros
