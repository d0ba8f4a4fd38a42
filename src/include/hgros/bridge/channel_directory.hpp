#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "hgros/bridge/known_channel.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

// Merges the lists of sessions and channels of several sources. For each session the first source that knows it counts.
//
// Thread safety: none.
class ChannelDirectory {
 public:
  // Adds one source. It may list a session several times.
  void Add(const std::vector<SessionChannels>& source);
  // All channels, sorted by name.
  [[nodiscard]] std::vector<KnownChannel> Channels() const;

 private:
  struct Use {
    PeerInfo session;
    ChannelUse use;
  };
  std::set<std::uint64_t> known_;  // Session ids.
  // By channel and session.
  std::map<std::string, std::map<std::uint64_t, Use>> uses_;
};

}  // namespace hgros
