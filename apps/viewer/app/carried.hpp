#pragma once

#include <set>
#include <string>
#include <vector>

#include "viewer/app/options.hpp"

namespace hgros::viewer {

/// What a viewer knows beside its layout, and no file keeps: for another one that takes its place.
struct Carried {
  std::vector<WantedDisplay> awaited;  ///< Their schema is still to be heard of.
  std::set<std::string> found;         ///< Channels that were shown by themselves, also those that were removed since.
  bool keeps_finding = false;          ///< What `show_found` says in the layout that is written.
};

}  // namespace hgros::viewer
