#pragma once

#include <chrono>
#include <vector>

#include "hgros/transport/transport.hpp"

namespace hgros {

// What discovery says of who subscribes to a channel elsewhere.
struct ChannelSearch {
  std::vector<PeerInfo> announced;  // Sessions of this host that say that they do.
  bool complete = false;            // Nobody else could.
  // If it is only not complete yet: when it will be.
  std::chrono::steady_clock::time_point complete_at = std::chrono::steady_clock::time_point::max();
};

}  // namespace hgros
