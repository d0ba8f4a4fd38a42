#include "viewer/panels/widgets/look.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <system_error>

namespace hgros::viewer {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr float kFontPixels = 14;
// Pairs of the first and the last character. U+FFFD stands for what is missing.
constexpr ImWchar kLatin[] = {0x20, 0xFF, 0xFFFD, 0xFFFD, 0};
constexpr ImWchar kWhole[] = {0x20, 0xFFFF, 0};
constexpr ImWchar kEastAsian[] = {0x2E80, 0x9FFF, 0xAC00, 0xD7A3, 0xF900, 0xFAFF, 0xFF00, 0xFFEF, 0};
constexpr std::array<const char*, 7> kEastAsianFonts = {"/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
                                                        "/usr/share/fonts/truetype/wqy/wqy-zenhei.ttc",
                                                        "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
                                                        "/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf",
                                                        "/usr/share/fonts/truetype/nanum/NanumGothic.ttf",
                                                        "/usr/share/fonts/opentype/ipafont-gothic/ipag.ttf",
                                                        "/usr/share/fonts/truetype/arphic/uming.ttc"};

bool Exists(const char* file) {
  std::error_code ignored;
  return std::filesystem::exists(file, ignored);
}

void LoadFonts(float scale, Glyphs glyphs) {
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  fonts.Clear();
  ImFontConfig config;
  config.OversampleH = 1;
  config.PixelSnapH = true;
  const float pixels = std::round(kFontPixels * scale);
  if (Exists(kFont)) {
    fonts.AddFontFromFileTTF(kFont, pixels, &config, glyphs == Glyphs::kLatin ? kLatin : kWhole);
  } else {
    config.SizePixels = std::round(13 * scale);
    fonts.AddFontDefault(&config);
  }
  const auto east_asian = std::ranges::find_if(kEastAsianFonts, Exists);
  if (glyphs != Glyphs::kAll || east_asian == kEastAsianFonts.end()) return;
  config.MergeMode = true;
  fonts.AddFontFromFileTTF(*east_asian, pixels, &config, kEastAsian);
}

ImVec4 Gray(float value, float alpha = 1) { return {value * 0.96F, value * 0.99F, value * 1.04F, alpha}; }

}  // namespace

void SetLook(float scale, Glyphs glyphs) {
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

  LoadFonts(scale, glyphs);
}

bool NeedsMoreGlyphs() {
  const ImDrawData* const data = ImGui::GetDrawData();
  const ImVector<ImFont*>& fonts = ImGui::GetIO().Fonts->Fonts;
  if (data == nullptr || fonts.empty() || fonts[0]->FallbackGlyph == nullptr) return false;
  const ImFontGlyph& sign = *fonts[0]->FallbackGlyph;
  const auto is_sign = [&](const ImDrawVert& corner) { return corner.uv.x == sign.U0 && corner.uv.y == sign.V0; };
  return std::any_of(data->CmdLists, data->CmdLists + data->CmdListsCount, [&](const ImDrawList* list) {
    return std::any_of(list->VtxBuffer.begin(), list->VtxBuffer.end(), is_sign);
  });
}

}  // namespace hgros::viewer
