#include "viewer/app/options.hpp"

#include <cstdio>
#include <iostream>

#include <CLI/CLI.hpp>

#include "viewer/app/layout.hpp"

namespace hgros::viewer {
namespace {

/// NAME[:SCHEMA][,setting=value...]
std::string ParseDisplay(const std::string& text, WantedDisplay& wanted) {
  std::size_t end = text.find(',');
  const std::string what = text.substr(0, end);
  const std::size_t colon = what.rfind(':');
  wanted.channel = what.substr(0, colon);
  if (colon != std::string::npos) wanted.schema = what.substr(colon + 1);
  if (wanted.channel.empty()) return "\"" + text + "\" names no channel.";
  while (end != std::string::npos) {
    const std::size_t begin = end + 1;
    end = text.find(',', begin);
    const std::string pair = text.substr(begin, end == std::string::npos ? end : end - begin);
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos) return "\"" + pair + "\" is no setting; one is written size=3.";
    wanted.settings.emplace_back(pair.substr(0, equals), pair.substr(equals + 1));
  }
  return {};
}

std::string ParseSize(const std::string& text, Viewport& size) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &rest) != 2 || size.width < 1 ||
      size.height < 1 || size.width > 16384 || size.height > 16384) {
    return "\"" + text + "\" is no size; one is written 1280x800, with sides of 1 to 16384 pixels.";
  }
  return {};
}

/// The first of several faults ends it all.
std::string ParseTexts(const std::vector<std::string>& channels, const std::vector<std::string>& displays,
                       const std::vector<std::string>& panels, const std::string& window, const std::string& offscreen,
                       Options& options) {
  for (const std::string& text : channels) {
    if (std::string fault = ParseDisplay(text, options.channels.emplace_back()); !fault.empty()) return fault;
  }
  for (const std::string& text : displays) {
    if (std::string fault = ParseDisplay(text, options.displays.emplace_back()); !fault.empty()) return fault;
  }
  for (const std::string& text : panels) {
    if (std::string fault = ParseDisplay(text, options.opened_panels.emplace_back()); !fault.empty()) return fault;
  }
  if (!window.empty()) {
    if (std::string fault = ParseSize(window, options.window); !fault.empty()) return fault;
  }
  if (!offscreen.empty()) {
    if (std::string fault = ParseSize(offscreen, options.offscreen.emplace()); !fault.empty()) return fault;
  }
  if (!options.screenshot.empty() && !options.after_s && !options.frames) {
    return "--screenshot needs --after SECONDS or --frames N.";
  }
  if (options.fps_limit && !(*options.fps_limit > 0 && *options.fps_limit <= kMostInLayout)) {
    return "--fps-limit is a number above 0, and 1e12 at most.";
  }
  if (options.report_s && !(*options.report_s > 0)) return "--report is a number above 0.";
  return {};
}

}  // namespace

ReadOptions ReadCommandLine(int argc, char** argv) {
  CLI::App app("Shows what robots publish: clouds, scans, trajectories, maps, images, frames.", "hgros-viewer");
  Options options;
  std::vector<std::string> channels;
  std::vector<std::string> displays;
  std::vector<std::string> panels;
  std::string window;
  std::string offscreen;
  std::vector<std::string> network;
  std::string screenshot;
  std::string config;
  std::string film;
  app.add_option("--channel", channels,
                 "NAME[:SCHEMA][,setting=value...], such as lidar:foxglove.PointCloud,keep=all; repeatable")
      ->take_all();
  app.add_option("--display", displays,
                 "Frames, Ground or \"Robot model\"[,setting=value...]; visible=off hides it; repeatable")
      ->take_all();
  app.add_option("--panel", panels,
                 "Channels, Log, Message, Plot or Graph[,setting=value...], open from the start; repeatable")
      ->take_all();
  app.add_option("--config", config,
                 "a layout file, which need not be there yet: the key L or the panel View writes it");
  app.add_option("--network", network, "configuration of the session, as for every program; repeatable")
      ->take_all()
      ->check(CLI::ExistingFile);
  app.add_option("--fixed-frame", options.fixed_frame, "the frame that everything is shown in; otherwise it is chosen");
  app.add_option("--follow", options.follow, "a frame whose position the camera goes along with");
  app.add_flag("--follow-pose", options.follow_pose, "its direction, too");
  app.add_option("--size", window, "of the window, such as 1280x800");
  app.add_option("--offscreen", offscreen, "WIDTHxHEIGHT: without a window, on a machine without a screen");
  app.add_option("--screenshot", screenshot, "a PNG that is written at the end");
  app.add_option("--record-video", film, "a film of all that is drawn, such as film.mp4; by the program ffmpeg");
  app.add_option("--after", options.after_s, "ends after so many seconds");
  app.add_option("--frames", options.frames, "ends after so many frames");
  app.add_option("--fps-limit", options.fps_limit, "frames a second at most; 30 unless told");
  app.add_flag("--from-above", options.from_above, "looks straight down at the start, x to the right and y up");
  app.add_flag("--orthographic", options.orthographic, "without perspective");
  app.add_flag("--show-all", options.show_all, "the screenshot shows everything there is");
  app.add_flag("!--no-panels", options.panels, "the scene alone");
  app.add_option("--report", options.report_s, "figures on standard error, every so many seconds");
  app.footer(
      "Exit status: 0; 1 if it could not go on, something could not be written, or (with --offscreen) something that\n"
      "was asked for is not in the picture: a channel, a robot, or a frame that never came; 2 if the command line is\n"
      "wrong. What that is stands on standard error.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return {std::nullopt, app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2};
  }
  options.network.assign(network.begin(), network.end());
  options.screenshot = screenshot;
  options.config = config;
  options.film = film;
  const std::string fault = ParseTexts(channels, displays, panels, window, offscreen, options);
  if (!fault.empty()) {
    std::fprintf(stderr, "hgros-viewer: %s `hgros-viewer --help` tells more.\n", fault.c_str());
    return {std::nullopt, 2};
  }
  return {std::move(options), 0};
}

}  // namespace hgros::viewer
