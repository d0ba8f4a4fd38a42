#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "viewer/app/options.hpp"
#include "viewer/panels/layout_target.hpp"

namespace hgros::viewer {

/// The state of a viewer that its layout does not contain. It is passed to the viewer that replaces it.
struct Carried {
  std::vector<WantedDisplay> awaited;  ///< Their schema is not known yet.
  std::set<std::string> found;         ///< Channels that were found and shown, including those that were removed later.
  bool keeps_finding = false;          ///< The value of `show_found` for the next written layout.
  std::optional<LayoutTarget> layout_file{};
};

}  // namespace hgros::viewer
