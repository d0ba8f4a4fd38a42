#include "viewer/app/viewer.hpp"

#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <iterator>
#include <utility>

#include "hgros/base/error.hpp"
#include "viewer/app/process_figures.hpp"
#include "viewer/panels/help_overlay.hpp"
#include "viewer/panels/label_layer.hpp"
#include "viewer/panels/look.hpp"
#include "viewer/panels/pick_layer.hpp"
#include "viewer/panels/status_line.hpp"
#include "viewer/panels/time_bar.hpp"

namespace hgros::viewer {
namespace {

constexpr double kRateS = 1;  ///< Frames are counted over so long.

double NowS() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// "hgros-viewer-20261122-070603.png"
std::string NameOfTheMoment() {
  char name[64];
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  std::strftime(name, sizeof name, "hgros-viewer-%Y%m%d-%H%M%S.png", &parts);
  return name;
}

Config SessionConfig(const Options& options) {
  return options.network.empty() ? Config() : Config::Load(options.network);
}

}  // namespace

Viewer::Viewer(const Options& options, const std::optional<Layout>& layout, Surface& surface)
    : options_(options),
      surface_(surface),
      session_(SessionConfig(options), {.name = "hgros-viewer"}),
      transforms_(session_, {.on_received =
                                 [this] {
                                   if (!transforms_changed_.exchange(true)) WakeFromData();
                                 }}),
      frame_(transforms_.tree()),
      navigation_(camera_),
      dock_(session_, [this] { surface_.Wake(); }),
      show_panels_(options.panels),
      begin_s_(NowS()) {
  shows_what_it_finds_ = options.channels.empty();
  layout_file_.path = options.config.empty() ? "hgros-viewer.yaml" : options.config.string();
  if (!options.film.empty()) film_.emplace(options.film);
  if (options.report_s) next_report_s_ = begin_s_ + *options.report_s;
  subscriptions_.push_back(session_.FromGraph<ChannelsChanged>(kChannelEventsChannel, Invoke::kSerial,
                                                               [this](const ChannelsChanged&) {
                                                                 channels_changed_ = true;
                                                                 WakeFromData();
                                                               },
                                                               {.queue = Queue::Latest()}));
  SetLook(look_scale_ = surface.scale());
  if (layout) Restore(*layout);
  if (!layout || !layout->displays) {
    Add(*DisplayTypeNamed("Ground"), "", {});
    Add(*DisplayTypeNamed("Frames"), "", {});
  }
  AddWanted();
  AddPanels();
  if (!options.fixed_frame.empty()) frame_.Ask(options.fixed_frame);
  if (options.fps_limit) fps_limit_ = *options.fps_limit;
  if (options.from_above) camera_.LookFromAbove();
  if (options.orthographic) camera_.SetOrthographic(true);
  if (!options.follow.empty()) view_panel_.Follow(options.follow, options.follow_pose);
}

Viewer::~Viewer() {
  subscriptions_.clear();
  scene_.entries().clear();
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
    if (surface_.TakeDisturbed()) frames_wanted_ = kFramesAfterInput;
    const double woken_s = NowS();
    if (woken_s < NextTurnS()) continue;
    Turn(woken_s);
    if ((lost_ = surface_.lost())) break;
    if (woken_s >= next_report_s_) Report(woken_s);
    if (AtEnd(woken_s)) break;
  }
  if (film_) FinishFilm();
  if (layout_file_.save_on_exit && !lost_) SaveLayoutNow();
  if (!lost_) SayWhatIsUnmet();
  return exit_code_;
}

double Viewer::NextTurnS() const {
  const bool draws_on = frames_wanted_ > 0 || scene_.unfinished() || whole_picture_wanted_;
  const bool something = woken_ || (draws_on && !surface_.hidden());
  const double soonest_s = last_turn_s_ + 1 / fps_limit_;
  double next_s = something ? soonest_s : std::max(soonest_s, paused_ ? kNever : scene_.next_change_s());
  if (show_panels_ && !surface_.hidden()) next_s = std::min(next_s, std::max(soonest_s, dock_.next_change_s()));
  if (show_panels_ && !surface_.hidden()) next_s = std::min(next_s, std::max(soonest_s, idle_s_));
  if (options_.after_s) next_s = std::min(next_s, std::max(begin_s_ + *options_.after_s, soonest_s));
  if (show_panels_ && !surface_.hidden()) next_s = std::min(next_s, std::max(soonest_s, next_count_s_));
  return std::min(next_s, next_report_s_);
}

void Viewer::Turn(double now_s) {
  last_turn_s_ = now_s;
  woken_ = false;
  const Camera before = camera_;
  TakeChannels();
  TakeInput();
  TakeArrived(now_s);
  CountUnreadable(now_s);
  if (show_panels_ && !surface_.hidden() && dock_.Update({now_s, known_})) {
    frames_wanted_ = std::max(frames_wanted_, 1);
  }
  if (show_panels_ && now_s >= idle_s_) frames_wanted_ = std::max(frames_wanted_, 1);
  const bool moved = !camera_.SameViewAs(before);
  const bool wanted = moved || frames_wanted_ > 0 || scene_.unfinished() || scene_.pending();
  if (!wanted || surface_.hidden()) return;
  if (frames_wanted_ > 0) --frames_wanted_;
  DrawFrame(now_s);
}

void Viewer::TakeInput() {
  const Viewport size = surface_.size();
  for (const InputEvent& event : surface_.TakeInput()) {
    switch (event.kind) {
      case InputEvent::Kind::kPress: navigation_.OnPress(event.button, event.x, event.y); break;
      case InputEvent::Kind::kRelease:
        if (const auto pixel = navigation_.OnRelease(event.button, event.x, event.y)) {
          Pick(*pixel, picking_ || event.shift);
        }
        break;
      case InputEvent::Kind::kPointer: navigation_.OnPointer(event.x, event.y, size); break;
      case InputEvent::Kind::kWheel: navigation_.OnWheel(event.steps, size); break;
      case InputEvent::Kind::kKey: OnKey(event.key); break;
    }
  }
}

void Viewer::OnKey(int key) {
  const auto table = KeyTable();
  const auto row = std::ranges::find(table, key, &KeyRow::key);
  if (row == table.end()) return;
  switch (row->viewer) {
    case ViewerKey::kNone: navigation_.OnKey(row->camera); break;
    case ViewerKey::kHelp: help_ = !help_; break;
    case ViewerKey::kPause: SetPaused(!paused_); break;
    case ViewerKey::kStep: Step(); break;
    case ViewerKey::kPick: picking_ = !picking_; break;
    case ViewerKey::kForget:
      picking_ = false;
      picks_.Clear();
      break;
    case ViewerKey::kOnePanel:
      dock_.Toggle(PanelTypes()[static_cast<std::size_t>(key - '1')]);
      frames_wanted_ = kFramesAfterInput;
      break;
    case ViewerKey::kSaveLayout: SaveLayoutNow(); break;
    case ViewerKey::kPanels: show_panels_ = !show_panels_; break;
    case ViewerKey::kFocus: ShowEverything(); break;
    case ViewerKey::kScreenshot:
      screenshot_ = NameOfTheMoment();
      frames_wanted_ = kFramesAfterInput;
      break;
  }
}

void Viewer::ShowEverything() {
  const Eigen::AlignedBox3d bounds = scene_.Bounds();
  if (bounds.isEmpty()) return;
  camera_.Focus(bounds, surface_.size());
}

void Viewer::TakeArrived(double now_s) {
  if (paused_ && !std::exchange(steps_, false)) {
    scene_.ApplySettings({frame_, now_s, false, false});
    return;
  }
  newest_s_ = now_s;
  const bool transforms_changed = transforms_changed_.exchange(false);
  if (transforms_changed) frame_changed_ |= frame_.Refresh();
  // A message may name the fixed frame: whoever is not found yet is looked for again.
  const bool sought = !followed_ || followed_name_ != view_panel_.follow();
  if (transforms_changed || frame_changed_ || sought) FollowFrame();
  scene_.Update({frame_, now_s, frame_changed_, transforms_changed});
  frame_changed_ = false;
  if (paused_) KeepTransforms();
}

void Viewer::FollowFrame() {
  const bool other = std::exchange(followed_name_, view_panel_.follow()) != view_panel_.follow();
  if (other) {
    followed_.reset();
    seen_from_followed_ = false;
  }
  RigidTransform now;
  std::string why;
  if (followed_name_.empty() || frame_.Find(followed_name_, now, why) != FixedFrame::Answer::kFound) return;
  if (followed_) {
    camera_.Follow(*followed_, now, view_panel_.with_rotation());
  } else if (std::exchange(seen_from_followed_, false)) {
    camera_.Follow(RigidTransform(), now, view_panel_.with_rotation());
  } else {
    camera_.Center(now.translation);  // It may be far away from what was looked at.
  }
  followed_ = now;
}

void Viewer::TakeScale() {
  if (surface_.scale() == look_scale_) return;
  look_scale_ = surface_.scale();
  SetLook(look_scale_);
  panels_renderer_.ForgetFont();
  scene_.Redraw();
}

void Viewer::DrawFrame(double now_s) {
  const Viewport size = surface_.size();
  TakeScale();
  std::erase_if(frame_times_s_, [&](double time_s) { return time_s <= now_s - kRateS; });
  idle_s_ = frame_times_s_.empty() ? kNever : now_s + kRateS;
  scene_.Draw(camera_.Matrices(size), surface_.scale());
  scene_.picture().ShowOn(surface_.framebuffer());
  DrawPanels();
  if (!screenshot_.empty()) WriteScreenshot(std::exchange(screenshot_, {}));
  if (film_ && film_->recording()) RecordFrame();
  surface_.Present();
  ++frames_;
  frame_times_s_.push_back(now_s);
}

void Viewer::DrawPanels() {
  surface_.BeginPanels();
  panels_renderer_.Prepare();
  ImGui::NewFrame();
  const float pixels_per_unit = ImGui::GetIO().DisplayFramebufferScale.x;
  DrawLabels(scene_.Labels(), camera_, surface_.size(), pixels_per_unit);
  DrawPicks(picks_, camera_, surface_.size(), pixels_per_unit);
  std::optional<std::size_t> remove;
  if (show_panels_) {
    if (view_panel_.Draw(camera_, frame_, layout_file_)) SaveLayoutNow();
    image_panel_.Draw(scene_);
    const DisplayPanel::Wish wish = display_panel_.Draw(scene_, frame_, channels_, dock_);
    if (wish.add != nullptr) AddByHand(*wish.add, wish.channel);
    remove = wish.remove;
    if (wish.set_fixed_frame) {
      frame_.Ask(wish.fixed_frame);
      if (wish.fixed_frame.empty()) frame_.Refresh();
      frame_changed_ = true;
      frames_wanted_ = kFramesAfterInput;
    }
    dock_.Draw();
    if (paused_) {
      const TimeBarWish time =
          DrawTimeBar({back_s_, KeptS(), scene_.truthful_since_s() > scene_.oldest_s(), scene_.dropped()});
      if (time.moved) LookBack(time.back_s);
      if (time.step) Step();
      if (time.go_on) SetPaused(false);
    }
    DrawStatusLine({static_cast<double>(frame_times_s_.size()), scene_.points(), scene_.gpu_bytes(), ResidentBytes(),
                    frame_.name(), notice_, paused_, picking_, scene_.unfinished()});
  }
  DrawHelp(help_);
  ImGui::Render();
  panels_renderer_.Draw();
  if (remove) scene_.Remove(*remove);  // What it drew with was needed until now.
}

bool Viewer::AtEnd(double now_s) {
  const bool end = (options_.after_s && now_s >= begin_s_ + *options_.after_s) ||
                   (options_.frames && frames_ >= *options_.frames) || whole_picture_wanted_;
  if (!end) return false;
  if (options_.screenshot.empty()) return true;
  if (!whole_picture_wanted_ && options_.show_all) {
    ShowEverything();
    frames_wanted_ = kFramesAfterInput;
  }
  whole_picture_wanted_ = true;
  if (frames_wanted_ > 0 || scene_.unfinished() || scene_.pending()) return false;
  screenshot_ = options_.screenshot;
  DrawFrame(now_s);
  return true;
}

void Viewer::Report(double now_s) {
  next_report_s_ = now_s + *options_.report_s;
  std::fprintf(stderr, "seconds=%.1f frames=%zu points=%zu gpu_mb=%.1f rss_mb=%.1f cpu_s=%.2f\n", now_s - begin_s_,
               frames_, scene_.points(), static_cast<double>(scene_.gpu_bytes()) / 1e6,
               static_cast<double>(ResidentBytes()) / 1e6, ProcessorSeconds());
}

}  // namespace hgros::viewer
