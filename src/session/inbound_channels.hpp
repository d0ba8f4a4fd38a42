#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/bridge/channel_directory.hpp"
#include "hgros/bridge/channel_inlet.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "hgros/clock/host_clocks.hpp"

namespace hgros {

// What a session asks of remote publishers, by channel: the demands of its subscriptions and the inlet that serves
// them.
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
    std::function<void()> on_change;  // A publisher or a schema has come or gone.
    std::function<void(std::function<void()>)>
        post;  // Runs it on the errand thread, which is there once Join() is called.
    ChannelInlet::TellMisfit tell_misfit;
  };
  explicit InboundChannels(Means means);
  InboundChannels(const InboundChannels&) = delete;
  InboundChannels& operator=(const InboundChannels&) = delete;
  ~InboundChannels();

  // A subscription's part of what is asked, until the result is destroyed, which may be after the session's end.
  [[nodiscard]] static std::shared_ptr<const void> Add(const std::shared_ptr<InboundChannels>& self, Channel& channel,
                                                       const TypeInfo& type, const Demand& demand);
  // The bridge is there: channels with subscriptions are received, now and from now on.
  void Join(NetworkBridge& bridge);
  // Receives nothing more; no wiring changes afterwards.
  void Close();
  // No inlet is in use any more.
  void Drop();

  [[nodiscard]] std::size_t PublisherCount(std::string_view channel) const;
  // What the latest of the publishers sends, or null.
  [[nodiscard]] std::shared_ptr<const MessageSchema> SchemaOf(std::string_view channel) const;
  // Those with subscriptions.
  void AddTo(std::vector<ChannelUse>& uses) const;
  // Adds what was received to the channels that are listed, and lists the others.
  void AddTo(std::vector<ChannelTraffic>& traffic) const;

 private:
  // How far the demands are put into effect.
  struct Inflow {
    std::shared_ptr<ChannelInlet> inlet;
    std::list<Demand> wanted;
    bool joined = false;
    bool busy = false;  // A thread is in Reconcile() for this channel.
  };
  class DemandTicket;

  void Withdraw(const std::string& channel, std::list<Demand>::iterator demand);
  // Joins or ends the inbound channel as the wanted demands say.
  void Reconcile(const std::string& channel);
  [[nodiscard]] static Demand Combine(const std::list<Demand>& wanted);

  const Means means_;
  mutable std::mutex mutex_;
  NetworkBridge* bridge_ = nullptr;
  bool closed_ = false;
  std::map<std::string, Inflow, std::less<>> inflows_;
};

}  // namespace hgros
