#include "viewer/scene/settings/setting.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace hgros::viewer {
namespace {

/// Reads a text that is a number and nothing else.
bool ParseNumber(std::string_view text, float& number) {
  const std::string copy(text);
  char* end = nullptr;
  number = std::strtof(copy.c_str(), &end);
  return end != copy.c_str() && *end == '\0' && std::isfinite(number);
}

std::string Listed(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) list += i + 1 == names.size() ? " and " : ", ";
    list += names[i];
  }
  return list;
}

struct FromText {
  const std::string& name;
  std::string_view text;

  std::string operator()(const Setting::Switch& on) const {
    if (text != "on" && text != "off") return name + " is on or off, not \"" + std::string(text) + "\".";
    *on.value = text == "on";
    return {};
  }
  std::string operator()(const Setting::Number& number) const {
    float value = 0;
    if (!ParseNumber(text, value)) return name + " is a number, not \"" + std::string(text) + "\".";
    *number.value = std::clamp(value, number.lowest, number.highest);
    return {};
  }
  std::string operator()(const Setting::Choice& choice) const {
    const auto found = std::ranges::find(choice.names, text);
    if (found == choice.names.end()) {
      return name + " has no \"" + std::string(text) + "\"; there are " + Listed(choice.names) + ".";
    }
    *choice.value = static_cast<int>(found - choice.names.begin());
    return {};
  }
  std::string operator()(const Setting::Color& color) const {
    unsigned rgb = 0;
    char rest = 0;
    if (text.size() != 7 || std::sscanf(std::string(text).c_str(), "#%6x%c", &rgb, &rest) != 1) {
      return name + " must be a color such as #ff8000, not \"" + std::string(text) + "\".";
    }
    *color.value = {static_cast<float>(rgb >> 16U & 255U) / 255, static_cast<float>(rgb >> 8U & 255U) / 255,
                    static_cast<float>(rgb & 255U) / 255};
    return {};
  }
  std::string operator()(const Setting::Text& words) const {
    *words.value = text;
    return {};
  }
};

struct ToText {
  std::string operator()(const Setting::Switch& on) const { return *on.value ? "on" : "off"; }
  std::string operator()(const Setting::Number& number) const {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", static_cast<double>(*number.value));
    return text;
  }
  std::string operator()(const Setting::Choice& choice) const {
    return choice.names[static_cast<std::size_t>(*choice.value)];
  }
  std::string operator()(const Setting::Color& color) const {
    char text[8];
    const auto byte = [](float value) {
      return static_cast<unsigned>(std::lround(std::clamp(value, 0.0F, 1.0F) * 255));
    };
    std::snprintf(text, sizeof text, "#%02x%02x%02x", byte((*color.value)[0]) & 255U, byte((*color.value)[1]) & 255U,
                  byte((*color.value)[2]) & 255U);
    return text;
  }
  std::string operator()(const Setting::Text& words) const { return *words.value; }
};

}  // namespace

std::string SetFromText(const Setting& setting, std::string_view text) {
  return std::visit(FromText{setting.name, text}, setting.value);
}

std::string TextOf(const Setting& setting) { return std::visit(ToText{}, setting.value); }

}  // namespace hgros::viewer
