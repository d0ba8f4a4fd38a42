#pragma once

#include <chrono>
#include <vector>

#include "hgros/transport/transport.hpp"

namespace hgros {

/// The subscribers of a channel in other sessions, as far as discovery knows them.
struct ChannelSearch {
  std::vector<PeerInfo> announced;  ///< Sessions of this host that announce that they subscribe to it.
  bool complete = false;            ///< `announced` has all subscribers.
  /// If the search is not complete yet: when it will be; max() if never.
  std::chrono::steady_clock::time_point complete_at = std::chrono::steady_clock::time_point::max();
};

}  // namespace hgros
