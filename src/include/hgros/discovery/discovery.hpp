#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros {

/// Gets events about sessions that come, change and go.
///
/// Contract:
///  1. Calls come one at a time and without a lock held. A Registry first reports all sessions that are already there,
///     from the thread that opens it; every later call comes from one thread of the Discovery.
///  2. For each session: OnCame, any number of OnChanged, OnGone, then possibly OnCame again. States that last only a
///     moment may be skipped. A session that restarts with another incarnation goes and comes.
///  3. The own session is never reported.
///  4. After ~Discovery has returned nothing is called.
///  5. The functions must not throw and must not block for long: the next event is reported after they return.
class DiscoveryListener {
 public:
  virtual ~DiscoveryListener() = default;
  virtual void OnCame(const Announcement& peer) = 0;
  virtual void OnChanged(const Announcement& peer) = 0;
  /// `last`: the last announcement. `reason`: one sentence.
  virtual void OnGone(const Announcement& last, std::string_view reason) = 0;
};

/// A way in which sessions find each other: a Registry (one host) or a Beacon (one network).
///
/// Threading: thread-safe. The listener may call Announce() and List(), but not the destructor.
/// Lifetime:  the listener and the log outlive it. The destructor withdraws the announcement.
/// Forks:     a forked child keeps nothing alive and hears nothing; there Announce() throws Error, List() is empty and
/// the destructor does nothing.
class HGROS_EXPORT Discovery {
 public:
  virtual ~Discovery() = default;
  Discovery(const Discovery&) = delete;
  Discovery& operator=(const Discovery&) = delete;

  /// The first call makes `own` known before it returns. Later calls replace it soon; several quick calls are sent as
  /// one.
  ///
  /// Errors: throws Error if `own` has no session id, has another one than before or is too large, and on the first
  /// call also if it cannot be made known. Later failures are logged.
  virtual void Announce(const Announcement& own) = 0;

  /// All known sessions except the own one, ordered by session id; only those for which `which` returns true, if it is
  /// set. `which` is called under a lock. The listener may not have got the latest events yet.
  using Which = std::function<bool(const Announcement& peer)>;
  [[nodiscard]] virtual std::vector<Announcement> List(const Which& which) const = 0;
  [[nodiscard]] std::vector<Announcement> List() const { return List({}); }

 protected:
  Discovery() = default;
};

}  // namespace hgros
