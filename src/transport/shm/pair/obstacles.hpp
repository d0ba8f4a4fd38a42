#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <mutex>
#include <string>
#include <utility>

#include "hgros/base/ids.hpp"

namespace hgros::shm {

/// Why connections failed, the latest ones, for reports about sessions that are not reached.
///
/// Thread safety: all functions; the mutex is a leaf.
class Obstacles {
 public:
  /// `place`: where we connected to; empty if the session connected to us. `session`: zero if it did not greet.
  void Set(const std::string& place, SessionId session, std::string why) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(list_, [&](const Obstacle& one) { return one.place == place && one.session == session; });
    list_.push_front({place, session, std::move(why)});
    if (list_.size() > kMost) list_.pop_back();
  }
  /// The session is reached. So connections of sessions that did not greet may have been its own.
  void Clear(const std::string& place, SessionId session) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(list_, [&](const Obstacle& one) { return one.Fits(place, session); });
  }
  /// The latest for this session; empty if there is none.
  [[nodiscard]] std::string Find(const std::string& place, SessionId session) const {
    const std::scoped_lock lock(mutex_);
    const auto found = std::ranges::find_if(list_, [&](const Obstacle& one) { return one.Fits(place, session); });
    return found == list_.end() ? std::string() : found->why;
  }

 private:
  static constexpr std::size_t kMost = 64;
  struct Obstacle {
    std::string place;
    SessionId session;
    std::string why;
    [[nodiscard]] bool Fits(const std::string& other_place, SessionId other) const {
      return session == other || (session.value == 0 && (place.empty() || place == other_place));
    }
  };
  mutable std::mutex mutex_;
  std::deque<Obstacle> list_;  // The latest first.
};

}  // namespace hgros::shm
