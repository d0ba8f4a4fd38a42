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

/// Draws the matched scans of `pre_channel` into the map and publishes the changes on `next_channel`, once per scan.
///
/// A mapper on standby begins with the state that another one publishes on `map_state`, and continues from there with
/// its own parameters. A changed parameter takes effect between two scans.
/// Lifetime: destroy it after the ending has been decided.
class MapperNode {
 public:
  static constexpr const char* kName = "mapper";

  /// `taken_over`: called on a graph worker with the first scan of this mapper, once it has received the state that it
  /// waited for. If it is empty, the mapper begins with an empty map.
  /// `params` must outlive the node.
  MapperNode(hgros::Session& session, NodeParams<MapOptions>& params, Ending& ending, Console& console,
             std::function<void(std::uint64_t)> taken_over = {});

  /// Waits until all scans before `next_scan` are in the map and published. False if the program ends first.
  [[nodiscard]] bool WaitFor(std::uint64_t next_scan);
  /// Publishes the complete state of this mapper on `map_state`.
  void PublishState();
  /// Called when another process has taken over. Stops offering the parameters, which no longer affect the map.
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
  std::optional<hgros::ParamService> offered_;  // Set while this mapper owns the map.
};

}  // namespace slam2d
