#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// A display that the command line asks for.
struct WantedDisplay {
  std::string channel;  ///< The channel, or the kind of a display without a channel.
  std::string schema;
  std::vector<std::pair<std::string, std::string>> settings;
};

struct Options {
  std::vector<std::filesystem::path> network;
  std::vector<WantedDisplay> channels;
  std::vector<WantedDisplay> displays;
  std::vector<WantedDisplay> opened_panels;  ///< The channel is the panel's name.
  std::filesystem::path config;              ///< A layout file; empty: none.
  std::string fixed_frame;
  std::string follow;  ///< The frame that the camera follows.
  bool follow_pose = false;
  std::optional<Viewport> offscreen;
  Viewport window{1280, 800};
  std::filesystem::path screenshot;
  std::filesystem::path film;
  std::optional<double> after_s;
  std::optional<std::size_t> frames;
  std::optional<double> fps_limit;
  bool from_above = false;
  bool orthographic = false;
  bool show_all = false;
  bool panels = true;
  std::optional<double> report_s;
};

/// The options of the command line, or an exit code if the program is to end (--help, errors). Prints to standard
/// output and error.
struct ReadOptions {
  std::optional<Options> options;
  int exit_code = 0;
};
[[nodiscard]] ReadOptions ReadCommandLine(int argc, char** argv);

}  // namespace hgros::viewer
