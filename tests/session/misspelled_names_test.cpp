// Names that are probably misspelled are reported.
#include "session/misspelled_names.hpp"

#include "session/domain_fixture.hpp"
#include "support/error_of.hpp"

namespace hgros::test {
namespace {

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

TEST(MisspelledNames, ListsMayHaveChannelsThatAreUsedLater) {
  const Bus bus;
  Robot robot(bus.Publishing("a", "camera_left, camera_right, camera/right/image, tf, map_state"));
  (void)robot->ToAny("camera_left", ANote());
  (void)robot->ToAny("camera/left/image", ANote());
  robot.session.reset();
  EXPECT_FALSE(robot.Said("has not used so far"));
}

TEST(MisspelledNames, ASessionNameMayNotHaveControlCharacters) {
  const auto fault = [](const std::string& name) { return ErrorOf([&] { return Session({}, {name, nullptr}).id(); }); };
  EXPECT_EQ(fault("left arm"), "");
  EXPECT_NE(fault("a\nb").find("The session name \"a\\nb\" cannot be used"), std::string::npos) << fault("a\nb");
  EXPECT_NE(fault("a\xe2\x80\xae"
                  "b")
                .find("\\u202e"),
            std::string::npos);
}

/// The names that one session looks at, at times that the test chooses.
struct Names {
  explicit Names(Robot& of) : robot(of) {}
  void Note(const std::string& channel) { names.Note(channel, begin); }
  void LookAt(std::chrono::seconds time) { (void)names.LookForOtherEnds(begin + time); }

  Robot& robot;
  DataGraph graph;
  std::string said;
  const MisspelledNames::Clock::time_point begin = MisspelledNames::Clock::now();
  MisspelledNames names{
      {.graph = graph,
       .log = std::make_shared<Log>([this](LogLevel, std::string_view line) { said.append(line).append("\n"); }),
       .own =
           [this] {
             SessionChannels own;
             own.session.id = robot->id();
             return own;
           },
       .known = [this] { return robot->Channels(); },
       .connected = [](const std::string& channel) { return channel == "pose"; },
       .later = [](std::chrono::nanoseconds, const std::function<void()>&) {}}};
};

class MisspelledNamesOfTwo : public DomainFixture {};

TEST_F(MisspelledNamesOfTwo, AChannelWithoutAnotherEndIsLoggedOnceWithTheNearestOneOfAnotherSession) {
  Robot driver("", "driver");
  Robot mapper("", "mapper");
  const std::vector<std::string> published{"/scan", "camera1",     "camera/left/image", "params/driver/ask",
                                           "pose",  "wheel_speed", "/local_goal"};
  const std::vector<std::string> subscribed{"scan", "camera2",    "camera/right/image", "params/driver/answer",
                                            "pose", "wheel_sped", "local_goal"};
  Names drivers(driver);
  Names mappers(mapper);
  for (const std::string& channel : published) {
    (void)driver->ToAny(channel, ANote());
    drivers.Note(channel);
  }
  std::vector<Subscription> subscriptions;
  for (const std::string& channel : subscribed) {
    subscriptions.push_back(mapper->FromAny<Note>(channel, kSerial, [](const Note&) {}));
    mappers.Note(channel);
  }
  auto goal = mappers.graph.FromGraph<Note>("local_goal", kSerial, [](const Note&) {});
  (void)mappers.graph.ToGraph("local_goal", ANote());
  for (const int seconds : {4, 5, 29}) {
    drivers.LookAt(std::chrono::seconds(seconds));
    mappers.LookAt(std::chrono::seconds(seconds));
  }
  EXPECT_EQ(drivers.said + mappers.said, "") << "others may start later";
  subscriptions.push_back(mapper->FromAny<Note>("wheel_speed", kSerial, [](const Note&) {}));
  (void)driver->ToAny("wheel_sped", ANote());
  const auto channels = [](Robot& robot) {
    return std::ranges::count_if(robot->Channels(), [](const auto& one) { return !one.name.starts_with("hgros/"); });
  };
  ASSERT_TRUE(Await([&] { return channels(mapper) == 13 && channels(driver) == 13; }));
  // The names are known before it is known that both sessions use these two.
  const auto has_both_ends = [](Robot& robot, std::string_view name) {
    return std::ranges::any_of(robot->Channels(), [&](const auto& one) {
      return one.name == name && !one.publishers.empty() && !one.subscribers.empty();
    });
  };
  for (const char* const name : {"wheel_speed", "wheel_sped"}) {
    ASSERT_TRUE(Await([&] { return has_both_ends(mapper, name) && has_both_ends(driver, name); })) << name;
  }
  for (const int seconds : {31, 60}) {
    drivers.LookAt(std::chrono::seconds(seconds));
    mappers.Note("scan");
    mappers.LookAt(std::chrono::seconds(seconds));
  }
  EXPECT_EQ(std::ranges::count(mappers.said, '\n'), 1) << mappers.said << "local_goal is published here";
  EXPECT_EQ(mappers.said.find("\"scan\" is subscribed to here, but nobody publishes it. Did you mean \"/scan\", "
                              "which driver"),
            0U)
      << mappers.said;
  EXPECT_NE(drivers.said.find("\"/scan\" is published here, but nobody subscribes to it. Did you mean \"scan\", "
                              "which mapper"),
            std::string::npos)
      << drivers.said;
  EXPECT_EQ(drivers.said.find("wheel_sped"), std::string::npos) << drivers.said;
}

}  // namespace
}  // namespace hgros::test
