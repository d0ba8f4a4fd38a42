#include "launch/robot_graph.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

namespace hgros::cli {
namespace {

using Subscribers = std::map<std::string, std::size_t>;

// The component "a" runs in the process "pa", and so on.
class RobotGraphTest : public testing::Test {
 protected:
  ComponentDescription& Add(const std::string& name, const std::string& process = {}) {
    const std::string where = process.empty() ? "p" + name : process;
    robot_.components.push_back({.setup = {.name = name, .type = "t"}, .process = where, .at = {"robot.yaml", 1, 1}});
    if (robot_.FindProcess(where) == nullptr) robot_.processes.emplace_back().name = where;
    descriptions_.emplace_back().name = name;
    return descriptions_.back();
  }
  [[nodiscard]] Subscribers SubscribersOf(const std::string& process) const {
    return RobotGraph(robot_, descriptions_).SubscribersOf(*robot_.FindProcess(process));
  }
  // As "fault: ..." or "warning: ...".
  [[nodiscard]] std::vector<std::string> Findings() const {
    std::vector<std::string> texts;
    for (const RobotFinding& one : RobotGraph(robot_, descriptions_).Check()) {
      texts.push_back((one.fault ? "fault: " : "warning: ") + one.Text());
    }
    return texts;
  }
  static ComponentChannel Channel(const std::string& channel, const std::string& type = "x.A") {
    return {channel, channel, type, {}};
  }

  RobotFile robot_;
  std::vector<ComponentDescription> descriptions_;
};

TEST_F(RobotGraphTest, CountsNodesHereAndOtherProcesses) {
  Add("a").outputs = {Channel("scan"), Channel("alone")};
  Add("b", "pa").inputs = {Channel("scan"), Channel("scan")};
  Add("c").inputs = {Channel("scan"), Channel("scan")};
  Add("d", "pc").inputs = {Channel("scan")};
  EXPECT_EQ(SubscribersOf("pa"), (Subscribers{{"scan", 3}}));
  EXPECT_EQ(SubscribersOf("pc"), Subscribers());
}

TEST_F(RobotGraphTest, ComponentsThatUseTransformsPublishThem) {
  Add("a").inputs = {Channel("tf", "foxglove.FrameTransforms")};
  EXPECT_EQ(Findings().size(), 1U);
  Add("b").transforms = true;
  EXPECT_EQ(Findings(), std::vector<std::string>());
}

TEST_F(RobotGraphTest, KnowsWhichComponentsMeet) {
  Add("camera").outputs = {Channel("image"), Channel("state")};
  Add("detector").inputs = {Channel("image")};
  Add("viewer").inputs = {Channel("image"), Channel("map")};
  const RobotGraph graph(robot_, descriptions_);
  EXPECT_TRUE(graph.Meet("camera", "detector"));
  EXPECT_TRUE(graph.Meet("viewer", "camera"));
  EXPECT_FALSE(graph.Meet("detector", "viewer"));
  EXPECT_FALSE(graph.Meet("camera", "camera"));
}

TEST_F(RobotGraphTest, CountsOnlyProcessesThatFindEachOther) {
  Add("a").outputs = {Channel("scan")};
  Add("b").inputs = {Channel("scan")};
  robot_.processes[1].config.discovery.domain = "other";
  EXPECT_EQ(SubscribersOf("pa"), Subscribers());
  robot_.processes[0].config.discovery.domain = "other";
  EXPECT_EQ(SubscribersOf("pa"), (Subscribers{{"scan", 1}}));
  robot_.processes[1].config.discovery.local = false;
  EXPECT_EQ(SubscribersOf("pa"), Subscribers());
}

TEST_F(RobotGraphTest, LeavesOutClosedChannelsOfTheProcess) {
  Add("a").outputs = {Channel("scan")};
  Add("b", "pa").inputs = {Channel("scan")};
  Add("c").inputs = {Channel("scan")};
  robot_.processes[0].config.closed_channels = {"scan"};
  EXPECT_EQ(SubscribersOf("pa"), (Subscribers{{"scan", 1}}));
}

TEST_F(RobotGraphTest, ACycleIsNoFault) {
  ComponentDescription& a = Add("a");
  a.outputs = {Channel("there")};
  a.inputs = {Channel("back")};
  ComponentDescription& b = Add("b");
  b.outputs = {Channel("back")};
  b.inputs = {Channel("there")};
  EXPECT_TRUE(Findings().empty());
  EXPECT_EQ(SubscribersOf("pa"), (Subscribers{{"there", 1}}));
}

TEST_F(RobotGraphTest, FindsTypesThatDoNotFit) {
  Add("a").outputs = {Channel("scan", "x.A")};
  Add("b").inputs = {Channel("scan", "x.B")};
  Add("c").inputs = {Channel("scan", "")};
  Add("d").outputs = {Channel("scan", "x.C")};
  const std::vector<std::string> findings = Findings();
  ASSERT_EQ(findings.size(), 3U);
  EXPECT_EQ(findings[0],
            "fault: robot.yaml:1:1: The channel \"scan\" has two types: \"a\" publishes x.A, and \"b\" subscribes to "
            "x.B. Rename one of them with remap.");
  EXPECT_NE(findings[2].find("\"a\" publishes x.A, and \"d\" publishes x.C."), std::string::npos) << findings[2];
}

TEST_F(RobotGraphTest, DoesNotWarnOfWhatMayComeFromOutside) {
  Add("a").outputs = {Channel("front/scan")};
  Add("b").inputs = {Channel("joystick"), Channel("front/scam")};
  EXPECT_EQ(Findings().size(), 2U);
  EndpointConfig& endpoint = robot_.processes[1].config.subscribers.emplace_back();
  endpoint.channels = {"joystick"};
  ASSERT_EQ(Findings().size(), 1U) << "One has a nearest name.";
  EXPECT_NE(Findings()[0].find("front/scam"), std::string::npos);
  endpoint.channels = {"front/scam", "joystick"};
  EXPECT_TRUE(Findings().empty()) << "Whoever lists it means it.";
  robot_.processes[1].config.subscribers.clear();
  robot_.programs.emplace_back().name = "pad";
  EXPECT_EQ(Findings().size(), 1U);
}

TEST_F(RobotGraphTest, FindsServicesThatDoNotFit) {
  Add("a").services = {{"plan", "plan", "x.A", "x.B"}};
  Add("b").services = {{"plan", "plan", "x.A", "x.B"}};
  Add("c").calls = {{"plan", "plan", "x.A", "x.C"}};
  const std::vector<std::string> findings = Findings();
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_NE(findings[0].find("is served twice: by \"a\" and by \"b\"."), std::string::npos) << findings[0];
  EXPECT_NE(findings[1].find("returns x.B in \"a\", but \"c\" sends x.A and expects x.C."), std::string::npos)
      << findings[1];
}

}  // namespace
}  // namespace hgros::cli
