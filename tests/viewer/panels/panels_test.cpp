#include <unistd.h>

#include <cstdlib>

#include "foxglove/Log.pb.h"
#include "foxglove/PoseInFrame.pb.h"
#include "support/await.hpp"
#include "viewer/panels/panel_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using PanelsTest = PanelTest;

TEST_F(PanelsTest, EmptyPanelsExplainWhatToDo) {
  const int none = Draw();
  for (const PanelType& type : PanelTypes()) {
    dock_.Open(type);
    Update();
    EXPECT_GT(Draw(), none) << type.name;
    dock_.Close(type);
  }
}

TEST_F(PanelsTest, LogShowsLinesAsTheyArrive) {
  auto log = session_.Advertise<foxglove::Log>("log");
  Open("Log");
  Update();  // Now it subscribes.
  const int before = Draw();
  foxglove::Log line;
  line.set_level(foxglove::Log::WARNING);
  line.set_message("the wheel slips");
  for (int i = 0; i < 5; ++i) {
    line.set_line(static_cast<std::uint32_t>(i));
    line.set_name("driver");
    log(line);
  }
  Update();
  Draw();
  EXPECT_GT(Draw(), before);
}

TEST_F(PanelsTest, MessageUnfoldsRequestedFields) {
  auto odometry = session_.Advertise<foxglove::PoseInFrame>("odometry");
  ASSERT_EQ(Open("Message").Set("channel", "odometry"), "");
  odometry(foxglove::PoseInFrame());
  Update();
  Draw();
  const int folded = Draw();
  foxglove::PoseInFrame pose;
  pose.mutable_pose()->mutable_position()->set_x(1.5);
  odometry(pose);
  ASSERT_EQ(Open("Message").Set("unfolded", "pose"), "");
  ASSERT_EQ(Open("Message").Set("unfolded", "pose.position"), "");
  Update();
  Draw();
  EXPECT_GT(Draw(), folded);
}

TEST_F(PanelsTest, PlotDrawsALineThroughItsNumbers) {
  auto odometry = session_.Advertise<foxglove::PoseInFrame>("odometry");
  ASSERT_EQ(Open("Plot").Set("series", "odometry pose.position.x"), "");
  Update();
  Draw();
  const int empty = Draw();
  for (int i = 0; i < 50; ++i) {
    foxglove::PoseInFrame pose;
    pose.mutable_pose()->mutable_position()->set_x(i);
    odometry(pose);
  }
  Update();
  EXPECT_GT(Draw(), empty);
}

TEST_F(PanelsTest, KnowWhetherAMessageHasArrived) {
  auto odometry = session_.Advertise<foxglove::PoseInFrame>("odometry");
  auto log = session_.Advertise<foxglove::Log>("log");
  const std::vector<std::vector<std::string>> cases = {
      {"Plot", "series", "odometry pose.position.x"}, {"Message", "channel", "odometry"}, {"Log"}};
  for (const auto& panel : cases) {
    SCOPED_TRACE(panel.front());
    Panel& opened = Open(panel.front());
    if (panel.size() > 1) {
      ASSERT_EQ(opened.Set(panel[1], panel[2]), "");
    }
    Update();
    EXPECT_FALSE(dock_.HasReceived());
    foxglove::PoseInFrame pose;
    pose.mutable_pose()->mutable_position()->set_x(1);
    odometry(pose);
    log(foxglove::Log());
    Update();
    EXPECT_TRUE(dock_.HasReceived());
    Close(panel.front());
  }
  Open("Channels");
  Open("Graph");
  Update();
  EXPECT_FALSE(dock_.HasReceived());
}

TEST_F(PanelsTest, PlotShowsTheErrorOfEachSeriesOnItsOwnLine) {
  auto odometry = session_.Advertise<foxglove::PoseInFrame>("odometry");
  Panel& plot = Open("Plot");
  ASSERT_EQ(plot.Set("series", "odometry pose.speed"), "");
  ASSERT_EQ(plot.Set("series", "nothing pose.position.x"), "");
  odometry(foxglove::PoseInFrame());
  Update();
  Draw();
  ImGui::NewFrame();
  ImGui::LogToClipboard();
  dock_.Draw(PanelRoom());
  ImGui::LogFinish();
  ImGui::Render();
  const std::string text = ImGui::GetClipboardText();
  const std::size_t first = text.find("odometry pose.speed: ");
  const std::size_t second = text.find("nothing pose.position.x: This channel has no publisher.");
  ASSERT_NE(first, std::string::npos) << text;
  ASSERT_NE(second, std::string::npos) << text;
  EXPECT_NE(text.substr(first, second - first).find('\n'), std::string::npos) << text;
  EXPECT_GT(first, text.find("nothing pose.position.x ")) << "below the names of all: " << text;
}

TEST_F(PanelsTest, AllPanelsFitIntoATinyWindow) {
  auto odometry = session_.Advertise<foxglove::PoseInFrame>("odometry");
  for (const PanelType& type : PanelTypes()) dock_.Open(type);
  ASSERT_EQ(Open("Plot").Set("series", "odometry pose.position.x"), "");
  ASSERT_EQ(Open("Message").Set("channel", "odometry"), "");
  odometry(foxglove::PoseInFrame());
  for (const ImVec2 size : {ImVec2(1, 1), ImVec2(40, 30), ImVec2(16384, 16384), ImVec2(640, 480)}) {
    ImGui::GetIO().DisplaySize = size;
    Update();
    Draw();
  }
}

TEST_F(PanelsTest, GraphIsReadableWithFiftyProcesses) {
  std::vector<KnownChannel> channels;
  for (std::uint64_t i = 0; i < 50; ++i) {
    KnownChannel channel;
    channel.name = "channel_" + std::to_string(i);
    ChannelUser user;
    user.session = {i + 1};
    user.process = "process_" + std::to_string(i);
    channel.publishers.push_back(user);
    user.session = {(i * 7) % 50 + 1};
    channel.subscribers.push_back(user);
    channels.push_back(channel);
  }
  Open("Graph");
  EXPECT_TRUE(dock_.Update({1, channels}));
  Draw();
  EXPECT_GT(Draw(), 500);
}

/// Sessions find each other in a separate domain.
struct Domain {
  Domain() { setenv("HGROS_DOMAIN", ("panels" + std::to_string(getpid())).c_str(), 1); }
  ~Domain() { setenv("HGROS_DOMAIN", "none", 1); }
};
class FoundPanelsTest : private Domain, public PanelTest {};

TEST_F(FoundPanelsTest, GraphShowsTheNodesOfOtherSessions) {
  Session robot({}, {"robot", [](LogLevel, std::string_view) {}});
  std::vector<Subscription> nodes;
  for (int i = 0; i < 8; ++i) {
    nodes.push_back(
        robot.FromAny<foxglove::PoseInFrame>("odometry", Invoke::kSerial, [](const foxglove::PoseInFrame&) {}));
  }
  Open("Graph");
  double now_s = 0;
  const auto drawn = [&](const char* by_node) {
    EXPECT_EQ(Open("Graph").Set("nodes", by_node), "");
    std::vector<KnownChannel> channels = session_.Channels();
    std::erase_if(channels, [](const KnownChannel& channel) { return channel.name.starts_with("hgros/"); });
    (void)dock_.Update({now_s += 2, channels});
    return Draw();
  };
  EXPECT_TRUE(hgros::test::Await([&] { return drawn("on") > drawn("off") + 7 * 24; })) << "seven more boxes";
}

}  // namespace
}  // namespace hgros::viewer::test
