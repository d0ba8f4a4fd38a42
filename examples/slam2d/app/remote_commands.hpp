#pragma once

#include <hgros/config/config.hpp>

#include "options.hpp"

namespace slam2d {

/// Sends requests to a demo that runs in other processes, on any host: sets parameters, lists them, saves the map.
/// Prints the result and returns the exit code.
[[nodiscard]] int AskRunningDemo(const Options& options, const hgros::Config& config);

}  // namespace slam2d
