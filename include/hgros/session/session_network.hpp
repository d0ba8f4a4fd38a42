#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/bridge/known_channel.hpp"
#include "hgros/clock/clock_offset.hpp"
#include "hgros/config/config.hpp"
#include "hgros/transport/peer_info.hpp"

namespace hgros {

class NetworkBridge;
class SessionCore;

/// The endpoints and peers of a Session. Use it as a part of Session, which documents threading and errors.
class HGROS_EXPORT SessionNetwork {
 public:
  /// Adds `channel` to the lists of the publisher endpoints, or removes it. Only listed channels leave through them.
  void AllowPublishing(std::string_view channel, bool allowed);
  /// The same for the subscriber endpoints, through which messages enter.
  void AllowSubscribing(std::string_view channel, bool allowed);

  /// Binds or connects one more endpoint. Throws Error if that is not possible, or if a configuration file may not have
  /// it.
  void AddPublisherEndpoint(const EndpointConfig& endpoint);
  void AddSubscriberEndpoint(const EndpointConfig& endpoint);
  void RemoveSubscriberEndpoint(std::string_view endpoint);
  /// The addresses that other sessions can connect to, with the actual ports.
  [[nodiscard]] std::vector<std::string> PublisherEndpoints() const;

  /// How far the wall clock of the peer's host is ahead of ours, and how exactly that is known; zero on this host.
  /// Known one heartbeat after two sessions have connected over endpoints, and improved by each heartbeat. Latencies in
  /// statistics are corrected by it. Empty for a session that is not a peer or has not answered yet.
  [[nodiscard]] std::optional<ClockOffset> OffsetTo(SessionId peer) const;

  /// Waits on the calling thread until `done()`, and lets this thread receive what sessions of this host send, so that
  /// no other one has to be woken first. For loops that handle messages on a thread of their own, such as those of
  /// other languages. Callbacks of Executor::Inline() may run on this thread; `done` must neither block nor throw.
  ///
  /// Returns true after `done()`, after `until`, after a signal, or for no reason. False at once: this thread cannot
  /// receive, because shared memory is off or spins, or another thread does so; then wait in another way. The session
  /// outlives the call.
  [[nodiscard]] bool ReceiveHere(const std::function<bool()>& done, std::chrono::steady_clock::time_point until);
  /// Lets ReceiveHere() call `done` once more. Call it after another thread has changed what that depends on. It takes
  /// no lock.
  void WakeReceiver() const noexcept;

  /// The sessions that are connected now, each with the transport of its messages.
  [[nodiscard]] std::vector<PeerInfo> Peers() const;
  /// This session or one of the Peers() as logs and errors name it: "talker:4711", with "@robot" on another host. The
  /// id of any other session.
  [[nodiscard]] std::string NameOf(SessionId session) const;
  /// All channels that the session could publish on or receive, including its own, sorted by name. A message on
  /// kChannelEventsChannel reports that they may have changed.
  [[nodiscard]] std::vector<KnownChannel> Channels() const;

 protected:
  explicit SessionNetwork(SessionCore& core) noexcept : network_core_(core) {}
  ~SessionNetwork() = default;

 private:
  SessionCore& network_core_;
  std::atomic<NetworkBridge*> receiving_{nullptr};  // Of the last ReceiveHere().
};

}  // namespace hgros
