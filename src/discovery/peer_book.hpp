#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/discovery/discovery.hpp"

namespace hgros::discovery {

/// All known sessions, and the events that were not reported to the listener yet.
///
/// Thread safety: all functions; Tell() from one thread.
class PeerBook {
 public:
  /// Adds a session or updates it.
  void Put(Announcement peer);
  /// Removes a session if it is known.
  void Remove(SessionId session, std::string_view reason);
  /// See Discovery::List().
  [[nodiscard]] std::vector<Announcement> List(const Discovery::Which& which = {}) const;
  [[nodiscard]] std::vector<SessionId> Sessions() const;
  [[nodiscard]] std::size_t size() const;
  /// Reports all new events to the listener, without holding the lock.
  void Tell(DiscoveryListener& listener);

 private:
  enum class Event { kCame, kChanged, kGone };
  struct News {
    Event event;
    Announcement peer;
    std::string reason;
  };

  mutable std::mutex mutex_;
  std::map<std::uint64_t, Announcement> peers_;  // By session id. Guarded by mutex_.
  std::deque<News> news_;                        // Guarded by mutex_.
};

}  // namespace hgros::discovery
