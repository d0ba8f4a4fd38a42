#pragma once

#include <atomic>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hgros/session/session.hpp"
#include "hgros/tf/transforms.hpp"
#include "viewer/app/carried.hpp"
#include "viewer/app/layout.hpp"
#include "viewer/app/options.hpp"
#include "viewer/app/surface.hpp"
#include "viewer/app/video_recorder.hpp"
#include "viewer/panels/display_panel.hpp"
#include "viewer/panels/image_panel.hpp"
#include "viewer/panels/imgui_renderer.hpp"
#include "viewer/panels/key_table.hpp"
#include "viewer/panels/panel_dock.hpp"
#include "viewer/panels/view_panel.hpp"
#include "viewer/scene/scene.hpp"
#include "viewer/view/navigation.hpp"
#include "viewer/view/point_picks.hpp"

namespace hgros::viewer {

/// The program: a session, a scene, panels and a camera, on a surface. It sleeps until something has changed.
class Viewer {
 public:
  /// Errors: throws Error if the session cannot be had, or the options name what there is not.
  /// `layout` is what was read from the options' file, or none.
  Viewer(const Options& options, const std::optional<Layout>& layout, Surface& surface);
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;
  ~Viewer();

  /// Until the window is closed, the options' end has come, Stop, or the surface is lost. Returns the exit code.
  int Run();
  /// Thread-safe.
  void Stop();
  /// Run has ended because the surface was lost: make another one, and another viewer with this one's layout.
  [[nodiscard]] bool lost() const noexcept { return lost_; }
  /// All that makes it look as it does.
  [[nodiscard]] Layout CurrentLayout() const;
  /// What the next viewer needs beside that, ...
  [[nodiscard]] Carried Carry() const;
  /// ... and takes before it runs.
  void TakeOver(Carried carried);

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  static constexpr int kFramesAfterInput = 3;

  void WakeFromData();
  void AddWanted();
  void AddPanels();
  /// What a file or a lost window says; what the command line says goes before. Throws Error where it cannot be had.
  void Restore(const Layout& layout);
  void RestoreDisplays(const std::vector<LayoutDisplay>& displays);
  void SaveLayoutNow();
  void TakeChannels();
  /// Whether it could be added.
  bool AddOrSay(const DisplayType& type, const WantedDisplay& wanted);
  void Add(const DisplayType& type, const std::string& channel,
           const std::vector<std::pair<std::string, std::string>>& settings);
  /// Throws Error, in a person's words, where the channel has another type.
  Scene::Entry& Open(const DisplayType& type, const std::string& channel);
  /// What cannot be is said beside the button.
  void AddByHand(const DisplayType& type, const std::string& channel);
  /// The type that is published there, one that the display shows if there are several; empty: nobody knows yet.
  [[nodiscard]] std::string CarriedBy(const std::string& channel, const DisplayType& type) const;
  /// Displays whose channel turns out to carry something else.
  void SayMismatches();
  void Set(Scene::Entry& entry, const std::vector<std::pair<std::string, std::string>>& settings);

  [[nodiscard]] double NextTurnS() const;
  void Turn(double now_s);
  void TakeInput();
  void OnKey(int key);
  /// Sets the anchor on what is there, or picks the point to be measured.
  void Pick(const Eigen::Vector2d& pixel, bool measures);
  /// While it stands still, messages wait in the displays' inboxes, which drop the oldest.
  void SetPaused(bool paused);
  /// Shows once what has come until now.
  void Step();
  void LookBack(double back_s);
  /// How far back one can look, and all that is seen is what was there.
  [[nodiscard]] double KeptS() const;
  void ShowEverything();
  void TakeArrived(double now_s);
  void DrawFrame(double now_s);
  void FollowFrame();
  void KeepTransforms();
  /// To the fixed frame, as the picture has it; none if that is not known any more.
  [[nodiscard]] std::optional<RigidTransform> TransformInPicture(const std::string& frame) const;
  /// Fonts and lines for the screen that the window is on now.
  void TakeScale();
  /// Asks the session what could not be read, every now and then: such messages wake nobody.
  void CountUnreadable(double now_s);
  void DrawPanels();
  [[nodiscard]] bool AtEnd(double now_s);
  /// On standard error: what was asked for by name and is not there at the end. Into memory that is a fault.
  void SayWhatIsUnmet();
  [[nodiscard]] bool IsFixedFrameKnown(const std::vector<std::string>& frames) const;
  void WriteScreenshot(const std::filesystem::path& file);
  void RecordFrame();
  void FinishFilm();
  /// Something could not be written: said, and told by the exit code.
  void Complain(const std::string& fault);
  /// What the surface shows, as rows from the top, 3 bytes a pixel.
  [[nodiscard]] std::vector<std::uint8_t> ShownPixels() const;
  void Report(double now_s);

  const Options options_;
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
  ImguiRenderer panels_renderer_;
  DisplayPanel display_panel_;
  PanelDock dock_;
  ViewPanel view_panel_;
  ImagePanel image_panel_;

  std::vector<KnownChannel> known_;        ///< Without the library's own.
  std::vector<ChannelRow> channels_;       ///< What is published now.
  std::vector<WantedDisplay> awaited_;     ///< Their schema is still to be heard of.
  std::set<std::string> shown_by_itself_;  ///< Also those that were removed since.
  bool frame_changed_ = false;
  bool paused_ = false;
  bool steps_ = false;
  double newest_s_ = -kNever;  ///< When displays took in something last.
  double back_s_ = 0;
  bool picking_ = false;
  PointPicks picks_;
  bool help_ = false;
  bool show_panels_ = true;
  int frames_wanted_ = 3;  ///< ImGui settles within some frames after each thing that a person does.
  bool whole_picture_wanted_ = false;
  std::string notice_;
  std::filesystem::path screenshot_;                       ///< To be written with the next frame.
  std::map<std::string, RigidTransform> kept_transforms_;  ///< Of the displays' frames, while the view stands still.
  std::string followed_name_;
  std::optional<RigidTransform> followed_;  ///< Where the frame that is followed was.
  bool seen_from_followed_ = false;         ///< The camera is as if that frame, still to be found, lay at the origin.
  bool unmet_ = false;                      ///< Something that was asked for could not be shown.
  int exit_code_ = 0;
  double fps_limit_ = 30;
  bool shows_what_it_finds_ = true;
  bool keeps_finding_ = false;  ///< With the layout that is written, too.
  bool lost_ = false;
  float look_scale_ = 1;
  ViewPanel::LayoutFile layout_file_;
  std::optional<VideoRecorder> film_;

  double begin_s_ = 0;
  double last_turn_s_ = -kNever;
  double idle_s_ = kNever;  ///< When the status line has to say that nothing is drawn.
  double next_report_s_ = kNever;
  double next_count_s_ = 0;
  std::size_t frames_ = 0;
  std::vector<double> frame_times_s_;  ///< Of the last second.

  std::vector<Subscription> subscriptions_;  ///< Last: their callbacks use the others.
};

}  // namespace hgros::viewer
