#include "viewer/app/viewer.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "hgros/base/error.hpp"
#include "viewer/app/displays/awaited.hpp"
#include "viewer/app/displays/display_settings.hpp"
#include "viewer/app/displays/unmet_requests.hpp"
#include "viewer/app/layout/layout_file.hpp"
#include "viewer/app/process_figures.hpp"
#include "viewer/panels/overlay/key_table.hpp"
#include "viewer/panels/widgets/look.hpp"

namespace hgros::viewer {
namespace {

double NowS() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

Config SessionConfig(const Options& options) {
  return options.network.empty() ? Config() : Config::Load(options.network);
}

}  // namespace

Viewer::Viewer(const Options& options, const std::optional<Layout>& layout, Surface& surface)
    : Viewer(options, layout, surface, SessionConfig(options)) {}

Viewer::Viewer(const Options& options, const std::optional<Layout>& layout, Surface& surface, const Config& config)
    : options_(options),
      reach_(ReachText(config)),
      surface_(surface),
      session_(config, {.name = "hgros-viewer"}),
      transforms_(session_, {.max_ahead = Duration::max(),  // Hosts with wrong clocks are shown, too.
                             .on_received =
                                 [this] {
                                   if (!transforms_changed_.exchange(true)) WakeFromData();
                                 }}),
      frame_(transforms_.tree()),
      navigation_(camera_),
      displays_(session_, scene_, channels_, notices_, [this] { WakeFromData(); }),
      unreadable_(session_, scene_, channels_),
      playback_(scene_, frame_),
      follower_(camera_),
      picker_(scene_, camera_, frame_, playback_),
      pictures_(surface, notices_),
      dock_(session_, [this] { surface_.Wake(); }),
      show_panels_(options.panels),
      scale_(surface.scale()),
      begin_s_(NowS()) {
  if (!options.film.empty()) pictures_.StartFilm(options.film);
  if (options.report_s) next_report_s_ = begin_s_ + *options.report_s;
  subscriptions_.push_back(session_.FromGraph<ChannelsChanged>(kChannelEventsChannel, Invoke::kSerial,
                                                               [this](const ChannelsChanged&) {
                                                                 channels_changed_ = true;
                                                                 WakeFromData();
                                                               },
                                                               {.queue = Queue::Latest()}));
  SetLook(scale_);
  displays_.SetShowFound(options.channels.empty());
  layout_file_.path = options.config.empty() ? "hgros-viewer.yaml" : options.config;
  if (!options.config.empty() && layout) layout_file_.NoteOwn();
  if (layout) Restore(*layout);
  if (!layout || !layout->displays) displays_.AddDefaults();
  ApplyOptions();
}

Viewer::~Viewer() {
  subscriptions_.clear();
  scene_.entries().clear();
}

void Viewer::Restore(const Layout& layout) {
  frame_.Ask(layout.fixed_frame);
  view_panel_.Follow(layout.follow, layout.follow_pose);
  if (layout.fps_limit) pace_.SetLimit(*layout.fps_limit);
  layout_file_.save_on_exit = layout.save_on_exit;
  if (layout.camera) follower_.Restore(*layout.camera, layout.follow);
  displays_.Restore(layout);
  if (layout.displays) {  // The scene has these displays, in the same order.
    for (std::size_t i = 0; i < layout.displays->size(); ++i) {
      const auto& place = (*layout.displays)[i].place;
      if (place) image_panel_.Restore(*scene_.entries()[i].display, *place);
    }
  }
  for (const LayoutPanel& panel : layout.panels) {
    const std::string fault = dock_.Restore(panel.panel);
    if (!fault.empty()) throw ConfigError(fault, panel.where);
  }
}

void Viewer::ApplyOptions() {
  displays_.AddRequested(options_);
  for (const WantedDisplay& wanted : options_.opened_panels) {
    const std::string fault = dock_.Restore({wanted.channel, std::nullopt, wanted.settings});
    if (!fault.empty()) throw Error(fault);
  }
  if (!options_.fixed_frame.empty()) frame_.Ask(options_.fixed_frame);
  if (options_.fps_limit) pace_.SetLimit(*options_.fps_limit);
  if (options_.from_above) camera_.LookFromAbove();
  if (options_.orthographic) camera_.SetOrthographic(true);
  if (!options_.follow.empty()) view_panel_.Follow(options_.follow, options_.follow_pose);
}

Layout Viewer::CurrentLayout() const {
  Layout layout;
  if (!frame_.chosen()) layout.fixed_frame = frame_.name();
  layout.follow = view_panel_.follow();
  layout.follow_pose = view_panel_.with_rotation();
  layout.fps_limit = pace_.limit();
  layout.save_on_exit = layout_file_.save_on_exit;
  layout.camera = follower_.KeptCamera(layout.follow, layout.follow_pose);
  layout.show_found = displays_.show_found();
  layout.displays = KeptDisplays(scene_);
  for (std::size_t i = 0; i < scene_.entries().size(); ++i) {
    (*layout.displays)[i].place = image_panel_.PlaceOf(*scene_.entries()[i].display);
  }
  for (const PanelLayout& panel : dock_.KeptLayout()) layout.panels.push_back({panel, {}});
  return layout;
}

void Viewer::WriteLayout() {
  Layout layout = CurrentLayout();
  layout.show_found = displays_.keeps_show_found();
  const std::filesystem::path file = layout_file_.Next();
  const std::string fault = SaveLayout(layout, file);
  if (fault.empty()) {
    std::error_code ignored;
    const std::string wrote = "wrote " + std::filesystem::absolute(file, ignored).string();
    if (file == layout_file_.path) {
      notices_.Show(wrote);
    } else {  // At the exit, only standard error is left.
      notices_.ShowAndPrint(wrote + "; " + layout_file_.path.filename().string() + " is another layout and stays");
    }
    layout_file_.path = file;
    layout_file_.NoteOwn();
  } else {
    notices_.Fail(fault);
  }
  pace_.WantAfterInput();
}

Carried Viewer::Carry() const {
  Carried carried = displays_.Carry();
  carried.layout_file = layout_file_;
  return carried;
}

void Viewer::TakeOver(Carried carried) {
  if (carried.layout_file) layout_file_ = *carried.layout_file;
  displays_.TakeOver(std::move(carried));
}

void Viewer::WakeFromData() {
  if (!woken_.exchange(true)) surface_.Wake();
}

void Viewer::Stop() {
  stop_ = true;
  surface_.Wake();
}

int Viewer::Run() {
  while (!stop_ && !surface_.closing()) {
    const double now_s = NowS();
    surface_.Wait(std::max(0.0, NextTurnS() - now_s));
    if (stop_ || surface_.closing()) break;
    if (surface_.TakeDisturbed()) pace_.WantAfterInput();
    const double woken_s = NowS();
    if (woken_s < NextTurnS()) continue;
    RunTurn(woken_s);
    if ((lost_ = surface_.lost())) break;
    if (woken_s >= next_report_s_) PrintReport(woken_s);
    if (ReachedEnd(woken_s)) break;
  }
  pictures_.FinishFilm();
  if (lost_) return notices_.exit_code();
  if (layout_file_.save_on_exit) WriteLayout();
  const bool unmet = PrintUnmetRequests({options_, scene_, channels_, displays_, frame_, view_panel_.follow()});
  if (unmet && options_.offscreen) notices_.SetFailed();
  const std::string awaited = AwaitedText(scene_, dock_, channels_, displays_, frame_);
  if (options_.offscreen && !awaited.empty()) {
    Notices::Print((awaited.starts_with("Waiting") ? "Nothing has arrived. " : "") + awaited + " " + reach_);
  }
  return notices_.exit_code();
}

double Viewer::NextTurnS() const {
  const bool draws_on = pace_.wanted() || scene_.unfinished() || whole_picture_wanted_;
  const bool due = woken_ || (draws_on && !surface_.hidden());
  const double soonest_s = pace_.soonest_turn_s();
  const auto at_the_soonest = [&](double time_s) { return std::max(soonest_s, time_s); };
  double next_s = due ? soonest_s : at_the_soonest(playback_.paused() ? kNever : scene_.next_change_s());
  if (show_panels_ && !surface_.hidden()) {
    next_s = std::min(next_s, at_the_soonest(std::min({dock_.next_change_s(), pace_.idle_s(), unreadable_.next_s()})));
  }
  if (options_.after_s) next_s = std::min(next_s, at_the_soonest(begin_s_ + *options_.after_s));
  return std::min(next_s, next_report_s_);
}

void Viewer::RunTurn(double now_s) {
  pace_.BeginTurn(now_s);
  woken_ = false;
  const Camera before = camera_;
  UpdateChannels();
  HandleInput();
  UpdateScene(now_s);
  if (unreadable_.Update(now_s)) pace_.WantOne();
  if (show_panels_ && !surface_.hidden() && dock_.Update({now_s, channels_.known()})) pace_.WantOne();
  if (show_panels_ && now_s >= pace_.idle_s()) pace_.WantOne();
  const bool moved = !camera_.SameViewAs(before);
  const bool wanted = moved || pace_.wanted() || scene_.unfinished() || scene_.pending();
  if (!wanted || surface_.hidden()) return;
  pace_.CountDownWanted();
  DrawFrame(now_s);
}

void Viewer::UpdateChannels() {
  if (!channels_changed_.exchange(false)) return;
  channels_.Refresh(session_);
  displays_.AddPublished();
  displays_.UpdateMismatches();
  dock_.Refresh();
  unreadable_.CountSoon(pace_.last_turn_s());
  pace_.WantAfterInput();
}

void Viewer::HandleInput() {
  const Viewport size = surface_.size();
  for (const InputEvent& event : surface_.TakeInput()) {
    switch (event.kind) {
      case InputEvent::Kind::kPress: navigation_.OnPress(event.button, event.x, event.y); break;
      case InputEvent::Kind::kRelease:
        if (const auto pixel = navigation_.OnRelease(event.button, event.x, event.y)) {
          notices_.Show(picker_.Click(surface_, *pixel, picker_.active() || event.shift));
        }
        break;
      case InputEvent::Kind::kPointer: navigation_.OnPointer(event.x, event.y, size); break;
      case InputEvent::Kind::kWheel: navigation_.OnWheel(event.steps, size); break;
      case InputEvent::Kind::kKey: HandleKey(event.key); break;
    }
  }
}

void Viewer::HandleKey(int key) {
  const auto table = KeyTable();
  const auto row = std::ranges::find(table, key, &KeyRow::key);
  if (row == table.end()) return;
  switch (row->viewer) {
    case ViewerKey::kNone: navigation_.OnKey(row->camera); break;
    case ViewerKey::kHelp: show_help_ = !show_help_; break;
    case ViewerKey::kPause: SetPaused(!playback_.paused()); break;
    case ViewerKey::kStep: playback_.Step(); break;
    case ViewerKey::kPick: picker_.ToggleActive(); break;
    case ViewerKey::kForget: picker_.Clear(); break;
    case ViewerKey::kOnePanel:
      dock_.Toggle(PanelTypes()[static_cast<std::size_t>(key - '1')]);
      pace_.WantAfterInput();
      break;
    case ViewerKey::kSaveLayout: WriteLayout(); break;
    case ViewerKey::kPanels: show_panels_ = !show_panels_; break;
    case ViewerKey::kFocus: ShowEverything(WholeArea()); break;
    case ViewerKey::kScreenshot:
      pictures_.RequestScreenshotNamedByTime();
      pace_.WantAfterInput();
      break;
  }
}

void Viewer::UpdateScene(double now_s) {
  if (!playback_.BeginTurn(now_s)) {
    scene_.ApplySettings({frame_, now_s, false, false});
    return;
  }
  const bool transforms_changed = transforms_changed_.exchange(false);
  if (transforms_changed) frame_changed_ |= frame_.Refresh();
  // A message may name the fixed frame, so a frame that is not found yet is searched for in each turn.
  if (transforms_changed || frame_changed_ || follower_.searches(view_panel_.follow())) {
    follower_.Update(frame_, view_panel_.follow(), view_panel_.with_rotation());
  }
  scene_.Update({frame_, now_s, frame_changed_, transforms_changed});
  frame_changed_ = false;
  playback_.EndTurn();
}

void Viewer::SetPaused(bool paused) {
  if (paused) return playback_.Pause();
  const std::uint64_t lost = playback_.Resume();
  if (lost == 0) return;
  notices_.Show(std::to_string(lost) + (lost == 1 ? " message was" : " messages were") +
                " dropped while the view was paused");
}

void Viewer::ShowEverything(const PixelArea& room) {
  const Eigen::AlignedBox3d bounds = scene_.Bounds();
  if (!bounds.isEmpty()) camera_.Focus(bounds, surface_.size(), room);
}

bool Viewer::ReachedEnd(double now_s) {
  const bool end = (options_.after_s && now_s >= begin_s_ + *options_.after_s) ||
                   (options_.frames && pace_.frames() >= *options_.frames) || whole_picture_wanted_;
  if (!end) return false;
  if (options_.screenshot.empty()) return true;
  if (!whole_picture_wanted_ && options_.show_all) {
    ShowEverything(FreeArea());
    pace_.WantAfterInput();
  }
  whole_picture_wanted_ = true;
  if (pace_.wanted() || scene_.unfinished() || scene_.pending()) return false;
  pictures_.RequestScreenshot(options_.screenshot);
  DrawFrame(now_s);
  return true;
}

void Viewer::PrintReport(double now_s) {
  next_report_s_ = now_s + *options_.report_s;
  std::fprintf(stderr, "seconds=%.1f frames=%zu points=%zu gpu_mb=%.1f rss_mb=%.1f cpu_s=%.2f\n", now_s - begin_s_,
               pace_.frames(), scene_.points(), static_cast<double>(scene_.gpu_bytes()) / 1e6,
               static_cast<double>(ResidentBytes()) / 1e6, ProcessorSeconds());
}

}  // namespace hgros::viewer
