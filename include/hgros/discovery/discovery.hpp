#pragma once

#include <string_view>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros {

/// Hears which sessions come, change and go. Implemented by whoever looks for others.
///
/// Contract:
///  1. Calls come one at a time, and no lock is held meanwhile: first, for all who are there already, from the thread
///     that opens a Registry, before it is open; from then on from one thread of the Discovery.
///  2. For each session: OnCame, any number of OnChanged, OnGone, and perhaps OnCame again. States that came and went
///     within a moment may be left out. A session that returned in another incarnation goes and comes.
///  3. One's own session is never told of.
///  4. After ~Discovery has returned nothing is called any more.
///  5. They must not throw, and must not block for long: what happens next is told only after they return.
class DiscoveryListener {
 public:
  virtual ~DiscoveryListener() = default;
  virtual void OnCame(const Announcement& peer) = 0;
  virtual void OnChanged(const Announcement& peer) = 0;
  /// `last`: what was announced last. `reason`: one sentence.
  virtual void OnGone(const Announcement& last, std::string_view reason) = 0;
};

/// One way in which sessions find each other: a Registry (one host) or a Beacon (one network).
///
/// Threading: thread-safe. Announce() and List() may be called by the listener; the destructor may not.
/// Lifetime:  the listener and the log outlive it. The destructor withdraws what was announced.
/// Forks:     a forked child neither keeps anything alive nor hears anything; there Announce() throws Error, List() is
///            empty and the destructor does nothing.
class HGROS_EXPORT Discovery {
 public:
  virtual ~Discovery() = default;
  Discovery(const Discovery&) = delete;
  Discovery& operator=(const Discovery&) = delete;

  /// The first call makes `own` known before it returns; later ones replace it, soon, bursts of them at once.
  ///
  /// Errors: throws Error if `own` has no session id, or another one than before, or is too large; and, the first
  ///         time, if it cannot be made known. What fails later is logged.
  virtual void Announce(const Announcement& own) = 0;

  /// Everyone who is known at this moment, ordered by session id, without oneself. The listener may not have heard of
  /// the latest yet.
  [[nodiscard]] virtual std::vector<Announcement> List() const = 0;

 protected:
  Discovery() = default;
};

}  // namespace hgros
