#pragma once

#include <cstddef>
#include <mutex>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "hgros/transport/transport.hpp"

namespace hgros {

/// The connected sessions. A session that is connected in both directions comes and goes once.
/// Thread safety: Came() and Gone() on one thread at a time; List() is thread-safe.
class PeerRegistry {
 public:
  explicit PeerRegistry(TransportListener& listener) : listener_(listener) {}
  void Came(const PeerInfo& peer);
  void Gone(const PeerInfo& peer, std::string_view reason);
  [[nodiscard]] std::vector<PeerInfo> List() const;

 private:
  struct Entry {
    PeerInfo info;
    std::size_t connections = 0;
  };
  TransportListener& listener_;
  mutable std::mutex mutex_;
  std::unordered_map<SessionId, Entry> peers_;
};

}  // namespace hgros
