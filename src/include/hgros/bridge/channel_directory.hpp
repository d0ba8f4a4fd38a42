#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "hgros/bridge/known_channel.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

// Puts together what several sources say of sessions and their channels. The first source that knows a session counts.
//
// Thread safety: none.
class ChannelDirectory {
 public:
  // What one source says; of a session it may say something several times.
  void Add(const std::vector<SessionChannels>& source);
  // By name.
  [[nodiscard]] std::vector<KnownChannel> Channels() const;

 private:
  struct Use {
    PeerInfo session;
    ChannelUse use;
  };
  std::set<std::uint64_t> known_;  // Sessions.
  // By channel and session.
  std::map<std::string, std::map<std::uint64_t, Use>> uses_;
};

}  // namespace hgros
