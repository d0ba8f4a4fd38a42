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
  std::string name;  ///< For logs and other sessions' tables: visible UTF-8 text. Empty: the program's name.
  LogSink log = DefaultLogSink();          ///< Must live as long as the session; see its Lifetime.
  std::shared_ptr<Clock> clock = nullptr;  ///< Null: the clock of the configuration, usually the system's.
  std::function<Time()> wall = {};         ///< The wall clock that stamps messages; empty: the system's. For tests.
};

/// One participant of the hypergraph: a data graph and the bridges that join it to other sessions. Several may live
/// in one process; they then talk as two processes do.
///
/// Its functions are declared by subject: ToAny, ToGraph, Advertise in session_publishing.hpp; FromAny, FromGraph in
/// session_subscribing.hpp; Serve, Call in session_services.hpp; endpoints and peers in session_network.hpp.
///
/// Threading: thread-safe, except for construction and destruction.
/// Lifetime: the destructor refuses publishes, stops receiving, waits for running callbacks (after 2 s the log names
/// those that hang), and says goodbye to its peers. What was published is still sent; if a lossless subscriber takes
/// nothing for 500 ms, or not all within peer_timeout_ms, the log says that the rest is lost. Destroy it outside its
/// callbacks: inside one, it says goodbye, logs which callback it was, and the rest of it stays until the process ends.
/// exit() may be called anywhere; inside a callback the session says goodbye and ends with the process. In both cases
/// SessionOptions::log may be called until the process ends. Errors: wiring (channels, types, endpoints) throws Error.
/// So does publishing to other sessions on a channel named "hgros/...", because these belong to the library. Publishing
/// never throws for another reason and never blocks. ToAny, FromAny and Advertise do not compile with a type that is
/// not a Message.
class HGROS_EXPORT Session : public SessionPublishing,
                             public SessionSubscribing,
                             public SessionServices,
                             public SessionNetwork {
 public:
  /// A session with the program's name and the configuration in HGROS_CONFIG, as YAML, which `hgros run` gives to
  /// programs of a robot with several hosts; without it the default. With its first channel it finds the sessions of
  /// this user on this host that are in the same domain: that of HGROS_DOMAIN, or else "default". AddPublisherEndpoint
  /// and AddSubscriberEndpoint join it to other hosts.
  /// Errors: throws Error if HGROS_DOMAIN is not a domain, and as the next one.
  Session();
  /// Throws Error if an endpoint cannot be bound, or if the name or HGROS_DOMAIN cannot be used.
  explicit Session(Config config, SessionOptions options = {});
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  /// Calls `callback` every `period` of clock() while the NodeTimer lives, as a serial node of the data graph with that
  /// name. Jumps and pauses of the clock cause neither a burst nor a gap. Turns that come while the callback runs wait
  /// in NodeTimerOptions::queue; Tick::missed counts skipped turns. One thread fires all timers of the session. It
  /// starts with the first timer and sleeps in between. The channel of a name stays until the session ends, so timers
  /// that come and go take the same few names.
  /// Errors: throws Error if `period` is not above zero or another timer of the session has the name.
  [[nodiscard("the callback is called only while the NodeTimer lives")]] NodeTimer CreateTimer(
      std::string_view name, Duration period, TimerCallback callback, NodeTimerOptions options = {});

  /// The clock of the session's timers, also for SleepUntil(), Rate and the like. Stamps and statistics always use the
  /// wall clock.
  [[nodiscard]] const std::shared_ptr<Clock>& clock() const noexcept;

  /// All counters of the session. Each counter is exact, but they are read one after the other.
  [[nodiscard]] SessionSnapshot Snapshot() const;
  /// Waits until no message is queued and no callback runs in this session, provided that no message comes meanwhile.
  /// False if `timeout` came first.
  bool WaitIdle(std::chrono::nanoseconds timeout) const;

  [[nodiscard]] SessionId id() const noexcept;
  [[nodiscard]] const std::string& name() const noexcept;
  /// The session's log, for code that is built on the session.
  [[nodiscard]] Log& log() const noexcept;
  /// The current configuration, including endpoints and lists that were changed at run time.
  [[nodiscard]] Config config() const;

 private:
  friend class SessionParts;
  explicit Session(std::unique_ptr<SessionCore> core);
  [[nodiscard]] std::shared_ptr<const void> TryReserve(std::string_view name);
  Time SettleTimers();

  std::unique_ptr<SessionCore> core_;
};

}  // namespace hgros
