#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/bridge/channel_directory.hpp"
#include "hgros/bridge/channel_inlet.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "hgros/clock/host_clocks.hpp"

namespace hgros {

// The channels that a session receives from remote publishers: for each one the demands of its subscriptions and the
// inlet that serves them.
//
// Thread safety: all functions.
// Invariants: mutex_ guards the channels. Transports' callbacks do not take it, so the bridge may be called under it,
// except for ending an inbound channel, which waits for callbacks. Reconcile() does that outside the lock, one thread
// per channel at a time, and the errand thread calls it for subscriptions that end inside callbacks.
class InboundChannels {
 public:
  struct Means {
    std::shared_ptr<Log> log;
    std::shared_ptr<HostClocks> clocks;
    std::function<void()> on_change;  // Called when a publisher or a schema came or went.
    // Runs its argument on the errand thread, which exists from Join() on.
    std::function<void(std::function<void()>)> post;
    ChannelInlet::TellMisfit tell_misfit;
  };
  explicit InboundChannels(Means means);
  InboundChannels(const InboundChannels&) = delete;
  InboundChannels& operator=(const InboundChannels&) = delete;
  ~InboundChannels();

  // Adds a subscription's demand until the result is destroyed, which may happen after the end of the session.
  [[nodiscard]] static std::shared_ptr<const void> Add(const std::shared_ptr<InboundChannels>& self, Channel& channel,
                                                       const TypeInfo& type, const Demand& demand);
  // A subscription is about to be made. Until the result is destroyed, a channel that is received stays so. Otherwise
  // the subscription would miss what is published between the end of the old links and its demand.
  [[nodiscard]] static std::shared_ptr<const void> Expect(const std::shared_ptr<InboundChannels>& self,
                                                          const std::string& channel);
  // From now on, channels with subscriptions are received through `bridge`.
  void Join(NetworkBridge& bridge);
  // A forbidden channel is not received. Returns whether this ends a lossless subscription: messages on their way are
  // lost then. Call it on a thread that may wait.
  bool SetForbidden(const std::string& channel, bool forbidden);
  // Stops receiving. No wiring changes afterwards.
  void Close();
  // Destroys all inlets. Call it when none is in use any more.
  void Drop();

  [[nodiscard]] std::size_t PublisherCount(std::string_view channel) const;
  // Whether no thread joins or leaves the channel now. While it has a subscription, what is received from then on comes
  // over links that stay. Before, it may come over those of a subscription that has just ended.
  [[nodiscard]] bool IsSettled(std::string_view channel) const;
  // The schema of the publisher that came last, or null.
  [[nodiscard]] std::shared_ptr<const MessageSchema> SchemaOf(std::string_view channel) const;
  // Adds the channels with subscriptions.
  void AddTo(std::vector<ChannelUse>& uses) const;
  // Adds the counters of received messages: to the channel's entry, or in a new entry.
  void AddTo(std::vector<ChannelTraffic>& traffic) const;

 private:
  // One channel: its demands, and whether the bridge receives it.
  struct Inflow {
    std::shared_ptr<ChannelInlet> inlet;
    std::list<Demand> wanted;
    std::size_t raw = 0;       // Number of demands for any type.
    std::size_t expected = 0;  // Number of results of Expect().
    bool joined = false;
    bool busy = false;  // A thread is in Reconcile() for this channel.
    // Requests may have come that nobody took. It must be subscribed to again, which shows it to the callers.
    bool missed = false;
  };
  class DemandTicket;

  void ExpectNoMore(const std::string& channel);
  void Withdraw(const std::string& channel, std::list<Demand>::iterator demand, bool raw);
  // Passes what all demands together ask for to the publishers and to the announcement.
  void TellDemand(const std::string& channel, const Inflow& inflow) const;
  // Joins or ends the inbound channel, so that it fits the demands. Only with `may_wait` it also subscribes again.
  void Reconcile(const std::string& channel, bool may_wait);
  // Whether the channel is subscribed to with any type for raw subscriptions that have ended. A lossless one then stays
  // as it is, because messages get lost while it is subscribed to again.
  [[nodiscard]] static bool AsksForTooMuch(const Inflow& inflow);
  // Whether the bridge has to receive the channel.
  [[nodiscard]] bool IsWanted(const std::string& channel, const Inflow& inflow) const {
    return (!inflow.wanted.empty() || (inflow.joined && inflow.expected > 0)) && !forbidden_.contains(channel);
  }
  [[nodiscard]] static Demand Combine(const std::list<Demand>& wanted);

  const Means means_;
  mutable std::mutex mutex_;
  NetworkBridge* bridge_ = nullptr;
  bool closed_ = false;
  std::map<std::string, Inflow, std::less<>> inflows_;
  std::set<std::string> forbidden_;
};

}  // namespace hgros
