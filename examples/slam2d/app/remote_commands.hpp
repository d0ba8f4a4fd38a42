#pragma once

#include <hgros/config/config.hpp>

#include "options.hpp"

namespace slam2d {

/// Asks the demo that runs in other processes, wherever these are: sets parameters, lists them, saves the map. Returns
/// the exit code; what came of it has been said.
[[nodiscard]] int AskRunningDemo(const Options& options, const hgros::Config& config);

}  // namespace slam2d
