#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <span>
#include <system_error>

#include "viewer/app/layout/layout_file.hpp"

namespace hgros::viewer {
namespace {

/// The shortest text that reads back as the same number.
template <class T>
std::string Shortest(T number) {
  std::array<char, 64> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end};
}

template <class T>
std::string Bracketed(std::span<const T> numbers) {
  std::string text = "[";
  for (const T number : numbers) text += (text.size() > 1 ? ", " : "") + Shortest(number);
  return text + "]";
}

bool IsPlain(const std::string& text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (text.empty() || text.back() == ' ') return false;
  if (!is_letter(text[0]) && !is_digit(text[0]) && text[0] != '/' && text[0] != '_' &&
      !(text[0] == '-' && text.size() > 1 && is_digit(text[1]))) {
    return false;
  }
  if (text == "null" || text == "Null" || text == "NULL") return false;
  return std::ranges::all_of(text, [&](char c) {
    return is_letter(c) || is_digit(c) || c == '_' || c == '/' || c == '.' || c == '-' || c == '+' || c == ' ';
  });
}

/// A YAML scalar, in quotes if it would otherwise be read as something else.
std::string Value(const std::string& text) {
  if (IsPlain(text)) return text;
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7F) {
      quoted += "\\x";
      quoted += kHex[byte >> 4U];
      quoted += kHex[byte & 15U];
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string Line(const std::string& indent, const std::string& name, const std::string& value) {
  return indent + Value(name) + ": " + value + "\n";
}

std::string TruthText(bool truth) { return truth ? "true" : "false"; }

bool IsReadable(const LayoutCamera& camera) {
  const auto in_bounds = [](double number) { return std::abs(number) <= kMostInLayout; };
  return std::ranges::all_of(camera.eye, in_bounds) && std::ranges::all_of(camera.orientation, in_bounds) &&
         in_bounds(camera.distance) && (!camera.anchor || std::ranges::all_of(*camera.anchor, in_bounds));
}

std::string CameraText(const LayoutCamera& camera) {
  std::string text = "\ncamera:\n";
  text += Line("  ", "eye", Bracketed<double>(camera.eye));
  text += Line("  ", "orientation", Bracketed<double>(camera.orientation));
  text += Line("  ", "distance", Shortest(camera.distance));
  text += Line("  ", "orthographic", TruthText(camera.orthographic));
  if (camera.anchor) text += Line("  ", "anchor", Bracketed<double>(*camera.anchor));
  if (camera.relative) text += Line("  ", "relative", "true");
  return text;
}

std::string PlaceLine(const PanelPlace& place) {
  const std::array<float, 4> numbers = {place.x, place.y, place.width, place.height};
  return Line("    ", "place", Bracketed<float>(numbers));
}

std::string DisplayText(const LayoutDisplay& display) {
  std::string text = "  - kind: " + Value(display.kind) + "\n";
  if (!display.channel.empty()) text += Line("    ", "channel", Value(display.channel));
  if (!display.visible) text += Line("    ", "visible", "false");
  if (display.place) text += PlaceLine(*display.place);
  if (display.settings.empty()) return text;
  text += "    settings:\n";
  for (const LayoutSetting& setting : display.settings) text += Line("      ", setting.name, Value(setting.value));
  return text;
}

std::string PanelText(const PanelLayout& panel) {
  std::string text = "  - kind: " + Value(panel.name) + "\n";
  if (panel.place) text += PlaceLine(*panel.place);
  // A setting with several values is a list, at the place of the first value.
  for (auto setting = panel.settings.begin(); setting != panel.settings.end(); ++setting) {
    const auto same = [&](const auto& other) { return other.first == setting->first; };
    if (std::any_of(panel.settings.begin(), setting, same)) continue;
    if (std::ranges::count_if(panel.settings, same) == 1) {
      text += Line("    ", setting->first, Value(setting->second));
      continue;
    }
    text += "    " + Value(setting->first) + ":\n";
    for (auto other = setting; other != panel.settings.end(); ++other) {
      if (same(*other)) text += "      - " + Value(other->second) + "\n";
    }
  }
  return text;
}

}  // namespace

std::string LayoutText(const Layout& layout) {
  std::string text = "# What hgros-viewer shows: hgros-viewer --config THIS_FILE\n";
  if (!layout.fixed_frame.empty()) text += Line("", "fixed_frame", Value(layout.fixed_frame));
  if (!layout.follow.empty()) {
    text += Line("", "follow", Value(layout.follow));
    text += Line("", "follow_direction", TruthText(layout.follow_pose));
  }
  if (layout.fps_limit) text += Line("", "fps_limit", Shortest(*layout.fps_limit));
  text += Line("", "save_on_exit", TruthText(layout.save_on_exit));
  if (layout.show_found) text += Line("", "show_found", "true");
  if (layout.camera && IsReadable(*layout.camera)) text += CameraText(*layout.camera);
  if (layout.displays) {
    text += layout.displays->empty() ? "\ndisplays: []\n" : "\ndisplays:\n";
    for (const LayoutDisplay& display : *layout.displays) text += DisplayText(display);
  }
  if (!layout.panels.empty()) text += "\npanels:\n";
  for (const LayoutPanel& panel : layout.panels) text += PanelText(panel.panel);
  return text;
}

std::string SaveLayout(const Layout& layout, const std::filesystem::path& file) {
  std::filesystem::path unfinished = file;
  unfinished += ".unfinished";
  std::error_code fault;
  {
    errno = 0;
    std::ofstream stream(unfinished, std::ios::binary);
    stream << LayoutText(layout);
    stream.flush();
    if (!stream) {
      const std::string cause = errno != 0 ? std::generic_category().message(errno)
                                           : std::string("check that its folder is there and is yours");
      std::filesystem::remove(unfinished, fault);
      return "The layout cannot be written to " + file.string() + ": " + cause + ".";
    }
  }
  std::filesystem::rename(unfinished, file, fault);
  return fault ? "The layout cannot be written to " + file.string() + ": " + fault.message() + "." : std::string();
}

}  // namespace hgros::viewer
