#include "viewer/panels/widgets/look.hpp"

#include <imgui.h>

#include <cmath>
#include <filesystem>
#include <system_error>

namespace hgros::viewer {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr float kFontPixels = 14;

ImVec4 Gray(float value, float alpha = 1) { return {value * 0.96F, value * 0.99F, value * 1.04F, alpha}; }

}  // namespace

void SetLook(float scale) {
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();
  ImGui::StyleColorsDark(&style);
  style.WindowRounding = 6;
  style.FrameRounding = 4;
  style.GrabRounding = 4;
  style.ScrollbarRounding = 6;
  style.WindowBorderSize = 0;
  style.WindowPadding = {10, 8};
  style.FramePadding = {6, 3};
  style.ItemSpacing = {8, 5};
  const ImVec4 accent(0.25F, 0.62F, 0.72F, 1);
  style.Colors[ImGuiCol_WindowBg] = Gray(0.15F, 0.93F);
  style.Colors[ImGuiCol_PopupBg] = Gray(0.17F, 0.98F);
  style.Colors[ImGuiCol_TitleBg] = Gray(0.13F);
  style.Colors[ImGuiCol_TitleBgActive] = Gray(0.17F);
  style.Colors[ImGuiCol_FrameBg] = Gray(0.22F);
  style.Colors[ImGuiCol_FrameBgHovered] = Gray(0.27F);
  style.Colors[ImGuiCol_FrameBgActive] = Gray(0.30F);
  style.Colors[ImGuiCol_Header] = Gray(0.22F);
  style.Colors[ImGuiCol_HeaderHovered] = Gray(0.27F);
  style.Colors[ImGuiCol_HeaderActive] = Gray(0.30F);
  style.Colors[ImGuiCol_Button] = Gray(0.25F);
  style.Colors[ImGuiCol_ButtonHovered] = Gray(0.32F);
  style.Colors[ImGuiCol_ButtonActive] = accent;
  style.Colors[ImGuiCol_CheckMark] = accent;
  style.Colors[ImGuiCol_SliderGrab] = accent;
  style.Colors[ImGuiCol_SliderGrabActive] = accent;
  style.Colors[ImGuiCol_Separator] = Gray(0.26F);
  style.Colors[ImGuiCol_Text] = Gray(0.90F);
  style.Colors[ImGuiCol_TextDisabled] = Gray(0.58F);
  style.ScaleAllSizes(scale);

  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  ImFontConfig config;
  config.OversampleH = 1;
  config.PixelSnapH = true;
  std::error_code ignored;
  if (std::filesystem::exists(kFont, ignored)) {
    io.Fonts->AddFontFromFileTTF(kFont, std::round(kFontPixels * scale), &config);
  } else {
    config.SizePixels = std::round(13 * scale);
    io.Fonts->AddFontDefault(&config);
  }
}

}  // namespace hgros::viewer
