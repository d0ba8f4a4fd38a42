#pragma once

#include <filesystem>

#include "viewer/data/free_name.hpp"

namespace hgros::viewer {

/// The file that the layout is written to. A file that this viewer has neither read nor written is never replaced.
struct LayoutTarget {
  std::filesystem::path path;
  bool is_own = false;  ///< The viewer has read or written it.
  bool save_on_exit = false;

  /// The name of the next written file.
  [[nodiscard]] std::filesystem::path Next() const { return is_own ? path : FreeName(path); }
};

}  // namespace hgros::viewer
