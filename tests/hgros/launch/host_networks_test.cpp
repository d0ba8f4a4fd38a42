#include "launch/host_networks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "support/error_of.hpp"

namespace hgros::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kKey = "rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7";
constexpr const char* kOtherKey = "Yne@$w-vo<fVvi]a<NY6T1ed:M$fCG*[IaLV{hID";

// The camera on the cart sends images to the base, which serves "plan" for the cart.
class HostNetworksTest : public testing::Test {
 protected:
  HostNetworksTest() {
    robot_.hosts = {{.name = "cart", .address = "10.0.0.1", .port = 5650, .home = true},
                    {.name = "base", .address = "fe80::2", .port = 6000}};
    Add("alone", "");
    Add("camera", "").outputs = {{"image", "image", "x.A", {}}, {"unused", "unused", "x.A", {}}};
    Add("viewer", "").inputs = {{"unused", "unused", "x.A", "viewer/unused"}};
    descriptions_[1].calls = {{"plan", "plan", "x.A", "x.B"}};
    Add("mapper", "base").inputs = {{"image", "image", "x.A", "mapper/image"}};
    descriptions_[3].services = {{"plan", "plan", "x.A", "x.B"}};
  }
  ComponentDescription& Add(const std::string& name, const std::string& host) {
    robot_.components.push_back({.setup = {.name = name, .type = "t"}, .process = name, .at = {"robot.yaml", 1, 1}});
    RobotProcess& process = robot_.processes.emplace_back();
    process.name = name;
    process.host = host;
    process.components = {name};
    process.at = {"robot.yaml", 2, 1};
    return descriptions_.emplace_back();
  }
  [[nodiscard]] std::map<std::string, std::string> Networks() {
    for (std::size_t i = 0; i < descriptions_.size(); ++i) descriptions_[i].name = robot_.components[i].setup.name;
    return HostNetworks(robot_, RobotGraph(robot_, descriptions_));
  }

  RobotFile robot_;
  std::vector<ComponentDescription> descriptions_;
};

TEST_F(HostNetworksTest, HaveTheClockForProcessesThatFollowIt) {
  descriptions_[1].outputs.push_back({"clock", "clock", "hgros.SimulatedTime", {}});
  EXPECT_THAT(Networks().at("mapper"), Not(HasSubstr("clock"))) << "It has a clock of its own.";
  robot_.processes[3].config.simulated_time = true;
  EXPECT_THAT(Networks().at("camera"), HasSubstr("[\"clock\", \"hgros/call/plan\", \"image\"]"));
  EXPECT_THAT(Networks().at("mapper"), HasSubstr("5651\", channels: [\"clock\", "));
}

TEST_F(HostNetworksTest, HaveExactlyTheChannelsThatTheOtherHostUses) {
  EXPECT_EQ(Networks(), (std::map<std::string, std::string>{
                            {"camera",
                             "network:\n"
                             "  publisher: {ip: \"tcp://*:5651\", channels: [\"hgros/call/plan\", \"image\"]}\n"
                             "  subscribers:\n"
                             "    - {ip: \"tcp://[fe80::2]:6000\", channels: [\"hgros/call/plan\"]}\n"},
                            {"mapper",
                             "network:\n"
                             "  publisher: {ip: \"tcp://[::]:6000\", channels: [\"hgros/call/plan\"]}\n"
                             "  subscribers:\n"
                             "    - {ip: \"tcp://10.0.0.1:5651\", channels: [\"hgros/call/plan\", \"image\"]}\n"}}));
  const RobotGraph graph(robot_, descriptions_);
  EXPECT_EQ(graph.SubscribersOf(robot_.processes[1]),
            (std::map<std::string, std::size_t>{{"image", 1}, {"unused", 1}}));
}

TEST_F(HostNetworksTest, HaveTransformsBetweenComponentsThatUseThem) {
  descriptions_[2].transforms = true;  // The viewer.
  EXPECT_EQ(Networks().count("viewer"), 0U) << "There is no other one.";
  descriptions_[3].transforms = true;  // The mapper.
  EXPECT_EQ(Networks().at("viewer"),
            "network:\n"
            "  publisher: {ip: \"tcp://*:5652\", channels: [\"tf\", \"tf_static\"]}\n"
            "  subscribers:\n"
            "    - {ip: \"tcp://[fe80::2]:6000\", channels: [\"tf\", \"tf_static\"]}\n");
  EXPECT_THAT(Networks().at("mapper"), HasSubstr("{ip: \"tcp://10.0.0.1:5652\", channels: [\"tf\", \"tf_static\"]}"));
  EXPECT_THAT(Networks().at("camera"), Not(HasSubstr("tf")));

  // What names the channels itself exchanges them with those.
  descriptions_[2].transforms = false;
  descriptions_[2].inputs = {{"tf", "tf", "foxglove.FrameTransforms", "viewer/tf"}};
  EXPECT_EQ(Networks().at("viewer"),
            "network:\n"
            "  subscribers:\n"
            "    - {ip: \"tcp://[fe80::2]:6000\", channels: [\"tf\"]}\n");
  RobotProgram& screen = robot_.programs.emplace_back();
  screen.name = "screen";
  screen.publishes = {"tf_static"};
  EXPECT_THAT(Networks().at("mapper"), HasSubstr("5653\", channels: [\"tf_static\"]"));

  descriptions_[3].state = "x.S";  // The mapper may move to the camera's process.
  EXPECT_THAT(Networks().at("camera"), Not(HasSubstr("tf"))) << "Nothing there exchanges them with another host.";
  Add("driver", "base").transforms = true;
  EXPECT_THAT(Networks().at("camera"), HasSubstr("\"tf\", \"tf_static\"]"));
}

TEST_F(HostNetworksTest, HaveTheKeysOfTheHosts) {
  robot_.hosts[0].key = kKey;
  robot_.hosts[0].secret_key_file = "/cart.key";
  robot_.hosts[1].key = kOtherKey;
  robot_.hosts[1].secret_key_file = "/base.key";
  const std::string camera = Networks().at("camera");
  EXPECT_THAT(camera, HasSubstr(std::string("  security:\n    public_key: \"") + kKey +
                                "\"\n    secret_key_file: \"/cart.key\"\n    allowed_clients: [\"" + kOtherKey +
                                "\"]\n    servers:\n      \"tcp://[fe80::2]:6000\": \"" + kOtherKey + "\"\n"));
}

TEST_F(HostNetworksTest, FaultsOfAKeyFileHaveThePlaceOfTheHost) {
  robot_.hosts[0].at = {"robot.yaml", 3, 5};
  robot_.hosts[0].key = kKey;
  robot_.hosts[0].secret_key_file = "/nowhere/cart.key";
  robot_.hosts[1].key = kOtherKey;
  robot_.hosts[1].secret_key_file = "/base.key";
  EXPECT_THAT(test::ErrorOf([this] { (void)PartOfHost(robot_, "cart", Networks()); }),
              testing::StartsWith("robot.yaml:3:5: hosts.cart.secret_key_file names \"/nowhere/cart.key\", which "
                                  "cannot be read"));
}

TEST_F(HostNetworksTest, ProgramsHaveWhatTheySayThatTheyExchange) {
  RobotProgram& silent = robot_.programs.emplace_back();
  silent.name = "silent";
  silent.host = "base";
  RobotProgram& screen = robot_.programs.emplace_back();
  screen.name = "screen";
  screen.host = "base";
  screen.subscribes = {"image", "unused"};
  screen.publishes = {"drawn"};
  screen.calls = {"zoom"};
  Add("zoomer", "").services = {{"zoom", "zoom", "x.A", "x.B"}};
  const std::map<std::string, std::string> networks = Networks();
  EXPECT_EQ(networks.count("silent"), 0U);
  EXPECT_EQ(networks.at("screen"),
            "network:\n"
            "  publisher: {ip: \"tcp://[::]:6001\", channels: [\"hgros/call/zoom\"]}\n"
            "  subscribers:\n"
            "    - {ip: \"tcp://10.0.0.1:5651\", channels: [\"image\", \"unused\"]}\n"
            "    - {ip: \"tcp://10.0.0.1:5653\", channels: [\"hgros/call/zoom\"]}\n");
  EXPECT_THAT(networks.at("camera"),
              HasSubstr("\"tcp://*:5651\", channels: [\"hgros/call/plan\", \"image\", \"unused\"]"));
  EXPECT_THAT(networks.at("zoomer"), HasSubstr("{ip: \"tcp://[fe80::2]:6001\", channels: [\"hgros/call/zoom\"]}"));
  EXPECT_EQ(PartOfHost(robot_, "base", networks).programs.back().env.at("HGROS_CONFIG"), networks.at("screen"));
  EXPECT_TRUE(PartOfHost(robot_, "", networks).programs.back().env.empty()) << "It does not run here.";
  descriptions_[1].state =
      "x.S";  // Where a component may move, the program must be reached, but nothing moves into it.
  const std::map<std::string, std::string> moving = Networks();
  EXPECT_THAT(moving.at("screen"),
              HasSubstr("\"tcp://10.0.0.1:5650\", channels: [\"hgros/control\", \"image\", \"unused\"]"));
  EXPECT_THAT(moving.at("screen"), Not(HasSubstr("\"plan\"")));
  const RobotGraph graph(robot_, descriptions_);
  EXPECT_EQ(graph.SubscribersOf(robot_.processes[1]), (std::map<std::string, std::size_t>{{"image", 1}, {"unused", 1}}))
      << "It starts after the components, so they do not wait for it.";
}

TEST_F(HostNetworksTest, NeedNoHomeThatIsNotReached) {
  robot_.hosts[0].home = false;
  robot_.processes[1].host = robot_.processes[2].host = "base";
  EXPECT_TRUE(Networks().empty());
}

TEST_F(HostNetworksTest, AreAddedToThoseOfTheFile) {
  robot_.processes[1].config.publishers = {{"tcp://*:7000", {}, true}};
  const RobotFile cart = PartOfHost(robot_, "cart", Networks());
  ASSERT_EQ(cart.processes.size(), 3U);
  EXPECT_EQ(cart.FindProcess("mapper"), nullptr);
  const Config& camera = cart.FindProcess("camera")->config;
  ASSERT_EQ(camera.publishers.size(), 2U);
  EXPECT_EQ(camera.publishers[0].endpoint, "tcp://*:5651");
  EXPECT_EQ(camera.publishers[1].endpoint, "tcp://*:7000");
  EXPECT_EQ(camera.subscribers.size(), 1U);
  EXPECT_TRUE(cart.FindProcess("alone")->config.publishers.empty());
}

TEST_F(HostNetworksTest, WithoutAHostOnlyWhatRunsAtHomeGetsItsNetwork) {
  const RobotFile whole = PartOfHost(robot_, "", Networks());
  EXPECT_EQ(whole.processes.size(), robot_.processes.size());
  EXPECT_EQ(whole.components.size(), robot_.components.size());
  EXPECT_EQ(whole.FindProcess("camera")->config.publishers.size(), 1U);
  EXPECT_TRUE(whole.FindProcess("mapper")->config.subscribers.empty());
}

}  // namespace
}  // namespace hgros::cli
