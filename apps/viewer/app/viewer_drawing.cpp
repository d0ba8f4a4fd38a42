#include <imgui.h>

#include "viewer/app/displays/awaited.hpp"
#include "viewer/app/process_figures.hpp"
#include "viewer/app/viewer.hpp"
#include "viewer/panels/dock/free_room.hpp"
#include "viewer/panels/dock/panel_room.hpp"
#include "viewer/panels/overlay/awaited_layer.hpp"
#include "viewer/panels/overlay/color_legends.hpp"
#include "viewer/panels/overlay/help_overlay.hpp"
#include "viewer/panels/overlay/label_layer.hpp"
#include "viewer/panels/overlay/pick_layer.hpp"
#include "viewer/panels/overlay/status_line.hpp"
#include "viewer/panels/overlay/time_bar.hpp"
#include "viewer/panels/widgets/look.hpp"

namespace hgros::viewer {

void Viewer::DrawFrame(double now_s) {
  const Viewport size = surface_.size();
  UpdateScale();
  pace_.BeginFrame(now_s);
  scene_.Draw(camera_.Matrices(size), surface_.scale());
  scene_.picture().ShowOn(surface_.framebuffer());
  DrawOverlaysAndPanels();
  pictures_.Write();
  surface_.Present();
  pace_.EndFrame(now_s);
}

PixelArea Viewer::WholeArea() const {
  const Viewport size = surface_.size();
  return {0, 0, static_cast<double>(size.width), static_cast<double>(size.height)};
}

PixelArea Viewer::FreeArea() const {
  if (!show_panels_ || pace_.frames() == 0) return WholeArea();
  const PanelPlace free = FreeRoom();
  const auto to_pixels = static_cast<double>(ImGui::GetIO().DisplayFramebufferScale.x);
  return {free.x * to_pixels, free.y * to_pixels, free.width * to_pixels, free.height * to_pixels};
}

void Viewer::UpdateScale() {
  if (surface_.scale() == scale_) return;
  scale_ = surface_.scale();
  LoadGlyphs(glyphs_);
  scene_.Redraw();
}

void Viewer::LoadGlyphs(Glyphs glyphs) {
  glyphs_ = glyphs;
  SetLook(scale_, glyphs_);
  panels_renderer_.ForgetFont();
}

void Viewer::DrawOverlaysAndPanels() {
  surface_.BeginPanels();
  while (!panels_renderer_.Prepare() && glyphs_ != Glyphs::kLatin) {
    most_glyphs_ = glyphs_ == Glyphs::kAll ? Glyphs::kFont : Glyphs::kLatin;
    LoadGlyphs(most_glyphs_);
  }
  ImGui::NewFrame();
  const float pixels_per_unit = ImGui::GetIO().DisplayFramebufferScale.x;
  DrawLabels(scene_.Labels(), camera_, surface_.size(), pixels_per_unit);
  DrawPicks(picker_.picks(), camera_, surface_.size(), pixels_per_unit);
  if (show_panels_) {
    DrawColorLegends(scene_);
    const std::string awaited = AwaitedText(scene_, dock_, channels_, displays_, frame_);
    if (!awaited.empty()) DrawAwaited(awaited, reach_, PanelRoom());
  }
  const std::optional<std::size_t> remove = show_panels_ ? DrawPanels() : std::nullopt;
  DrawHelp(show_help_);
  ImGui::Render();
  panels_renderer_.Draw();
  if (glyphs_ < most_glyphs_ && NeedsMoreGlyphs()) {
    LoadGlyphs(glyphs_ == Glyphs::kLatin ? Glyphs::kFont : Glyphs::kAll);
    pace_.WantAfterInput();
  }
  if (remove) scene_.Remove(*remove);  // Its textures were needed until now.
}

std::optional<std::size_t> Viewer::DrawPanels() {
  if (view_panel_.Draw(camera_, frame_, layout_file_)) WriteLayout();
  const PanelPlace room = image_panel_.Draw(scene_, PanelRoom(), dock_.NeedsRoom() ? PanelDock::NarrowestWidth() : 0);
  const DisplayPanel::Wish wish = display_panel_.Draw(scene_, frame_, channels_.published(), dock_);
  if (wish.add != nullptr) {
    display_panel_.Refuse(displays_.AddByHand(*wish.add, wish.channel));
    pace_.WantOne();
  }
  if (wish.set_fixed_frame) {
    frame_.Ask(wish.fixed_frame);
    if (wish.fixed_frame.empty()) frame_.Refresh();
    frame_changed_ = true;
    pace_.WantAfterInput();
  }
  dock_.Draw(room);
  if (playback_.paused()) DrawPausedTimeBar();
  DrawStatusLine({static_cast<double>(pace_.frames_per_second()), scene_.points(), scene_.gpu_bytes(), ResidentBytes(),
                  frame_.name(), notices_.shown(), playback_.paused(), picker_.active(), scene_.unfinished()});
  return wish.remove;
}

void Viewer::DrawPausedTimeBar() {
  const bool limited = scene_.truthful_since_s() > scene_.oldest_s();
  const TimeBarWish wish = DrawTimeBar({playback_.back_s(), playback_.longest_back_s(), limited, scene_.dropped()});
  if (wish.moved) playback_.LookBack(wish.back_s);
  if (wish.step) playback_.Step();
  if (wish.go_on) SetPaused(false);
}

}  // namespace hgros::viewer
