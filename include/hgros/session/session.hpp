#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/config/config.hpp"
#include "hgros/session/node_timer.hpp"
#include "hgros/session/peer_event.hpp"
#include "hgros/session/session_network.hpp"
#include "hgros/session/session_publishing.hpp"
#include "hgros/session/session_services.hpp"
#include "hgros/session/session_subscribing.hpp"
#include "hgros/session/snapshot.hpp"

namespace hgros {

struct SessionOptions {
  std::string name;  ///< For logs and other sessions' tables; empty: the program's name.
  LogSink log = DefaultLogSink();
  std::shared_ptr<Clock> clock = nullptr;  ///< Empty: as the configuration says, usually the system's.
  std::function<Time()> wall = {};         ///< Stamps messages; empty: the system's. For tests of clocks that differ.
};

/// One participant of the hypergraph: a data graph and the bridges that join it to other sessions. Several may live
/// in one process; they then talk as two processes do.
///
/// Its functions are declared by subject: ToAny, ToGraph, Advertise in session_publishing.hpp; FromAny, FromGraph in
/// session_subscribing.hpp; Serve, Call in session_services.hpp; endpoints and peers in session_network.hpp.
///
/// Threading: thread-safe, except for construction and destruction.
/// Lifetime: the destructor refuses publishes, stops receiving, waits for callbacks in flight (after 2 s the log names
/// those that hang), and says goodbye. It must not run inside one of the session's callbacks.
/// Errors: wiring (channels, types, endpoints) throws Error. So does publishing to other sessions on a channel named
/// "hgros/...", which is the library's own. Publishing never throws for another reason and never blocks. ToAny, FromAny
/// and Advertise do not compile with a type that is no Message.
class HGROS_EXPORT Session : public SessionPublishing,
                             public SessionSubscribing,
                             public SessionServices,
                             public SessionNetwork {
 public:
  /// A session with the default configuration: it finds sessions of this host, and other hosts once endpoints are
  /// added.
  Session();
  /// Throws Error if an endpoint cannot be bound.
  explicit Session(Config config, SessionOptions options = {});
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  /// Calls `callback` every `period` of clock(), for as long as the NodeTimer lives, as a serial node of the data graph
  /// with that name. Jumps and pauses of the clock make neither a burst nor a gap. Turns that come while the callback
  /// runs wait as NodeTimerOptions::queue says; Tick::missed counts those left out. The first timer starts the thread
  /// that fires them all; it sleeps in between.
  /// Errors: throws Error unless `period` is above zero and no other timer of the session has the name.
  [[nodiscard("the callback is called only while the NodeTimer lives")]] NodeTimer CreateTimer(
      std::string_view name, Duration period, TimerCallback callback, NodeTimerOptions options = {});

  /// What the session's timers follow; use it for SleepUntil(), Rate and the like. Stamps and statistics use the wall
  /// clock all the same.
  [[nodiscard]] const std::shared_ptr<Clock>& clock() const noexcept;

  [[nodiscard]] SessionSnapshot Snapshot() const;
  /// Waits until nothing is queued and no callback runs in this process, as long as nothing new comes meanwhile.
  bool WaitIdle(std::chrono::nanoseconds timeout) const;

  [[nodiscard]] SessionId id() const noexcept;
  [[nodiscard]] const std::string& name() const noexcept;
  /// Where the session speaks, for what is built on it.
  [[nodiscard]] Log& log() const noexcept;
  /// As it is now, with endpoints and lists that were changed while running.
  [[nodiscard]] Config config() const;

 private:
  explicit Session(std::unique_ptr<SessionCore> core);

  std::unique_ptr<SessionCore> core_;
};

}  // namespace hgros
