#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/discovery/discovery.hpp"
#include "hgros/transport/zmq_transport.hpp"

namespace hgros {

/// Connects to the endpoints of sessions that a beacon hears. Datagrams may be lost or forged, so they only begin a
/// connection: an endpoint where a session has answered stays as long as that session does. An endpoint that the
/// configuration names is not touched: it is already there, with its own list of channels.
///
/// Thread safety: all functions.
/// Invariants: at most kMaxTries endpoints where no session has answered are connected to at a time. If others wait,
/// they take turns: first those of the sender that has waited longest. The endpoints at one address take at most a
/// quarter of the descriptors that those at other addresses leave. So a host that invents sessions does not keep out
/// others.
class LanPeers final : public DiscoveryListener {
 public:
  using Later = std::function<void(std::chrono::nanoseconds delay, std::function<void()> errand)>;

  static constexpr int kMaxTries = 2;
  /// Those of an endpoint. It has three more for a moment after its end.
  static constexpr std::size_t kDescriptors = 4;
  static constexpr std::size_t kMostEndpoints = 4096;  ///< Each has three of the sockets that ZeroMQ may have.
  static constexpr std::size_t kShare = 4;             ///< One address may have this part of what others leave.
  /// After this time without an answer, an endpoint gives way to one that waits.
  static constexpr auto kTryTime = std::chrono::seconds(2);

  /// `patience`: how long a session that is gone and not heard may take to come back. `later` runs errands, see
  /// BridgeOptions. `configured`: endpoints that are subscribed to even if they are not heard. The references outlive
  /// the object; no errand runs after its end.
  LanPeers(ZmqTransport& zmq, Log& log, std::chrono::milliseconds patience, Later later,
           std::set<std::string> configured);

  void OnCame(const Announcement& peer) override;
  void OnChanged(const Announcement& peer) override;
  void OnGone(const Announcement& last, std::string_view reason) override;

  /// The endpoint will be subscribed to even if it is not heard; or no longer.
  void Configure(const std::string& endpoint);
  void Release(const std::string& endpoint);

 private:
  using Time = std::chrono::steady_clock::time_point;
  enum class State {
    kWaiting,  // Not connected to.
    kTried,    // No session has answered yet.
    kReached,  // The session `answered` has.
    kLost,     // That session is gone, and may come back.
  };
  struct Endpoint {
    std::unordered_set<SessionId> sessions;  // Those that are heard; two may share an endpoint for a while.
    std::string sender;
    std::string host;  // The address in the endpoint. A sender's address may be forged.
    State state = State::kWaiting;
    SessionId answered;
    Time since{};              // When the state began.
    Time tried{};              // When the latest try began.
    std::uint64_t number = 0;  // The latest try's; events of earlier ones are ignored.
    bool refused = false;      // Something failed in the latest try.
    bool reported = false;     // It was logged that no session answers.
    unsigned failures = 0;     // Tries in a row without an answer.
  };
  using Endpoints = std::map<std::string, Endpoint, std::less<>>;

  // Under mutex_.
  void Update(const Announcement& peer, std::vector<std::string> endpoints);
  void SetState(Endpoint& endpoint, State state, Time now);
  // Connects to endpoints that wait, up to kMaxTries.
  void FillTries(Time now);
  void Connect(Endpoints::value_type& entry, Time now);
  void Disconnect(Endpoints::value_type& entry, Time now);
  void EndLost(Time now);
  void ReportUnanswered(Endpoints::value_type& entry);
  void ReportFull(const std::string& host);
  // How many endpoints at this address may be connected to.
  [[nodiscard]] std::size_t ShareOf(const std::string& host) const;
  [[nodiscard]] std::size_t ConnectedAt(const std::string& host) const;
  [[nodiscard]] bool Waits(const Endpoints::value_type& entry) const;
  [[nodiscard]] bool IsReachedElsewhere(const Endpoints::value_type& entry) const;
  [[nodiscard]] bool IsFull(const std::string& host) const { return ConnectedAt(host) >= ShareOf(host); }
  // The endpoint that is tried next; null if none waits, or all that wait have to pause.
  [[nodiscard]] Endpoints::value_type* FindNext(Time now);
  // When it gives way, if others wait.
  [[nodiscard]] static Time EndOf(const Endpoint& tried);
  // The try that gives way next; there is one.
  [[nodiscard]] Endpoints::value_type& FindOldestTry();
  void ActAt(Time when);
  [[nodiscard]] std::optional<Time> NextAct(Time now);

  void OnEvent(const std::string& endpoint, std::uint64_t number, EndpointEvent event, SessionId session);
  // Does what time brings, on the thread of errands. Whatever needs no waiting is done at once on the calling thread,
  // because an errand of the program may block that one.
  void Act(Time due);

  ZmqTransport& zmq_;
  Log& log_;
  const std::chrono::milliseconds patience_;
  const Later later_;
  const std::size_t most_;  // Endpoints, at all addresses.
  std::mutex mutex_;
  std::string unanswered_;  // The first endpoint at which no session answered.
  std::string full_;        // The first address at which endpoints had to wait because it had its share.
  std::set<std::string> configured_;
  std::unordered_map<SessionId, std::vector<std::string>> announced_;
  Endpoints heard_;
  int tries_ = 0;                                              // The endpoints in kTried.
  std::size_t connected_ = 0;                                  // Those not in kWaiting.
  std::unordered_map<std::string, std::size_t> connected_at_;  // The same by address.
  std::uint64_t last_number_ = 0;
  Time acted_{};
  std::optional<Time> due_;  // When Act() runs next.
};

/// Whether sessions of other hosts can connect to an endpoint that is bound there.
[[nodiscard]] bool ReachesOtherHosts(std::string_view endpoint) noexcept;

}  // namespace hgros
