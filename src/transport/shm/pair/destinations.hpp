#pragma once

#include <chrono>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hgros/base/ids.hpp"
#include "transport/shm/pair/pair.hpp"

namespace hgros::shm {

/// The places that we connect to, and when to try next.
///
/// Thread safety: all functions; the mutex is a leaf. Invariants: each place is in the list once. The pause between
/// two tries doubles until a pair begins.
class Destinations {
 public:
  /// False if the place is known.
  bool Add(const std::string& place);
  void Remove(const std::string& place);

  /// The places to connect to now. Those whose session `is_connected` already are left out.
  [[nodiscard]] std::vector<std::string> Due(SteadyTime now, const std::function<bool(SessionId)>& is_connected);
  /// The time of the next try, but not after `latest`.
  [[nodiscard]] SteadyTime NextTry(SteadyTime latest) const;

  /// A connection to the place was made, or (null) failed.
  void SetPair(const std::string& place, const std::shared_ptr<Pair>& pair);
  void SetSession(const std::string& place, SessionId session);
  void ResetPause(const std::string& place);
  void ForgetPair(const std::shared_ptr<Pair>& pair);

 private:
  struct Destination {
    std::string place;
    SteadyTime next_try{};
    std::chrono::milliseconds pause{0};
    std::weak_ptr<Pair> pair;
    SessionId session;  // The one that was last found there.
    [[nodiscard]] bool Connected() const {
      const auto known = pair.lock();
      return known && !known->ending;  // A pair that has ended may hold messages for a long time.
    }
  };

  mutable std::mutex mutex_;
  std::list<Destination> destinations_;
};

}  // namespace hgros::shm
