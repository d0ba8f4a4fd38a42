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

/// Writes pictures into a film, by the program ffmpeg, which gets them as they are drawn: how long each one is seen
/// is how long it was there. Which kind of film it is, its name says (.mp4, .mkv, .webm ...).
///
/// All pictures have the size of the first one: what is larger is cut, what is smaller has a black edge.
class VideoRecorder {
 public:
  /// Errors: throws Error if there is no ffmpeg.
  /// `patience`: so long ffmpeg may take no byte at all, and some times as long it may need for its end.
  explicit VideoRecorder(std::filesystem::path file, std::chrono::milliseconds patience = std::chrono::seconds(20));
  VideoRecorder(const VideoRecorder&) = delete;
  VideoRecorder& operator=(const VideoRecorder&) = delete;
  /// As Finish, without a word.
  ~VideoRecorder();

  /// Rows from the top, 3 bytes a pixel. Waits for ffmpeg to take it. Returns what went wrong, or nothing; after a
  /// fault nothing is recorded any more.
  [[nodiscard]] std::string Add(const Viewport& size, std::span<const std::uint8_t> rgb);
  /// The last picture once more: it is seen until now.
  [[nodiscard]] std::string Repeat();
  /// Ends the film and waits for ffmpeg, which is killed if it is stuck. Returns what went wrong, or nothing.
  [[nodiscard]] std::string Finish();
  [[nodiscard]] bool recording() const noexcept { return !ended_; }
  [[nodiscard]] std::size_t pictures() const noexcept { return pictures_; }

 private:
  [[nodiscard]] std::string Start(const Viewport& size);
  [[nodiscard]] std::string Send();
  /// Takes ffmpeg's end, and what it said of it.
  [[nodiscard]] std::string End();

  const std::filesystem::path file_;
  const std::chrono::milliseconds patience_;
  std::string program_;
  Viewport size_{0, 0};
  std::vector<std::uint8_t> last_;  ///< The last picture, in that size.
  pid_t child_ = -1;
  int to_child_ = -1;
  int words_ = -1;  ///< What ffmpeg says on standard error, as a file in memory.
  std::size_t pictures_ = 0;
  bool ended_ = false;
};

}  // namespace hgros::viewer
