#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <initializer_list>

#include "hgros/base/error.hpp"
#include "hgros/yaml/document.hpp"
#include "viewer/app/layout/layout_file.hpp"

namespace hgros::viewer {
namespace {

using yaml::Document;
using yaml::Node;

/// Reads a YAML document. Anything unexpected throws a ConfigError with its position.
class Reader {
 public:
  explicit Reader(const Document& document) : document_(document) {}

  Layout Read() {
    Layout layout;
    if (document_.root().kind == Node::Kind::kNull) return layout;
    for (const Node::Entry& entry : Map(document_.root(), "A layout")) {
      const std::string& key = entry.key->text;
      const Node& value = *entry.value;
      if (key == "fixed_frame") {
        layout.fixed_frame = Text(value, key);
      } else if (key == "fps_limit") {
        layout.fps_limit = Number(value, key);
        if (!(*layout.fps_limit > 0)) Fail(value, "fps_limit must be a number above 0.", "Write 30, for example.");
      } else if (key == "save_on_exit") {
        layout.save_on_exit = Truth(value, key);
      } else if (key == "show_found") {
        layout.show_found = Truth(value, key);
      } else if (key == "follow") {
        layout.follow = Text(value, key);
      } else if (key == "follow_direction") {
        layout.follow_pose = Truth(value, key);
      } else if (key == "camera") {
        layout.camera = Camera(value);
      } else if (key == "displays") {
        layout.displays.emplace();
        for (const Node* const display : List(value, key)) layout.displays->push_back(Display(*display));
      } else if (key == "panels") {
        for (const Node* const panel : List(value, key)) layout.panels.push_back(Panel(*panel));
      } else {
        FailKey(*entry.key, {"fixed_frame", "fps_limit", "save_on_exit", "show_found", "follow", "follow_direction",
                             "camera", "displays", "panels"});
      }
    }
    return layout;
  }

 private:
  [[noreturn]] void Fail(const Node& node, const std::string& what, const std::string& mend) const {
    throw ConfigError(what, document_.PositionOf(node), mend);
  }
  [[noreturn]] void FailKey(const Node& key, std::initializer_list<const char*> known) const {
    std::string names;
    for (const char* const name : known) names += (names.empty() ? "" : ", ") + std::string(name);
    Fail(key, "A layout has no \"" + key.text + "\" here.", "There are " + names + ".");
  }

  [[nodiscard]] const std::vector<Node::Entry>& Map(const Node& node, const std::string& what) const {
    if (node.kind != Node::Kind::kMap) {
      Fail(node, what + " must be a map of names and values.", "Write one as \"name: value\" a line.");
    }
    return node.entries;
  }
  [[nodiscard]] std::vector<const Node*> List(const Node& node, const std::string& what) const {
    if (node.kind == Node::Kind::kNull) return {};
    if (node.kind != Node::Kind::kList) Fail(node, what + " is a list.", "Begin each item with \"- \".");
    return node.items;
  }
  [[nodiscard]] const std::string& Text(const Node& node, const std::string& what) const {
    static const std::string none;
    if (node.kind == Node::Kind::kNull) return none;
    if (node.kind != Node::Kind::kText)
      Fail(node, what + " is a text or a number.", "Write one value after the colon.");
    return node.text;
  }
  [[nodiscard]] bool Truth(const Node& node, const std::string& what) const {
    const std::string& text = Text(node, what);
    if (text != "true" && text != "false" && text != "on" && text != "off") {
      Fail(node, what + " is true or false, not \"" + text + "\".", "Write one of the two.");
    }
    return text == "true" || text == "on";
  }
  [[nodiscard]] double Number(const Node& node, const std::string& what) const {
    const std::string& text = Text(node, what);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size() || !(std::abs(number) <= kMostInLayout)) {
      Fail(node, what + " is a number between -1e12 and 1e12, not \"" + text + "\".", "Write one such as 2.5.");
    }
    return number;
  }
  template <std::size_t N>
  [[nodiscard]] std::array<double, N> Numbers(const Node& node, const std::string& what) const {
    std::array<double, N> numbers{};
    if (node.kind != Node::Kind::kList || node.items.size() != N) {
      Fail(node, what + " is a list of " + std::to_string(N) + " numbers.", "Write them in brackets, with commas.");
    }
    for (std::size_t i = 0; i < N; ++i) numbers[i] = Number(*node.items[i], what);
    return numbers;
  }

  [[nodiscard]] LayoutCamera Camera(const Node& node) const {
    LayoutCamera camera;
    for (const Node::Entry& entry : Map(node, "camera")) {
      const std::string& key = entry.key->text;
      if (key == "eye") {
        camera.eye = Numbers<3>(*entry.value, key);
      } else if (key == "orientation") {
        camera.orientation = Numbers<4>(*entry.value, key);
        double square = 0;
        for (const double part : camera.orientation) square += part * part;
        if (square < 1e-6 || square > 1e6) {
          Fail(*entry.value, "orientation is a quaternion x, y, z, w.", "[0, 0, 0, 1] looks straight down.");
        }
      } else if (key == "distance") {
        camera.distance = Number(*entry.value, key);
        if (!(camera.distance > 0)) Fail(*entry.value, "distance must be above 0.", "Write 20, for example.");
      } else if (key == "orthographic") {
        camera.orthographic = Truth(*entry.value, key);
      } else if (key == "anchor") {
        camera.anchor = Numbers<3>(*entry.value, key);
      } else if (key == "relative") {
        camera.relative = Truth(*entry.value, key);
      } else {
        FailKey(*entry.key, {"eye", "orientation", "distance", "orthographic", "anchor", "relative"});
      }
    }
    return camera;
  }

  [[nodiscard]] PanelPlace Place(const Node& node) const {
    const auto place = Numbers<4>(node, "place");
    if (place[2] < 1 || place[3] < 1) {
      Fail(node, "The place has no size.", "Write [left, top, width, height] in pixels.");
    }
    return {static_cast<float>(place[0]), static_cast<float>(place[1]), static_cast<float>(place[2]),
            static_cast<float>(place[3])};
  }

  [[nodiscard]] LayoutDisplay Display(const Node& node) const {
    LayoutDisplay display;
    display.where = document_.PositionOf(node);
    for (const Node::Entry& entry : Map(node, "A display")) {
      const std::string& key = entry.key->text;
      if (key == "kind") {
        display.kind = Text(*entry.value, key);
      } else if (key == "channel") {
        display.channel = Text(*entry.value, key);
      } else if (key == "visible") {
        display.visible = Truth(*entry.value, key);
      } else if (key == "place") {
        display.place = Place(*entry.value);
      } else if (key == "settings") {
        if (entry.value->kind == Node::Kind::kNull) continue;
        for (const Node::Entry& setting : Map(*entry.value, "settings")) {
          display.settings.push_back(
              {setting.key->text, Text(*setting.value, setting.key->text), document_.PositionOf(*setting.value)});
        }
      } else {
        FailKey(*entry.key, {"kind", "channel", "visible", "place", "settings"});
      }
    }
    if (display.kind.empty()) {
      Fail(node, "The display has no \"kind\".", "Write \"kind: Point cloud\", for example.");
    }
    return display;
  }

  [[nodiscard]] LayoutPanel Panel(const Node& node) const {
    LayoutPanel panel;
    panel.where = document_.PositionOf(node);
    if (node.kind == Node::Kind::kText) {
      panel.panel.name = node.text;
      return panel;
    }
    for (const Node::Entry& entry : Map(node, "A panel")) {
      const std::string& key = entry.key->text;
      if (key == "kind") {
        panel.panel.name = Text(*entry.value, key);
      } else if (key == "place") {
        panel.panel.place = Place(*entry.value);
      } else if (entry.value->kind == Node::Kind::kList) {
        for (const Node* const item : entry.value->items) panel.panel.settings.emplace_back(key, Text(*item, key));
      } else {
        panel.panel.settings.emplace_back(key, Text(*entry.value, key));
      }
    }
    if (panel.panel.name.empty()) {
      Fail(node, "The panel has no \"kind\".", "Write \"kind: Plot\", for example.");
    }
    return panel;
  }

  const Document& document_;
};

}  // namespace

Layout ParseLayout(std::string_view text, const std::string& name) {
  const Document document = Document::Parse(text, name);
  return Reader(document).Read();
}

Layout LoadLayout(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_fifo(file, error) || std::filesystem::is_character_file(file, error)) {
    throw Error("The layout file \"" + file.string() + "\" is a pipe or a device.", {}, "Name a regular file.");
  }
  const Document document = Document::Load(file);
  return Reader(document).Read();
}

}  // namespace hgros::viewer
