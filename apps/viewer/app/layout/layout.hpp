#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "hgros/base/error.hpp"
#include "viewer/panels/dock/panel_dock.hpp"

namespace hgros::viewer {

/// The largest absolute value of a number in a layout.
constexpr double kMostInLayout = 1e12;

/// One setting of a display, and where it was read.
struct LayoutSetting {
  std::string name;
  std::string value;
  FilePosition where{};
  bool operator==(const LayoutSetting& other) const { return name == other.name && value == other.value; }
};

struct LayoutDisplay {
  std::string kind;
  std::string channel;  ///< Empty: the display needs no channel.
  bool visible = true;
  std::vector<LayoutSetting> settings;
  FilePosition where{};
  std::optional<PanelPlace> place{};  ///< Of its image's window, if a user has moved that.
  bool operator==(const LayoutDisplay& other) const {
    return kind == other.kind && channel == other.channel && visible == other.visible && settings == other.settings &&
           place == other.place;
  }
};

struct LayoutPanel {
  PanelLayout panel;
  FilePosition where{};
  bool operator==(const LayoutPanel& other) const { return panel == other.panel; }
};

struct LayoutCamera {
  std::array<double, 3> eye{};
  std::array<double, 4> orientation{0, 0, 0, 1};  ///< x, y, z, w.
  double distance = 20;
  bool orthographic = false;
  std::optional<std::array<double, 3>> anchor;
  bool relative = false;  ///< Eye, orientation and anchor are relative to the followed frame.
  bool operator==(const LayoutCamera&) const = default;
};

/// Everything that a user has set up, so that the viewer looks the same the next time.
struct Layout {
  std::string fixed_frame;  ///< Empty: the viewer chooses it.
  std::string follow;       ///< The frame that the camera follows; empty: none.
  bool follow_pose = false;
  std::optional<double> fps_limit;
  bool save_on_exit = false;
  std::optional<LayoutCamera> camera;
  std::optional<std::vector<LayoutDisplay>> displays;  ///< In their order. None: the displays of found channels.
  bool show_found = false;                             ///< Also shows channels that are found.
  std::vector<LayoutPanel> panels;
  bool operator==(const Layout&) const = default;
};

}  // namespace hgros::viewer
