#include "viewer/app/options.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <initializer_list>
#include <iostream>

#include <CLI/CLI.hpp>

#include "viewer/app/layout/layout.hpp"

namespace hgros::viewer {
namespace {

/// NAME[:SCHEMA][,setting=value...]
std::string ParseDisplay(const std::string& text, WantedDisplay& wanted) {
  std::size_t end = text.find(',');
  const std::string what = text.substr(0, end);
  const std::size_t colon = what.rfind(':');
  wanted.channel = what.substr(0, colon);
  if (colon != std::string::npos) wanted.schema = what.substr(colon + 1);
  if (wanted.channel.empty()) return "\"" + text + "\" has no channel name.";
  while (end != std::string::npos) {
    const std::size_t begin = end + 1;
    end = text.find(',', begin);
    const std::string pair = text.substr(begin, end == std::string::npos ? end : end - begin);
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos) return "\"" + pair + "\" is not a setting. Write it as size=3.";
    wanted.settings.emplace_back(pair.substr(0, equals), pair.substr(equals + 1));
  }
  return {};
}

std::string ParseSize(const std::string& text, Viewport& size) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%c", &size.width, &size.height, &rest) != 2 || size.width < 1 ||
      size.height < 1 || size.width > 16384 || size.height > 16384) {
    return "\"" + text + "\" is not a size. Write it as 1280x800, with sides of 1 to 16384 pixels.";
  }
  return {};
}

/// Stops at the first fault.
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
  return {};
}

/// Whether the name ends in one of the endings, in any case.
bool EndsIn(const std::filesystem::path& file, std::initializer_list<const char*> endings) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char letter) { return std::tolower(letter); });
  return std::ranges::find(endings, ending) != endings.end();
}

std::string CheckRanges(const Options& options) {
  constexpr double kMostSeconds = 1e9;
  if (options.fps_limit && !(*options.fps_limit > 0 && *options.fps_limit <= kMostInLayout)) {
    return "--fps-limit must be a number above 0 and at most 1e12.";
  }
  if (options.report_s && !(*options.report_s > 0 && *options.report_s <= kMostSeconds)) {
    return "--report must be a number above 0 and at most 1e9.";
  }
  if (options.after_s && !(*options.after_s >= 0 && *options.after_s <= kMostSeconds)) {
    return "--after must be a number of seconds from 0 to 1e9.";
  }
  return {};
}

std::string CheckFiles(const Options& options) {
  if (!options.screenshot.empty() && !options.after_s && !options.frames) {
    return "--screenshot needs --after SECONDS or --frames N.";
  }
  if (!options.screenshot.empty() && !EndsIn(options.screenshot, {".png"})) {
    return "--screenshot writes a PNG: \"" + options.screenshot.string() + "\" must end in .png.";
  }
  if (!options.film.empty() && !EndsIn(options.film, {".mp4", ".mkv", ".webm"})) {
    return "--record-video writes .mp4, .mkv or .webm: \"" + options.film.string() + "\" must end in one of them.";
  }
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
  std::optional<std::int64_t> frames;  // CLI11 would read -1 as a large unsigned number.
  app.add_option("--channel", channels,
                 "NAME[:SCHEMA][,setting=value...], such as lidar:foxglove.PointCloud,keep=all; repeatable")
      ->take_all();
  app.add_option("--display", displays,
                 "Frames, Ground or \"Robot model\"[,setting=value...]; visible=off hides it; repeatable")
      ->take_all();
  app.add_option("--panel", panels,
                 "Channels, Log, Message, Plot or Graph[,setting=value...], open from the start; repeatable")
      ->take_all();
  app.add_option("--config", config, "a layout file; if it does not exist, the key L or the panel View can write it");
  app.add_option("--network", network, "a configuration file of the session, as for every program; repeatable")
      ->take_all()
      ->check(CLI::ExistingFile);
  app.add_option("--fixed-frame", options.fixed_frame,
                 "the frame that everything is shown in; default: chosen automatically");
  app.add_option("--follow", options.follow, "a frame whose position the camera follows");
  app.add_flag("--follow-pose", options.follow_pose, "follows the frame's orientation, too");
  app.add_option("--size", window, "size of the window, such as 1280x800");
  app.add_option("--offscreen", offscreen, "WIDTHxHEIGHT: draws into memory, without a window or screen");
  app.add_option("--screenshot", screenshot, "writes a PNG at the end");
  app.add_option("--record-video", film,
                 "writes a film of all pictures, such as film.mp4 (or .mkv, .webm); needs the program ffmpeg");
  app.add_option("--after", options.after_s, "ends after this many seconds");
  app.add_option("--frames", frames, "ends after this many frames");
  app.add_option("--fps-limit", options.fps_limit, "limit of frames per second; default 30");
  app.add_flag("--from-above", options.from_above, "starts with a view straight down, x to the right and y up");
  app.add_flag("--orthographic", options.orthographic, "draws without perspective");
  app.add_flag("--show-all", options.show_all, "zooms so that the screenshot shows everything");
  app.add_flag("!--no-panels", options.panels, "shows only the scene");
  app.add_option("--report", options.report_s, "prints statistics to standard error, with this period in seconds");
  app.footer(
      "Exit status: 0; 1 after an error, if a file could not be written, or (with --offscreen) if something that was\n"
      "requested is not in the picture (a channel, a robot, or a frame); 2 if the command line is wrong. Standard\n"
      "error has the reason.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return {std::nullopt, app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2};
  }
  options.network.assign(network.begin(), network.end());
  options.screenshot = screenshot;
  options.config = config;
  options.film = film;
  if (frames) options.frames = static_cast<std::size_t>(*frames);
  std::string fault = ParseTexts(channels, displays, panels, window, offscreen, options);
  if (fault.empty()) fault = CheckRanges(options);
  if (fault.empty() && frames && *frames < 1) fault = "--frames must be at least 1.";
  if (fault.empty()) fault = CheckFiles(options);
  if (!fault.empty()) {
    std::fprintf(stderr, "hgros-viewer: %s See `hgros-viewer --help`.\n", fault.c_str());
    return {std::nullopt, 2};
  }
  return {std::move(options), 0};
}

}  // namespace hgros::viewer
