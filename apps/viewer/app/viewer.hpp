#pragma once

#include <atomic>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "hgros/session/session.hpp"
#include "hgros/tf/transforms.hpp"
#include "viewer/app/displays/channel_list.hpp"
#include "viewer/app/displays/display_opener.hpp"
#include "viewer/app/displays/unreadable_counter.hpp"
#include "viewer/app/frame_follower.hpp"
#include "viewer/app/frame_pace.hpp"
#include "viewer/app/layout/carried.hpp"
#include "viewer/app/layout/layout.hpp"
#include "viewer/app/notices.hpp"
#include "viewer/app/options.hpp"
#include "viewer/app/output/picture_writer.hpp"
#include "viewer/app/picker.hpp"
#include "viewer/app/playback.hpp"
#include "viewer/app/surface/surface.hpp"
#include "viewer/panels/display_panel.hpp"
#include "viewer/panels/image_panel.hpp"
#include "viewer/panels/view_panel.hpp"
#include "viewer/panels/widgets/imgui_renderer.hpp"
#include "viewer/panels/widgets/look.hpp"
#include "viewer/scene/scene.hpp"
#include "viewer/view/navigation.hpp"

namespace hgros::viewer {

/// The program: joins a session, a scene, panels and a camera on a surface, and runs their turns. It sleeps until
/// something has changed.
class Viewer {
 public:
  /// `layout` is the layout read from the options' file, or none.
  /// Errors: throws Error if there is no session, or the options name something that does not exist.
  Viewer(const Options& options, const std::optional<Layout>& layout, Surface& surface);
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;
  ~Viewer();

  /// Runs until the window is closed, the options say so, Stop is called, or the surface is lost. Returns the exit
  /// code.
  int Run();
  /// Thread-safe.
  void Stop();
  /// Run has ended because the surface was lost: make another surface, and another viewer with this one's layout.
  [[nodiscard]] bool lost() const noexcept { return lost_; }
  /// The layout as it is now.
  [[nodiscard]] Layout CurrentLayout() const;
  /// What the next viewer needs in addition, ...
  [[nodiscard]] Carried Carry() const;
  /// ... and takes over before it runs.
  void TakeOver(Carried carried);

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  /// Applies the layout of a file or of a lost surface. The command line is applied later and wins.
  void Restore(const Layout& layout);
  void ApplyOptions();
  void WriteLayout();

  void WakeFromData();
  [[nodiscard]] double NextTurnS() const;
  void RunTurn(double now_s);
  void UpdateChannels();
  void HandleInput();
  void HandleKey(int key);
  void UpdateScene(double now_s);
  void SetPaused(bool paused);
  /// In that part of the picture.
  void ShowEverything(const PixelArea& room);
  [[nodiscard]] bool ReachedEnd(double now_s);
  void PrintReport(double now_s);

  void DrawFrame(double now_s);
  /// Fits fonts and lines to the screen that the window is on now.
  void UpdateScale();
  void LoadGlyphs(Glyphs glyphs);
  void DrawOverlaysAndPanels();
  /// Returns the display that a user removes, or none.
  [[nodiscard]] std::optional<std::size_t> DrawPanels();
  void DrawPausedTimeBar();
  [[nodiscard]] PixelArea WholeArea() const;
  /// The largest part of the picture that no panel covered in the last frame.
  [[nodiscard]] PixelArea FreeArea() const;

  /// `config` is the session's.
  Viewer(const Options& options, const std::optional<Layout>& layout, Surface& surface, const Config& config);

  const Options options_;
  const std::string reach_;  ///< Which programs it finds.
  Surface& surface_;
  std::atomic<bool> woken_ = true;
  std::atomic<bool> stop_ = false;
  std::atomic<bool> transforms_changed_ = false;
  std::atomic<bool> channels_changed_ = true;
  Session session_;
  Transforms transforms_;
  FixedFrame frame_;
  Scene scene_;
  Camera camera_;
  Navigation navigation_;

  Notices notices_;
  FramePace pace_;
  ChannelList channels_;
  DisplayOpener displays_;
  UnreadableCounter unreadable_;
  Playback playback_;
  FrameFollower follower_;
  Picker picker_;
  PictureWriter pictures_;

  ImguiRenderer panels_renderer_;
  DisplayPanel display_panel_;
  PanelDock dock_;
  ViewPanel view_panel_;
  ImagePanel image_panel_;
  LayoutTarget layout_file_;
  bool show_panels_ = true;
  bool show_help_ = false;
  float scale_ = 1;
  Glyphs glyphs_ = Glyphs::kLatin;
  Glyphs most_glyphs_ = Glyphs::kAll;  ///< The graphics card can hold these.

  bool frame_changed_ = false;         ///< The fixed frame is another one since the last turn.
  bool whole_picture_wanted_ = false;  ///< The end is reached once the picture is complete.
  bool lost_ = false;
  double begin_s_ = 0;
  double next_report_s_ = kNever;

  std::vector<Subscription> subscriptions_;  ///< Last: their callbacks use the others.
};

}  // namespace hgros::viewer
