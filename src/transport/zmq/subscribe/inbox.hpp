#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "transport/actions.hpp"
#include "transport/leader_pool.hpp"
#include "transport/zmq/subscribe/inbound_packet.hpp"

namespace hgros::zmq {

/// The packets and calls into the session that one subscribe endpoint has read and not delivered yet, in order.
/// Thread safety: none; it belongs to the leading thread, which delivers without the endpoint's mutex.
class Inbox {
 public:
  [[nodiscard]] bool empty() const noexcept { return arrivals_.empty(); }
  void AddPacket(std::shared_ptr<InboundCore> core, InboundPacket&& packet) {
    arrivals_.push_back({.core = std::move(core), .packet = std::move(packet), .action = {}});
  }
  void AddAction(std::function<void()>&& action) {
    arrivals_.push_back({.core = {}, .packet = {}, .action = std::move(action)});
  }
  /// Leaves `actions` empty.
  void AddActions(Actions& actions) {
    for (auto& action : actions) AddAction(std::move(action));
    actions.clear();
  }
  /// Delivers everything; returns early with a task that must run on another thread.
  [[nodiscard]] LeaderPool::Task DeliverAll(SharedState& shared, const std::string& endpoint);

 private:
  struct Arrival {
    std::shared_ptr<InboundCore> core;  // Null: `action` is to be called.
    InboundPacket packet;
    std::function<void()> action;
  };
  std::deque<Arrival> arrivals_;
};

}  // namespace hgros::zmq
