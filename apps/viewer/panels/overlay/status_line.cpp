#include "viewer/panels/overlay/status_line.hpp"

#include <imgui.h>

#include <cstdio>

namespace hgros::viewer {
namespace {

std::string Thousands(std::size_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, " ");
  return digits;
}

std::string RateOf(double per_second) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f frames/s", per_second);
  return text;
}

}  // namespace

std::string StatusText(const StatusFigures& figures) {
  char rates[96];
  std::snprintf(rates, sizeof rates, "   %.0f MB, %.0f MB of them graphics",
                static_cast<double>(figures.resident_bytes) / 1e6, static_cast<double>(figures.gpu_bytes) / 1e6);
  std::string text = figures.fixed_frame.empty() ? "no frame yet" : "fixed frame " + figures.fixed_frame;
  text += "   " + Thousands(figures.points) + (figures.points == 1 ? " point   " : " points   ");
  text += (figures.frames_per_second > 0 ? RateOf(figures.frames_per_second) : "idle") + rates;
  if (figures.unfinished) text += "   drawing ...";
  if (figures.paused) text += "   paused (Space)";
  if (figures.picking) text += "   a click picks a point (M)";
  return text;
}

void DrawStatusLine(const StatusFigures& figures) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float height = ImGui::GetFrameHeight();
  ImGui::SetNextWindowPos({0, size.y - height});
  ImGui::SetNextWindowSize({size.x, height});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {10, 3});
  if (ImGui::Begin("status", nullptr,
                   ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                       ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoNav)) {
    const std::string text = StatusText(figures);
    const std::string right = figures.notice.empty() ? "F1: mouse and keys" : figures.notice;
    const float place = size.x - ImGui::CalcTextSize(right.c_str()).x - 12;
    const bool both_fit = ImGui::CalcTextSize(text.c_str()).x + 30 < place;
    if (both_fit || figures.notice.empty()) ImGui::TextUnformatted(text.c_str());
    if (both_fit) ImGui::SameLine(place);
    if (both_fit || !figures.notice.empty()) ImGui::TextDisabled("%s", right.c_str());
  }
  ImGui::End();
  ImGui::PopStyleVar(3);
}

}  // namespace hgros::viewer
