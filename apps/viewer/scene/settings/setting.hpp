#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace hgros::viewer {

/// A setting of a display: its name and a pointer to its value. Panels, command line and layout files use only this.
struct Setting {
  struct Switch {
    bool* value;
  };
  struct Number {
    float* value;
    float lowest;
    float highest;
    std::string unit;
  };
  struct Choice {
    int* value;  ///< An index into `names`.
    std::vector<std::string> names;
  };
  struct Color {
    std::array<float, 3>* value;
  };
  struct Text {
    std::string* value;
  };
  using Value = std::variant<Switch, Number, Choice, Color, Text>;

  std::string name;
  std::string meaning;  ///< A sentence that explains the setting.
  Value value;
  std::function<bool()> shown = {};  ///< Whether it has an effect now. Empty: always.
  /// Another setting that must have one of these values, or this setting has no effect. The first value is set if
  /// needed.
  struct Need {
    std::string name;
    std::vector<std::string> values;
  };
  std::vector<Need> needs = {};
  bool decided = true;  ///< False: data may still change it, so a layout does not have it.
};

/// Sets the value from a text. Returns what is wrong with the text, or nothing.
[[nodiscard]] std::string SetFromText(const Setting& setting, std::string_view text);
/// The value as a text that SetFromText accepts.
[[nodiscard]] std::string TextOf(const Setting& setting);

}  // namespace hgros::viewer
