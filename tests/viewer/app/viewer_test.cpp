#include "viewer/app/viewer.hpp"

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "foxglove/Log.pb.h"
#include "foxglove/RawImage.pb.h"
#include "hgros/base/error.hpp"
#include "hgros/tf/transforms.hpp"
#include "support/await.hpp"
#include "support/error_of.hpp"
#include "support/scratch_folder.hpp"
#include "viewer/app/showing.hpp"
#include "viewer/app/surface/offscreen.hpp"
#include "viewer/e2e/message_parts.hpp"
#include "viewer/scene/gl/picture.hpp"

namespace hgros::viewer::test {
namespace {

/// A surface in memory that runs one step after each picture. It closes after the last one.
class ScriptedSurface : public Offscreen {
 public:
  using Step = std::function<void(ScriptedSurface&)>;

  explicit ScriptedSurface(std::vector<Step> steps, const Viewport& room = {640, 480})
      : Offscreen(room), shown_(room), steps_(std::move(steps)) {}

  // Actions for steps.
  void Resize(const Viewport& size) { shown_ = size; }
  void Rescale(float scale) { scale_ = scale; }
  void Lose() { lost_ = true; }
  /// Hides it for this number of turns.
  void Hide(int turns) { hidden_turns_ = turns; }
  /// The current step runs again after the next picture.
  void Again() { --next_; }
  void Press(int key) { input_.push_back({InputEvent::Kind::kKey, {}, 0, 0, 0, key}); }
  void Click(double x, double y, bool shift) {
    input_.push_back({InputEvent::Kind::kPress, PointerButton::kLeft, x, y, 0, 0, shift});
    input_.push_back({InputEvent::Kind::kRelease, PointerButton::kLeft, x, y, 0, 0, shift});
  }

  /// The shown pixels, 3 bytes each.
  [[nodiscard]] std::vector<std::uint8_t> Pixels() const {
    Picture copy;
    copy.Resize(shown_);
    copy.TakeFrom(framebuffer());
    return copy.Pixels();
  }
  [[nodiscard]] int pictures() const noexcept { return pictures_; }

  void Wait(double seconds) override {
    if (pictures_ == done_ || next_ == steps_.size()) return Offscreen::Wait(seconds);
    done_ = pictures_;
    steps_[next_++](*this);
  }
  [[nodiscard]] bool TakeDisturbed() override { return true; }
  [[nodiscard]] std::vector<InputEvent> TakeInput() override {
    if (hidden_turns_ > 0) --hidden_turns_;
    return std::exchange(input_, {});
  }
  [[nodiscard]] bool hidden() const override { return hidden_turns_ > 0; }
  [[nodiscard]] bool closing() const override { return next_ == steps_.size() && pictures_ > done_; }
  [[nodiscard]] bool lost() const override { return lost_; }
  [[nodiscard]] Viewport size() const override { return shown_; }
  [[nodiscard]] float scale() const override { return scale_; }
  void BeginPanels() override {
    Offscreen::BeginPanels();
    ImGui::GetIO().DisplaySize = {static_cast<float>(shown_.width), static_cast<float>(shown_.height)};
  }
  void Present() override {
    Offscreen::Present();
    ++pictures_;
  }

 private:
  Viewport shown_;
  float scale_ = 1;
  bool lost_ = false;
  int hidden_turns_ = 0;
  std::vector<InputEvent> input_;
  std::vector<Step> steps_;
  std::size_t next_ = 0;
  int pictures_ = 0;
  int done_ = 0;
};

/// Sessions of this process find each other while it exists.
struct MetOnThisHost {
  MetOnThisHost() { setenv("HGROS_DOMAIN", ("viewer-whole-" + std::to_string(getpid())).c_str(), 1); }
  ~MetOnThisHost() { setenv("HGROS_DOMAIN", "none", 1); }
};

class ViewerTest : public ::testing::Test {
 protected:
  ViewerTest() {
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::GetIO().BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
    options_.fps_limit = 1000;
  }
  ~ViewerTest() override { ImGui::DestroyContext(); }

  void SetUp() override {
    try {
      const ScriptedSurface surface({});
    } catch (const Error& error) {
      GTEST_SKIP() << error.what();
    }
  }
  /// Runs the steps. Returns the viewer's layout at the end.
  Layout Do(std::vector<ScriptedSurface::Step> steps, const std::optional<Layout>& layout = std::nullopt,
            const Viewport& room = {640, 480}) {
    ScriptedSurface surface(std::move(steps), room);
    Viewer viewer(options_, layout, surface);
    running_ = &viewer;
    EXPECT_EQ(viewer.Run(), 0);
    running_ = nullptr;
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    return viewer.CurrentLayout();
  }
  /// Runs the steps of each surface, one after the other. Returns the exit code. Sets `made_` and `running_`.
  int DoOnSurfaces(
      const std::vector<std::vector<ScriptedSurface::Step>>& surfaces,
      const std::function<void(Viewer*)>& watch = [](Viewer*) {}) {
    const auto make = [&]() -> std::unique_ptr<Surface> {
      return std::make_unique<ScriptedSurface>(surfaces.at(made_++));
    };
    return ShowUntilClosed(options_, std::nullopt, make, [&](Viewer* viewer) {
      running_ = viewer;
      watch(viewer);
    });
  }
  static ScriptedSurface::Step Resize(const Viewport& size) {
    return [size](ScriptedSurface& surface) { surface.Resize(size); };
  }
  static void Lose(ScriptedSurface& surface) { surface.Lose(); }
  static void DoNothing(ScriptedSurface& /*surface*/) {}
  /// Repeats a step until it returns true, for 20 s.
  static ScriptedSurface::Step Until(std::function<bool(ScriptedSurface&)> step) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    return [step = std::move(step), deadline](ScriptedSurface& surface) {
      if (step(surface) || std::chrono::steady_clock::now() >= deadline) return;
      hgros::test::Linger(std::chrono::milliseconds(5));
      surface.Again();
    };
  }
  /// Runs the steps. Returns the exit code and what was written to standard error.
  std::pair<int, std::string> Listen(std::vector<ScriptedSurface::Step> steps) {
    ScriptedSurface surface(std::move(steps));
    Viewer viewer(options_, std::nullopt, surface);
    ::testing::internal::CaptureStderr();
    const int code = viewer.Run();
    return {code, ::testing::internal::GetCapturedStderr()};
  }
  /// The error of a viewer that cannot be made.
  std::string FaultOf(const std::optional<Layout>& layout) {
    ScriptedSurface surface({});
    return hgros::test::ErrorOf([&] { const Viewer viewer(options_, layout, surface); });
  }
  static ScriptedSurface::Step Key(int key) {
    return [key](ScriptedSurface& surface) { surface.Press(key); };
  }
  /// An empty one if there is none.
  static LayoutDisplay DisplayOf(const Layout& layout, const std::string& channel) {
    const auto display = std::ranges::find(*layout.displays, channel, &LayoutDisplay::channel);
    return display == layout.displays->end() ? LayoutDisplay() : *display;
  }
  static std::vector<std::string> PanelsOf(const Layout& layout) {
    std::vector<std::string> names;
    for (const LayoutPanel& panel : layout.panels) names.push_back(panel.panel.name);
    return names;
  }

  Options options_;
  const Viewer* running_ = nullptr;
  std::size_t made_ = 0;
};

TEST_F(ViewerTest, OpensAndClosesPanelsByKeys) {
  EXPECT_EQ(PanelsOf(Do({Key('1'), Key('5'), Key('4'), Key('5')})), (std::vector<std::string>{"Channels", "Plot"}));
}

TEST_F(ViewerTest, AppliesALayoutAndReturnsItUnchanged) {
  const Layout before = Do({Key('T'), Key('O'), Key('2'), Key('4')});
  ASSERT_TRUE(before.camera->orthographic);
  EXPECT_EQ(Do({Key('H'), Key('H')}, before), before);
}

TEST_F(ViewerTest, ALayoutHasTheColorOfACloudOnceItIsDecided) {
  for (const char* given : {"size", "highest"}) {
    options_.channels = {{"cloud", "foxglove.PointCloud", {{given, "3"}}}};
    const LayoutDisplay display = DisplayOf(Do({Key('H')}), "cloud");
    const auto has = [&](const char* name) {
      return std::ranges::find(display.settings, name, &LayoutSetting::name) != display.settings.end();
    };
    EXPECT_TRUE(has(given));
    EXPECT_EQ(has("color"), given == std::string("highest")) << "rgb, if the first points have colors";
    EXPECT_EQ(has("map"), given == std::string("highest"));
  }
}

TEST_F(ViewerTest, DrawsAtAnyWindowSize) {
  options_.opened_panels = {
      {"Channels", "", {}}, {"Log", "", {}}, {"Message", "", {}}, {"Plot", "", {}}, {"Graph", "", {}}};
  std::vector<ScriptedSurface::Step> steps;
  for (const Viewport size : {Viewport{1, 1}, Viewport{2, 480}, Viewport{640, 1}, Viewport{640, 480}, Viewport{3, 3}}) {
    steps.push_back(Resize(size));
    steps.push_back(Key('Z'));
    steps.push_back([](ScriptedSurface& surface) { surface.Click(0, 0, true); });
  }
  (void)Do(steps);
}

TEST_F(ViewerTest, DrawsNothingWhileHidden) {
  options_.report_s = 0.001;  // It still runs its turns.
  bool seen_at_the_next_picture = false;
  (void)Do({[](ScriptedSurface& surface) { surface.Hide(20); },
            [&](ScriptedSurface& surface) { seen_at_the_next_picture = !surface.hidden(); }});
  EXPECT_TRUE(seen_at_the_next_picture);
}

TEST_F(ViewerTest, StaysBelowTheFrameRateLimit) {
  options_.fps_limit = 50;
  constexpr int kPictures = 11;
  std::vector<std::chrono::steady_clock::time_point> drawn;
  const ScriptedSurface::Step note = [&](ScriptedSurface& surface) {
    drawn.push_back(std::chrono::steady_clock::now());
    if (drawn.size() < kPictures) surface.Again();
  };
  (void)Do({note});
  ASSERT_EQ(drawn.size(), std::size_t{kPictures});
  EXPECT_GT(std::chrono::duration<double>(drawn.back() - drawn.front()).count(), 0.9 * (kPictures - 1) / 50);
}

TEST_F(ViewerTest, RescalesFontsWhenTheScreenChanges) {
  float before = 0;
  float on_the_other = 0;
  const auto note = [](float& size) { return [&size](ScriptedSurface&) { size = ImGui::GetFontSize(); }; };
  (void)Do({note(before), [](ScriptedSurface& surface) { surface.Rescale(2); }, note(on_the_other),
            [](ScriptedSurface& surface) { surface.Rescale(1); }});
  EXPECT_EQ(on_the_other, 2 * before);
}

TEST_F(ViewerTest, PausesStepsAndResumes) { (void)Do({Key(' '), Key('N'), Key('N'), Key(' '), Key('N'), Key(' ')}); }

TEST_F(ViewerTest, RestoresEverythingAfterALostSurface) {
  Layout last;
  options_.channels = {{"cloud", "foxglove.PointCloud", {{"keep", "all"}}}};
  EXPECT_EQ(DoOnSurfaces(
                {{Key('T'), Key('4'), Lose}, {Key('H'), [&](ScriptedSurface&) { last = running_->CurrentLayout(); }}}),
            0);
  EXPECT_EQ(made_, 2U);
  EXPECT_EQ(PanelsOf(last), std::vector<std::string>{"Plot"});
  EXPECT_EQ(std::ranges::count(*last.displays, "cloud", &LayoutDisplay::channel), 1) << "once, not twice";
}

TEST_F(ViewerTest, EndsWatchingWhenTheViewerThrows) {
  std::vector<bool> watched;
  EXPECT_THROW((void)DoOnSurfaces({{[](ScriptedSurface&) { throw Error("The picture is too large."); }}},
                                  [&](Viewer* viewer) { watched.push_back(viewer != nullptr); }),
               Error);
  EXPECT_EQ(watched, (std::vector<bool>{true, false}));
}

TEST_F(ViewerTest, KeepsRemovedDisplaysRemovedAfterALostSurface) {
  Carried last;
  const auto watch = [&](Viewer* viewer) {
    if (viewer != nullptr && made_ == 1) viewer->TakeOver({{}, {"removed"}, false});
  };
  EXPECT_EQ(DoOnSurfaces({{Lose}, {[&](ScriptedSurface&) { last = running_->Carry(); }}}, watch), 0);
  EXPECT_EQ(made_, 2U);
  EXPECT_TRUE(last.found.contains("removed")) << "it does not come back";
  EXPECT_FALSE(last.keeps_finding) << "the written layout must not change because of the loss";
}

TEST_F(ViewerTest, GivesUpAfterRepeatedLossesOfTheSurface) {
  EXPECT_EQ(DoOnSurfaces({{Lose, DoNothing}, {Lose, DoNothing}, {Lose, DoNothing}}), 1);
  EXPECT_EQ(made_, 3U);
}

TEST_F(ViewerTest, RestoresTheViewRelativeToAFollowedFrameThatHasMoved) {
  options_.panels = false;
  const MetOnThisHost met;
  Session robot;
  Transforms transforms(robot);
  for (const bool follow_pose : {false, true}) {
    options_.displays = {{"Ground", "", {{"visible", "off"}}},
                         {"Frames", "", {{"names", "off"}, {"links", "off"}, {"axes length", "5"}}}};
    options_.fixed_frame = "map";
    options_.follow = "base";
    options_.follow_pose = follow_pose;
    transforms.ToStaticTF("map", "base", RigidTransform({1, 0, 0, 0}, {100, 0, 0}));
    transforms.Flush();
    std::vector<std::uint8_t> shown;
    const auto settled = Until([&](ScriptedSurface& surface) {
      shown = surface.Pixels();
      const bool drawn = std::ranges::any_of(shown, [](std::uint8_t value) { return value > 150; });
      return drawn && running_->CurrentLayout().camera->relative;
    });
    const Layout kept = Do({settled, Key('A'), Key('E'), settled});
    ASSERT_TRUE(kept.camera && kept.camera->relative);
    options_.displays.clear();
    options_.follow.clear();
    const Eigen::Quaterniond turn(follow_pose ? Eigen::AngleAxisd(2, Eigen::Vector3d(1, 2, 3).normalized())
                                              : Eigen::AngleAxisd::Identity());
    transforms.ToStaticTF("map", "base", RigidTransform(turn, {-300, 70, 5}));
    transforms.Flush();
    bool same = false;
    const Layout again = Do({Until([&](ScriptedSurface& surface) {
                              const std::vector<std::uint8_t> pixels = surface.Pixels();
                              std::size_t different = 0;
                              for (std::size_t i = 0; i < pixels.size(); ++i) {
                                different += std::abs(pixels[i] - shown[i]) > 48 ? 1U : 0U;
                              }
                              return same = 1000 * different < pixels.size();
                            })},
                            kept);
    EXPECT_TRUE(same) << follow_pose;
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(again.camera->eye[i], kept.camera->eye[i], 1e-6);
  }
}

TEST_F(ViewerTest, MovesAtOnceToANewlyFollowedFrame) {
  const MetOnThisHost met;
  Session robot;
  Transforms transforms(robot);
  const std::vector<StampedEdge> still = {{"map", "right", {}, RigidTransform({1, 0, 0, 0}, {-300, 70, 5})},
                                          {"map", "left", {}, RigidTransform({1, 0, 0, 0}, {100, 0, 0})}};
  transforms.ToStaticTF(still);
  transforms.Flush();
  options_.fixed_frame = "map";
  options_.follow = "left";
  LayoutCamera before;
  std::vector<ScriptedSurface::Step> steps = {Until([&](ScriptedSurface&) {
    before = *running_->CurrentLayout().camera;
    ImGui::SetWindowCollapsed("View", false);
    return before.relative;
  })};
  /// Clicks on a row of a window with rows of that height.
  const auto click = [&](const char* name, int row, float (*height)()) {
    steps.emplace_back(DoNothing);  // The window gets its size.
    steps.emplace_back([=](ScriptedSurface&) {
      const ImGuiWindow* const window = ImGui::FindWindowByName(name);
      ASSERT_NE(window, nullptr) << name;
      const ImVec2 begin = window->InnerRect.Min;
      const float above =
          window->WindowPadding.y + static_cast<float>(row) * (height() + ImGui::GetStyle().ItemSpacing.y);
      ImGui::GetIO().MousePos = {begin.x + 2 * ImGui::GetFontSize(), begin.y + above + 0.5F * height()};
    });
    for (const bool down : {true, false}) {
      steps.emplace_back([down](ScriptedSurface&) { ImGui::GetIO().MouseDown[0] = down; });
    }
  };
  click("View", 2, ImGui::GetFrameHeight);     // orthographic, from above, follow
  click("##Combo_00", 3, ImGui::GetFontSize);  // nothing, left, map, right
  steps.emplace_back(DoNothing);
  const Layout after = Do(std::move(steps));
  EXPECT_TRUE(before.relative);
  EXPECT_EQ(after.follow, "right");
  EXPECT_TRUE(after.camera->relative) << "nothing else has moved since";
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(after.camera->eye[i], before.eye[i], 1e-6);
}

/// A transparent white cube of 4 m around the origin of a frame.
foxglove::SceneUpdate Glass(const std::string& frame) {
  foxglove::SceneUpdate update;
  SetSolid(*AddEntity(update, "glass", frame).add_cubes(), {0, 0, 0}, {4, 4, 4}, {1, 1, 1, 0.4});
  return update;
}

TEST_F(ViewerTest, SetsTheAnchorOnlyOnVisibleThings) {
  options_.panels = false;
  options_.displays = {{"Ground", "", {{"visible", "off"}}}};
  options_.channels = {{"glass", "foxglove.SceneUpdate", {}}};
  const MetOnThisHost met;
  Session robot;
  constexpr Viewport kSmall{640, 300};
  std::optional<std::array<double, 3>> first;
  const auto shown = Until([&](ScriptedSurface& at) {
    (void)robot.ToAny("glass", Glass("map"));
    return at.Pixels()[3 * (kSmall.width * kSmall.height / 2 + kSmall.width / 2)] > 60;
  });
  const auto click = [&](ScriptedSurface& at) { at.Click(kSmall.width / 2.0, kSmall.height / 2.0, false); };
  const auto look = [&](ScriptedSurface&) { first = running_->CurrentLayout().camera->anchor; };
  const auto beside = [](ScriptedSurface& at) {
    at.Resize({640, 480});  // It has not been drawn with this size when the click arrives.
    at.Click(30, 20, false);
  };
  const Layout last = Do({Resize(kSmall), shown, click, DoNothing, look, beside, DoNothing});
  ASSERT_TRUE(first);
  for (const double along : *first) EXPECT_LT(std::abs(along), 2.01);
  EXPECT_EQ(last.camera->anchor, first) << "there is nothing in that corner";
}

TEST_F(ViewerTest, FollowsAFrameNamedOnlyByMessages) {
  options_.panels = false;
  options_.channels = {{"glass", "foxglove.SceneUpdate", {}}};
  options_.follow = "base";
  const MetOnThisHost met;
  Session robot;
  const auto followed = Until([&](ScriptedSurface&) {
    (void)robot.ToAny("glass", Glass("base"));
    return running_->CurrentLayout().camera->relative;
  });
  EXPECT_TRUE(Do({followed}).camera->relative);
}

TEST_F(ViewerTest, ShowsNothingIfTheLayoutHasNoDisplays) {
  Layout layout;
  layout.displays.emplace();
  EXPECT_EQ(Do({Key('H')}, layout).displays, layout.displays);
}

TEST_F(ViewerTest, AcceptsOnAndOffForVisible) {
  const std::pair<const char*, bool> cases[] = {{"on", true}, {"true", true}, {"off", false}, {"false", false}};
  for (const auto& [text, visible] : cases) {
    options_.displays = {{"Ground", "", {{"visible", text}}}};
    EXPECT_EQ(Do({Key('H')}).displays->front().visible, visible) << text;
  }
  options_.displays = {{"Ground", "", {{"visible", "no"}}}};
  EXPECT_NE(FaultOf(std::nullopt), "");
}

TEST_F(ViewerTest, ReportsMissingChannelsWhenTheWindowCloses) {
  options_.channels = {{"never", "", {}}};
  for (const bool into_memory : {false, true}) {
    if (into_memory) options_.offscreen = Viewport{64, 64};
    const auto [code, said] = Listen({Key('H')});
    EXPECT_EQ(code, into_memory ? 1 : 0);
    EXPECT_NE(said.find("The channel \"never\" was never published."), std::string::npos) << said;
  }
}

TEST_F(ViewerTest, DoesNotSayThatNothingHasArrivedIfAPanelShowsIt) {
  options_.fps_limit = 50;
  options_.offscreen = Viewport{64, 64};
  const MetOnThisHost met;
  Session robot;
  auto log = robot.Advertise<foxglove::Log>("log");
  for (const bool shown : {false, true}) {
    options_.opened_panels = {{"Channels", "", {}}};
    if (shown) options_.opened_panels = {{"Message", "", {{"channel", "log"}}}};
    // The table of a panel has a window of its own, as soon as it has rows.
    const std::string table = shown ? "Message/fields" : "Channels/channels";
    // The viewer lists what is published from time to time, so it gets a second more.
    auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    bool was_done = false;
    const ScriptedSurface::Step filled = [&](ScriptedSurface& at) {
      log(foxglove::Log());
      const bool done = std::ranges::any_of(ImGui::GetCurrentContext()->Windows, [&](const ImGuiWindow* window) {
        return std::string(window->Name).starts_with(table);
      });
      if (done && !std::exchange(was_done, true)) deadline = std::chrono::steady_clock::now() + std::chrono::seconds(1);
      if (std::chrono::steady_clock::now() < deadline) at.Again();
    };
    const auto [code, said] = Listen({filled});
    EXPECT_EQ(code, 0);
    EXPECT_TRUE(was_done);
    EXPECT_EQ(said.find("Nothing has arrived"), std::string::npos) << said;
    EXPECT_EQ(said.find("No display shows what is published: \"log\"") == std::string::npos, shown) << said;
  }
}

TEST_F(ViewerTest, SwitchesOtherSettingsThatAGivenOneNeeds) {
  const auto text = [](const Layout& layout, const std::string& name) {
    const LayoutDisplay display = DisplayOf(layout, "cloud");
    const auto setting = std::ranges::find(display.settings, name, &LayoutSetting::name);
    return setting == display.settings.end() ? "there is none" : setting->value;
  };
  Layout layout;
  layout.displays = {{{"Point cloud", "cloud", true, {{"field", "speed"}, {"lowest", "2"}}}}};
  const Layout restored = Do({Key('H')}, layout);
  EXPECT_EQ(text(restored, "color"), "value");
  EXPECT_EQ(text(restored, "auto range"), "off");
  EXPECT_EQ(Do({Key('H')}, restored).displays, restored.displays);
  options_.channels = {{"cloud", "foxglove.PointCloud", {{"seconds", "2"}}}};
  EXPECT_EQ(text(Do({Key('H')}), "keep"), "time");
}

TEST_F(ViewerTest, ExplainsThatAChannelHasAnotherType) {
  const std::string sentence = "\"cloud\" carries foxglove.PointCloud; a Grid shows foxglove.Grid.";
  Layout layout;
  layout.displays = {{{"Point cloud", "cloud", true, {}}, {"Grid", "cloud", true, {}, {"layout.yaml", 3, 5}}}};
  EXPECT_EQ(FaultOf(layout), "layout.yaml:3:5: " + sentence);
  options_.channels = {{"cloud", "foxglove.PointCloud", {}}, {"cloud", "foxglove.Grid", {}}};
  EXPECT_EQ(FaultOf(std::nullopt), sentence);
}

TEST_F(ViewerTest, ReportsErrorsInALayout) {
  const auto shown = [](LayoutDisplay display) {
    Layout layout;
    display.where = {"layout.yaml", 3, 5};
    layout.displays = {{display}};
    return layout;
  };
  const std::pair<LayoutDisplay, const char*> cases[] = {{{"Groud", "", true, {}}, "There are Point cloud"},
                                                         {{"Point cloud", "", true, {}}, "needs a channel"},
                                                         {{"Ground", "cloud", true, {}}, "has no channel"}};
  for (const auto& [display, words] : cases) {
    const std::string fault = FaultOf(shown(display));
    EXPECT_TRUE(fault.starts_with("layout.yaml:3:5: ") && fault.find(words) != std::string::npos) << fault;
  }
  const LayoutSetting wrong{"cell", "x", {"layout.yaml", 7, 9}};
  EXPECT_NE(FaultOf(shown({"Ground", "", true, {wrong}})).find("layout.yaml:7:9"), std::string::npos);
  Layout layout;
  layout.panels = {{{"Radar", std::nullopt, {}}, {"layout.yaml", 2, 5}}};
  EXPECT_NE(FaultOf(layout).find("layout.yaml:2:5"), std::string::npos);
}

TEST_F(ViewerTest, NeverReplacesALayoutThatItHasNotRead) {
  const hgros::test::ScratchFolder folder;
  options_.config = folder / "layout.yaml";
  folder.Write("layout.yaml", "mine");
  std::string second;
  const auto read = [&](ScriptedSurface& at) {
    second = folder.Read("layout-2.yaml");
    at.Press('4');
  };
  (void)Do({Key('L'), read, Key('L'), Key('H')});
  EXPECT_EQ(folder.Read("layout.yaml"), "mine");
  EXPECT_NE(second.find("displays:"), std::string::npos) << "it has another name";
  EXPECT_NE(folder.Read("layout-2.yaml").find("kind: Plot"), std::string::npos) << "its own file is replaced";
  EXPECT_FALSE(std::filesystem::exists(folder / "layout-3.yaml"));
}

TEST_F(ViewerTest, ReplacesTheLayoutThatItHasReadAndThatOnly) {
  const hgros::test::ScratchFolder folder;
  options_.config = folder / "layout.yaml";
  folder.Write("layout.yaml", "fixed_frame: map\n");
  Layout layout;
  layout.fixed_frame = "map";
  (void)Do({Key('L'), Key('H')}, layout);
  EXPECT_NE(folder.Read("layout.yaml").find("displays:"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "layout-2.yaml"));
  layout.save_on_exit = true;
  options_.config.clear();  // A lost surface gives a layout without a file.
  ScriptedSurface surface({Key('H')});
  Viewer viewer(options_, layout, surface);
  LayoutTarget target(folder / "other.yaml");
  target.save_on_exit = true;
  folder.Write("other.yaml", "mine");
  viewer.TakeOver({{}, {}, false, target});
  EXPECT_EQ(viewer.Run(), 0);
  EXPECT_EQ(folder.Read("other.yaml"), "mine") << "it is not replaced on exit either";
  EXPECT_NE(folder.Read("other-2.yaml").find("displays:"), std::string::npos);
}

/// Cameras that publish from another session.
class Cameras {
 public:
  explicit Cameras(std::size_t count) : count_(count) {}
  /// Publishes. Returns whether all windows of the images are there.
  bool Shown() {
    constexpr std::pair<std::uint32_t, std::uint32_t> kSizes[] = {{64, 48}, {124, 38}, {48, 64}};
    for (std::size_t i = 0; i < count_; ++i) {
      foxglove::RawImage image;
      const auto [width, height] = kSizes[i % std::size(kSizes)];
      image.set_width(width);
      image.set_height(height);
      image.set_step(width);
      image.set_encoding("mono8");
      image.set_data(std::string(std::size_t{width} * height, static_cast<char>(40 * i)));
      (void)session_.ToAny("camera_" + std::to_string(i), image);
    }
    return Windows("##image").size() >= count_;
  }
  /// The shown windows with such a name.
  static std::vector<ImGuiWindow*> Windows(const std::string& part) {
    std::vector<ImGuiWindow*> all;
    for (ImGuiWindow* const window : ImGui::GetCurrentContext()->Windows) {
      const bool shown = window->Active && !window->Hidden && (window->Flags & ImGuiWindowFlags_ChildWindow) == 0;
      if (shown && std::string(window->Name).find(part) != std::string::npos) all.push_back(window);
    }
    return all;
  }

 private:
  const std::size_t count_;
  Session session_;
};

TEST_F(ViewerTest, ImageWindowsCoverNothingAtAnySize) {
  const MetOnThisHost met;
  Cameras cameras(5);
  std::vector<ScriptedSurface::Step> steps;
  const auto check = [](const std::string& when) {
    return [when](ScriptedSurface& at) {
      const std::vector<ImGuiWindow*> images = Cameras::Windows("##image");
      EXPECT_EQ(images.size(), 5U) << when;
      std::vector<ImGuiWindow*> others = images;
      for (const char* name : {"Displays", "View", "status", "Plot", "Channels"}) {
        for (ImGuiWindow* const window : Cameras::Windows(name)) others.push_back(window);
      }
      for (ImGuiWindow* const image : images) {
        const ImRect rect = image->Rect();
        EXPECT_TRUE(rect.Min.x >= 0 && rect.Min.y >= 0 && rect.Max.x <= static_cast<float>(at.size().width) &&
                    rect.Max.y <= static_cast<float>(at.size().height))
            << image->Name << ", " << when;
        for (ImGuiWindow* const other : others) {
          EXPECT_TRUE(other == image || !rect.Overlaps(other->Rect()))
              << image->Name << " and " << other->Name << ", " << when;
        }
      }
    };
  };
  const Viewport sizes[] = {{1280, 800}, {800, 600}, {1920, 1080}, {800, 600}, {1280, 800}};
  for (const bool panels : {false, true}) {
    for (const Viewport size : sizes) {
      steps.push_back(Resize(size));
      if (steps.size() == 1) steps.push_back(Until([&](ScriptedSurface&) { return cameras.Shown(); }));
      for (int i = 0; i < 3; ++i) steps.emplace_back(DoNothing);
      steps.push_back(check(std::to_string(size.width) + (panels ? " with panels" : "")));
    }
    steps.push_back(Key('1'));
    steps.push_back(Key('4'));
  }
  (void)Do(std::move(steps), std::nullopt, {1920, 1080});
}

TEST_F(ViewerTest, KeepsTheMovedWindowOfAnImageInTheLayout) {
  const MetOnThisHost met;
  Cameras cameras(3);
  static constexpr const char* kName = "camera_1##image";
  const auto save_place = [](PanelPlace& to) {
    return [&to](ScriptedSurface&) {
      const std::vector<ImGuiWindow*> windows = Cameras::Windows(kName);
      if (!windows.empty()) to = {windows[0]->Pos.x, windows[0]->Pos.y, windows[0]->Size.x, windows[0]->Size.y};
    };
  };
  PanelPlace before, moved;
  const auto point = [&](float dx, float dy) {
    return [&, dx, dy](ScriptedSurface&) { ImGui::GetIO().MousePos = {before.x + 60 + dx, before.y + 8 + dy}; };
  };
  const auto press = [](bool down) { return [down](ScriptedSurface&) { ImGui::GetIO().MouseDown[0] = down; }; };
  const auto shown = [&] { return Until([&](ScriptedSurface&) { return cameras.Shown(); }); };
  const Layout kept =
      Do({Resize({1280, 800}), shown(), DoNothing, DoNothing, save_place(before), point(0, 0), DoNothing, press(true),
          DoNothing, point(-120, -200), DoNothing, press(false), DoNothing, save_place(moved)},
         std::nullopt, {1920, 1080});
  EXPECT_EQ(moved, (PanelPlace{before.x - 120, before.y - 200, before.width, before.height}));
  EXPECT_EQ(DisplayOf(kept, "camera_1").place, moved);
  EXPECT_EQ(DisplayOf(kept, "camera_0").place, std::nullopt) << "nobody has moved it";

  PanelPlace again, small, later;
  const ImGuiWindow* in_front = nullptr;
  const Layout last =
      Do({Resize({1280, 800}), shown(), DoNothing, DoNothing, save_place(again),
          [&](ScriptedSurface&) { in_front = Cameras::Windows("##image").back(); }, Resize({500, 300}), DoNothing,
          DoNothing, save_place(small), Resize({1280, 800}), DoNothing, DoNothing, save_place(later)},
         kept, {1920, 1080});
  EXPECT_EQ(again, moved);
  ASSERT_NE(in_front, nullptr);
  EXPECT_TRUE(std::string(in_front->Name).starts_with(kName)) << in_front->Name << " covers the moved one";
  EXPECT_LE(small.x + small.width, 500) << "it stays inside a smaller window";
  EXPECT_LE(small.y + small.height, 300);
  EXPECT_EQ(later, moved) << "and returns when that grows again";
  EXPECT_EQ(DisplayOf(last, "camera_1").place, moved);
}

foxglove::PointCloud CloudAt(std::int64_t ns) {
  foxglove::PointCloud cloud;
  cloud.set_frame_id("lidar");
  SetStamp(*cloud.mutable_timestamp(), ns);
  SetFloatFields(cloud);
  const float point[4] = {1, 2, 3, 4};
  cloud.set_data(std::string(reinterpret_cast<const char*>(point), sizeof point));
  return cloud;
}

TEST_F(ViewerTest, DoesNotReportACloudThatWaitsShortlyForItsTransform) {
  options_.panels = false;
  options_.offscreen = Viewport{64, 64};
  options_.displays = {{"Ground", "", {{"visible", "off"}}}, {"Frames", "", {{"visible", "off"}}}};
  options_.channels = {{"cloud", "foxglove.PointCloud", {{"color", "flat"}, {"size", "20"}}}};
  for (const bool drawn_before : {true, false}) {
    const MetOnThisHost met;
    Session robot;
    Transforms transforms(robot);
    auto clouds = robot.Advertise<foxglove::PointCloud>("cloud");
    const char* const frame = drawn_before ? "lidar" : "camera";
    transforms.ToTF(Time{1'000'000'000}, "map", frame, RigidTransform());
    transforms.Flush();
    const auto drawn = Until([&](ScriptedSurface& at) {
      EXPECT_TRUE(robot.WaitForSubscribers("cloud", 1, std::chrono::seconds(20)));
      if (!drawn_before) return true;
      (void)clouds(CloudAt(1'000'000'000));
      return std::ranges::any_of(at.Pixels(), [](std::uint8_t value) { return value > 150; });
    });
    // Each cloud is 5 ns newer than the newest transform, until the next one comes, or its frame has none.
    const ScriptedSurface::Step late = [&, count = 0](ScriptedSurface& at) mutable {
      const std::int64_t now = 1'000'000'000 + (drawn_before ? 10 * ++count : 0);
      transforms.ToTF(Time{now}, "map", frame, RigidTransform());
      transforms.Flush();
      (void)clouds(CloudAt(now + 5));
      if (at.pictures() < 150) at.Again();
    };
    const auto [code, said] = Listen({drawn, late, Key('H')});
    EXPECT_EQ(code, drawn_before ? 0 : 1) << said;
    EXPECT_EQ(said.find("lidar") == std::string::npos, drawn_before) << said;
  }
}

}  // namespace
}  // namespace hgros::viewer::test
