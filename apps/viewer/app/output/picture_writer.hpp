#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "viewer/app/notices.hpp"
#include "viewer/app/output/video_recorder.hpp"
#include "viewer/app/surface/surface.hpp"

namespace hgros::viewer {

/// Writes what the surface shows into PNG files and a film.
class PictureWriter {
 public:
  PictureWriter(const Surface& surface, Notices& notices) : surface_(surface), notices_(notices) {}

  /// Errors: throws Error if there is no ffmpeg.
  void StartFilm(const std::filesystem::path& file) { film_.emplace(file); }
  void FinishFilm();
  /// Writes the next picture into a file.
  void RequestScreenshot(std::filesystem::path file);
  /// The same, with a name made of the time: "hgros-viewer-20261122-070603.png".
  void RequestScreenshotNamedByTime();
  /// Call it when a picture is drawn and not yet presented.
  void Write();

 private:
  void WriteScreenshot(const std::filesystem::path& file);
  /// Rows from the top, 3 bytes per pixel.
  [[nodiscard]] std::vector<std::uint8_t> ReadPixels() const;

  const Surface& surface_;
  Notices& notices_;
  std::filesystem::path screenshot_;  ///< Empty: none is requested.
  std::optional<VideoRecorder> film_;
};

}  // namespace hgros::viewer
