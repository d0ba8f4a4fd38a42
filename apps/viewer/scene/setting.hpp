#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace hgros::viewer {

/// What a person may set of a display: a name, and where the value lies. Panels, command line and layout files read
/// and write it through this alone.
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
  std::string meaning;  ///< A sentence for whoever wonders.
  Value value;
  std::function<bool()> shown = {};  ///< Whether it counts now; empty: always.
  /// Another setting that must have one of these values for this one to count; the first is the one to be set.
  struct Need {
    std::string name;
    std::vector<std::string> values;
  };
  std::vector<Need> needs = {};
};

/// Sets the value that a text says. Returns what is wrong with the text, or nothing.
[[nodiscard]] std::string SetFromText(const Setting& setting, std::string_view text);
/// The text that gives the value again.
[[nodiscard]] std::string TextOf(const Setting& setting);

}  // namespace hgros::viewer
