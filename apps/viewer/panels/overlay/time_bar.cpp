#include "viewer/panels/overlay/time_bar.hpp"

#include <imgui.h>

#include <algorithm>
#include <cstdio>

namespace hgros::viewer {

std::string SpanText(const TimeBarFigures& figures) {
  char span[64];
  std::snprintf(span, sizeof span, "spans %.1f s", figures.kept_s);
  return std::string(span) + (figures.frames_end_it ? " (frames)" : "");
}

TimeBarWish DrawTimeBar(const TimeBarFigures& figures) {
  TimeBarWish wish;
  const float unit = ImGui::GetFontSize();
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5F * size.x, size.y - ImGui::GetFrameHeight() - 0.4F * unit}, ImGuiCond_Always, {0.5F, 1});
  ImGui::SetNextWindowSize({std::min(46 * unit, size.x), 0});
  if (ImGui::Begin("time", nullptr,
                   ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                       ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing)) {
    wish.go_on = ImGui::SmallButton("continue");
    ImGui::SameLine();
    wish.step = ImGui::SmallButton("step");
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", "Shows what has arrived until now and stays paused.");
    ImGui::SameLine();
    char lost[64];
    std::snprintf(lost, sizeof lost, "%llu dropped", static_cast<unsigned long long>(figures.dropped));
    const std::string span = SpanText(figures);
    const float room = ImGui::CalcTextSize(lost).x + ImGui::CalcTextSize(span.c_str()).x + 2 * unit;
    auto shown = static_cast<float>(0 - figures.back_s);
    if (figures.kept_s > 0) {
      ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - room);
      wish.moved = ImGui::SliderFloat("##back", &shown, static_cast<float>(-figures.kept_s), 0,
                                      figures.back_s > 0 ? "%.2f s" : "now", ImGuiSliderFlags_AlwaysClamp);
      if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip("%s",
                          "Looks back as far as displays keep data: points kept by time or count,\n"
                          "poses, and frames.");
      }
      wish.back_s = static_cast<double>(-shown);
      ImGui::SameLine();
      ImGui::TextDisabled("%s", span.c_str());
      if (figures.frames_end_it && ImGui::IsItemHovered()) {
        ImGui::SetTooltip("%s", "Older transforms are not kept. Hide the display Frames to look farther back.");
      }
    } else {
      ImGui::TextDisabled("There is nothing to look back at. Set keep=time for points.");
    }
    ImGui::SameLine();
    ImGui::TextDisabled("%s", lost);
  }
  ImGui::End();
  return wish;
}

}  // namespace hgros::viewer
