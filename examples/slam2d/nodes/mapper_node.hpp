#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>

#include <hgros/hgros.hpp>
#include <hgros/params/param_service.hpp>

#include "../app/console.hpp"
#include "../app/ending.hpp"
#include "../app/messages.hpp"
#include "map_owner.hpp"
#include "node_params.hpp"

namespace slam2d {

/// Draws the matched scans of `pre_channel` into the map and publishes what changed on `next_channel`, once a scan.
///
/// A mapper on standby begins with the state that another one publishes on `map_state`, and goes on where that stopped,
/// with parameters of its own. Those that are set take effect between two scans.
/// Lifetime: to be destroyed after the ending has been decided.
class MapperNode {
 public:
  static constexpr const char* kName = "mapper";

  /// `taken_over`: called with the first scan that is this mapper's, once it holds the state it waited for; on a graph
  /// worker. None: the mapper begins with an empty map.
  /// `params` is to outlive the node.
  MapperNode(hgros::Session& session, NodeParams<MapOptions>& params, Ending& ending, Console& console,
             std::function<void(std::uint64_t)> taken_over = {});

  /// Waits until all scans before `next_scan` are in the map and published; false if the program ends before.
  [[nodiscard]] bool WaitFor(std::uint64_t next_scan);
  /// Everything this mapper holds, on `map_state`.
  void PublishState();
  /// Another process has taken over: the parameters of this mapper are no longer those of the map.
  void Retire();

  [[nodiscard]] std::uint64_t next_scan() const;

 private:
  void TakeMatch(const msg::MatchedScan& message);
  void TakeState(const msg::MapState& message);
  void OfferParams();

  hgros::Session& session_;
  NodeParams<MapOptions>& params_;
  Ending& ending_;
  Console& console_;
  const std::stop_token stop_;
  const std::function<void(std::uint64_t)> taken_over_;
  hgros::Publisher<msg::MapUpdate> updates_;
  hgros::Publisher<msg::MapState> states_;

  mutable std::mutex mutex_;
  std::condition_variable_any published_;
  MapOwner owner_;
  bool standby_;
  std::uint64_t published_scans_ = 0;

  hgros::Subscription state_subscription_;
  hgros::Subscription match_subscription_;
  std::optional<hgros::ParamService> offered_;  // While the map is this mapper's.
};

}  // namespace slam2d
