#pragma once

#include <map>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/discovery/discovery.hpp"
#include "hgros/transport/zmq_transport.hpp"

namespace hgros {

/// Connects to the endpoints of sessions that a beacon hears, as long as it hears them. An endpoint that the
/// configuration names is not touched: it is already there, with its own list of channels.
///
/// Thread safety: all functions.
class LanPeers final : public DiscoveryListener {
 public:
  /// `configured`: endpoints that are subscribed to even if they are not heard. The other arguments outlive it.
  LanPeers(ZmqTransport& zmq, Log& log, std::set<std::string> configured)
      : zmq_(zmq), log_(log), configured_(std::move(configured)) {}

  void OnCame(const Announcement& peer) override;
  void OnChanged(const Announcement& peer) override;
  void OnGone(const Announcement& last, std::string_view reason) override;

  /// The endpoint will be subscribed to even if it is not heard; or no longer.
  void Configure(const std::string& endpoint);
  void Release(const std::string& endpoint);

 private:
  // Under mutex_.
  void Connect(const std::string& endpoint);
  void Update(SessionId session, const std::vector<std::string>& endpoints);

  ZmqTransport& zmq_;
  Log& log_;
  std::mutex mutex_;
  std::set<std::string> configured_;
  std::map<std::string, std::unordered_set<SessionId>> heard_;  // By endpoint; two sessions may share one for a while.
};

/// Whether sessions of other hosts can connect to an endpoint that is bound there.
[[nodiscard]] bool ReachesOtherHosts(std::string_view endpoint) noexcept;

}  // namespace hgros
