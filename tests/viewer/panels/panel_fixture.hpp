#pragma once

#include <gtest/gtest.h>
#include <imgui.h>

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "hgros/session/session.hpp"
#include "viewer/panels/dock/panel_dock.hpp"
#include "viewer/panels/dock/panel_room.hpp"

namespace hgros::viewer::test {

/// A dock with its own session, and ImGui without drawing.
class PanelTest : public ::testing::Test {
 protected:
  PanelTest() {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {1280, 800};
    io.DeltaTime = 0.02F;
    unsigned char* pixels = nullptr;
    int width = 0;
    int height = 0;
    io.Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
  }
  ~PanelTest() override { ImGui::DestroyContext(); }

  Panel& Open(const std::string& name) { return dock_.Open(*PanelTypeNamed(name)); }
  void Close(const std::string& name) { dock_.Close(*PanelTypeNamed(name)); }

  /// Takes what has arrived, as if a second had passed.
  void Update() {
    EXPECT_TRUE(session_.WaitIdle(std::chrono::seconds(10)));
    channels_ = session_.Channels();
    std::erase_if(channels_, [](const KnownChannel& channel) { return channel.name.starts_with("hgros/"); });
    now_s_ += 1;
    (void)dock_.Update({now_s_, channels_});
  }
  /// Lays out a frame with what `draw` draws. Returns the number of triangles.
  template <class F>
  static int Frame(const F& draw) {
    ImGui::NewFrame();
    draw();
    ImGui::Render();
    return ImGui::GetDrawData()->TotalIdxCount / 3;
  }
  /// The same for the dock.
  int Draw() {
    return Frame([&] { dock_.Draw(PanelRoom()); });
  }
  /// Whether this session subscribes to a channel.
  bool Subscribes(const std::string& name) {
    for (const KnownChannel& channel : session_.Channels()) {
      if (channel.name == name && !channel.subscribers.empty()) return true;
    }
    return false;
  }

  std::atomic<int> wakes_ = 0;
  Session session_;
  PanelDock dock_{session_, [this] { ++wakes_; }};
  std::vector<KnownChannel> channels_;
  double now_s_ = 0;
};

}  // namespace hgros::viewer::test
