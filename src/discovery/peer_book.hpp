#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/discovery/discovery.hpp"

namespace hgros::discovery {

/// Everyone who is known, and what the listener has to hear about them yet.
///
/// Thread safety: all functions; Tell() by one thread.
class PeerBook {
 public:
  /// Enters a session or what is new about it.
  void Put(const Announcement& peer);
  /// Strikes a session out, if it is in here.
  void Remove(SessionId session, std::string_view reason);
  [[nodiscard]] std::vector<Announcement> List() const;
  [[nodiscard]] std::vector<SessionId> Sessions() const;
  /// Tells the listener what happened since the last time, without holding the lock.
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
  std::deque<News> news_;                        // Likewise.
};

}  // namespace hgros::discovery
