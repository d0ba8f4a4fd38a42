#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "viewer/data/free_name.hpp"

namespace hgros::viewer {

/// The file that the layout is written to. A file that this viewer has neither read nor written, or that has changed
/// since, is never replaced.
class LayoutTarget {
 public:
  LayoutTarget() = default;
  explicit LayoutTarget(std::filesystem::path file) : path(std::move(file)) {}

  std::filesystem::path path;
  bool save_on_exit = false;

  /// The viewer has read or written the file just now.
  void NoteOwn() { own_ = State::Of(path); }
  /// The name of the next written file.
  [[nodiscard]] std::filesystem::path Next() const { return own_ && own_ == State::Of(path) ? path : FreeName(path); }

 private:
  // Of a file, as far as an edit changes it.
  struct State {
    std::uintmax_t size = 0;
    std::filesystem::file_time_type written{};

    bool link = false;

    // Empty if it leads to no regular file.
    [[nodiscard]] static std::optional<State> Of(const std::filesystem::path& file) {
      std::error_code error;
      if (!std::filesystem::is_regular_file(file, error)) return {};
      return State{std::filesystem::file_size(file, error), std::filesystem::last_write_time(file, error),
                   std::filesystem::is_symlink(file, error)};
    }
    bool operator==(const State&) const = default;
  };
  std::optional<State> own_;
};

}  // namespace hgros::viewer
