#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Writes pictures into a film with the program ffmpeg. Each picture is shown in the film as long as it was on the
/// screen. The file's extension selects the format (.mp4, .mkv, .webm ...).
///
/// All pictures have the size of the first one: larger ones are cut, smaller ones get a black border.
class VideoRecorder {
 public:
  /// Errors: throws Error if there is no ffmpeg. `patience`: how long ffmpeg may accept no data. It may take several
  /// times as long to finish.
  explicit VideoRecorder(std::filesystem::path file, std::chrono::milliseconds patience = std::chrono::seconds(20));
  VideoRecorder(const VideoRecorder&) = delete;
  VideoRecorder& operator=(const VideoRecorder&) = delete;
  /// Finishes the film and ignores errors.
  ~VideoRecorder();

  /// Rows from the top, 3 bytes per pixel. Waits until ffmpeg accepts it. Returns what went wrong, or nothing. After an
  /// error nothing is recorded any more.
  [[nodiscard]] std::string Add(const Viewport& size, std::span<const std::uint8_t> rgb);
  /// Adds the last picture again, so that it is shown until now.
  [[nodiscard]] std::string Repeat();
  /// Ends the film and waits for ffmpeg, which is killed if it is stuck. Returns what went wrong, or nothing.
  [[nodiscard]] std::string Finish();
  [[nodiscard]] bool recording() const noexcept { return !ended_; }
  [[nodiscard]] std::size_t pictures() const noexcept { return pictures_; }

 private:
  [[nodiscard]] std::string Start(const Viewport& size);
  [[nodiscard]] std::string Send();
  /// Waits for ffmpeg's end. Returns its error message, or nothing.
  [[nodiscard]] std::string End();

  const std::filesystem::path file_;
  const std::chrono::milliseconds patience_;
  std::string program_;
  Viewport size_{0, 0};
  std::vector<std::uint8_t> last_;  ///< The last picture, in that size.
  pid_t child_ = -1;
  int to_child_ = -1;
  int words_ = -1;  ///< ffmpeg's standard error, as a file in memory.
  std::size_t pictures_ = 0;
  bool ended_ = false;
};

}  // namespace hgros::viewer
