#include "viewer/panels/dock/panel_dock.hpp"

#include "foxglove/Log.pb.h"
#include "foxglove/PoseInFrame.pb.h"
#include "viewer/panels/dock/panel_below.hpp"
#include "viewer/panels/panel_fixture.hpp"

namespace hgros::viewer::test {
namespace {

class PanelDockTest : public PanelTest {
 protected:
  /// Opens all panels, draws once, and returns their places.
  std::vector<PanelPlace> Places() {
    std::vector<PanelPlace> all;
    ImGui::NewFrame();
    dock_.Draw(PanelRoom());
    for (const PanelType& type : PanelTypes()) {
      ImGui::Begin(type.name.c_str());
      all.push_back(
          {ImGui::GetWindowPos().x, ImGui::GetWindowPos().y, ImGui::GetWindowWidth(), ImGui::GetWindowHeight()});
      ImGui::End();
    }
    ImGui::Render();
    return all;
  }
};

TEST_F(PanelDockTest, SubscribesOnlyWhileAPanelNeedsIt) {
  auto odometry = session_.Advertise<foxglove::PoseInFrame>("odometry");
  for (const char* name : {"Channels", "Log", "Message", "Plot", "Graph"}) Open(name);
  Update();
  EXPECT_FALSE(Subscribes("odometry")) << "it is not requested";
  EXPECT_EQ(Open("Channels").Set("measure", "odometry"), "");
  EXPECT_TRUE(Subscribes("odometry"));
  Close("Channels");
  EXPECT_FALSE(Subscribes("odometry"));
  EXPECT_EQ(Open("Plot").Set("series", "odometry pose.position.x"), "");
  EXPECT_TRUE(Subscribes("odometry"));
  Close("Plot");
  EXPECT_EQ(Open("Message").Set("channel", "odometry"), "");
  EXPECT_TRUE(Subscribes("odometry"));
  Close("Message");
  EXPECT_FALSE(Subscribes("odometry"));
}

TEST_F(PanelDockTest, IsNeverDueWithoutOpenPanels) {
  EXPECT_EQ(dock_.next_change_s(), std::numeric_limits<double>::infinity());
  EXPECT_FALSE(dock_.Update({1, {}}));
  EXPECT_EQ(wakes_, 0);
}

TEST_F(PanelDockTest, LimitsWakeUpsAndUpdatesInAFloodOfMessages) {
  auto odometry = session_.Advertise<foxglove::PoseInFrame>("odometry");
  ASSERT_EQ(Open("Plot").Set("series", "odometry pose.position.x"), "");
  Update();
  wakes_ = 0;
  for (int i = 0; i < 100; ++i) odometry(foxglove::PoseInFrame());
  ASSERT_TRUE(session_.WaitIdle(std::chrono::seconds(10)));
  EXPECT_EQ(wakes_, 1);
  EXPECT_GT(dock_.next_change_s(), now_s_ + 0.1) << "not at once: it was updated just now";
  EXPECT_LT(dock_.next_change_s(), now_s_ + 0.3);
  EXPECT_FALSE(dock_.Update({now_s_ + 0.05, channels_}));
  EXPECT_TRUE(dock_.Update({now_s_ + 0.3, channels_}));
}

TEST_F(PanelDockTest, ReturnsTheSettingsItWasGivenAndReopensAPanelAsItWas) {
  const std::vector<PanelLayout> wanted = {
      {"Plot", PanelPlace{10, 20, 400, 300}, {{"seconds", "30"}, {"series", "a x"}, {"series", "b y[0]"}}},
      {"Message", std::nullopt, {{"channel", "a"}, {"unfolded", "pose"}}},
      {"Log", std::nullopt, {{"level", "warning"}, {"source", "driver"}, {"text", "wheel"}, {"follow", "off"}}},
      {"Channels", std::nullopt, {{"measure", "a"}, {"measure", "b"}}},
      {"Graph", std::nullopt, {{"nodes", "on"}, {"viewer", "off"}, {"own channels", "on"}}},
  };
  for (const PanelLayout& layout : wanted) EXPECT_EQ(dock_.Restore(layout), "") << layout.name;
  EXPECT_EQ(dock_.KeptLayout(), wanted);
  Update();
  Draw();
  EXPECT_EQ(dock_.KeptLayout()[0].place, (PanelPlace{10, 20, 400, 300})) << "it is at the requested place";
  for (const PanelLayout& layout : wanted) Close(layout.name);
  EXPECT_TRUE(dock_.KeptLayout().empty());
  for (const PanelLayout& layout : wanted) {
    Open(layout.name);
    if (layout.name != "Channels") {
      EXPECT_EQ(dock_.KeptLayout().back(), layout);
    }
  }
}

TEST_F(PanelDockTest, PlacesTheRightPanel) {
  const PanelPlace first{10, 20, 400, 300};
  const PanelPlace second{30, 40, 500, 200};
  ASSERT_EQ(dock_.Restore({"Plot", first, {}}), "");
  ASSERT_EQ(dock_.Restore({"Log", second, {}}), "");
  ASSERT_EQ(dock_.Restore({"Plot", std::nullopt, {{"seconds", "30"}}}), "");
  EXPECT_EQ(dock_.KeptLayout()[0].place, first) << "no place was given, so it stays";
  EXPECT_EQ(dock_.KeptLayout()[1].place, second);
  const PanelPlace other{50, 60, 300, 300};
  ASSERT_EQ(dock_.Restore({"Plot", other, {}}), "");
  EXPECT_EQ(dock_.KeptLayout()[0].place, other);
  EXPECT_EQ(dock_.KeptLayout()[1].place, second);
}

TEST_F(PanelDockTest, FindsThePanelBelowThePointerBeforeTheNextPicture) {
  ASSERT_EQ(dock_.Restore({"Plot", PanelPlace{100, 200, 400, 300}, {}}), "");
  Update();
  Draw();
  Draw();
  EXPECT_TRUE(PanelBelow(101, 201));
  EXPECT_TRUE(PanelBelow(499, 499));
  EXPECT_FALSE(PanelBelow(90, 300));
  EXPECT_FALSE(PanelBelow(300, 510));
  Close("Plot");
  Draw();
  Draw();
  EXPECT_FALSE(PanelBelow(300, 300)) << "it is closed";
}

TEST_F(PanelDockTest, ReportsErrorsInALayout) {
  const auto fault = [&](const PanelLayout& layout) { return dock_.Restore(layout); };
  EXPECT_NE(fault({"Radar", std::nullopt, {}}).find("there are Channels, Log"), std::string::npos);
  EXPECT_NE(fault({"plot", std::nullopt, {{"series", "a"}}}).find("Write it as a channel"), std::string::npos);
  EXPECT_NE(fault({"Plot", std::nullopt, {{"seconds", "long"}}}).find("from 1 to 600"), std::string::npos);
  EXPECT_NE(fault({"Log", std::nullopt, {{"level", "loud"}}}).find("there are all"), std::string::npos);
  EXPECT_EQ(fault({"Log", std::nullopt, {{"follow", "false"}}}), "");
  EXPECT_NE(fault({"Log", std::nullopt, {{"follow", "perhaps"}}}).find("on or off"), std::string::npos);
  EXPECT_NE(fault({"Graph", std::nullopt, {{"viewer", "x"}}}).find("on or off"), std::string::npos);
  EXPECT_NE(fault({"Message", std::nullopt, {{"size", "1"}}}).find("no setting"), std::string::npos);
  EXPECT_NE(fault({"Channels", std::nullopt, {{"size", "1"}}}).find("no setting"), std::string::npos);
}

TEST_F(PanelDockTest, SharesTheSpaceUntilAUserMovesAPanel) {
  for (const PanelType& type : PanelTypes()) dock_.Open(type);
  const auto places = [&](const ImVec2& size) {
    ImGui::GetIO().DisplaySize = size;
    for (int i = 0; i < 3; ++i) Draw();
    return Places();
  };
  const std::vector<PanelPlace> tiny = places({300, 200});
  const std::vector<PanelPlace> large = places({1280, 800});
  for (std::size_t i = 0; i < large.size(); ++i) {
    EXPECT_GT(large[i].height, tiny[i].height) << "it grows with the window";
    EXPECT_GT(large[i].height, 200) << "it can be read";
    EXPECT_GT(large[i].width, 400);
  }
  EXPECT_EQ(places({300, 200}), tiny);
  (void)places({1280, 800});

  ImGuiIO& io = ImGui::GetIO();
  const ImVec2 title(large[1].x + 100, large[1].y + 8);
  io.MousePos = title;
  Draw();
  io.MouseDown[0] = true;
  Draw();
  io.MousePos = {title.x - 40, title.y + 30};
  Draw();
  io.MouseDown[0] = false;
  Draw();
  const PanelPlace moved{large[1].x - 40, large[1].y + 30, large[1].width, large[1].height};
  EXPECT_EQ(Places()[1], moved);
  EXPECT_EQ(dock_.KeptLayout()[1].place, moved);
  EXPECT_EQ(dock_.KeptLayout()[0].place, std::nullopt) << "no user has placed it";
  EXPECT_EQ(places({1900, 1000})[1], moved) << "a user has placed it";
  EXPECT_NE(places({1900, 1000})[0], large[0]) << "the others share the space";
}

}  // namespace
}  // namespace hgros::viewer::test
