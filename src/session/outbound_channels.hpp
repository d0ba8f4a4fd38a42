#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/bridge/channel_directory.hpp"
#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "hgros/clock/host_clocks.hpp"

namespace hgros {

// The channels that a session publishes to others: one outlet for each, and those of its services.
//
// Thread safety: all functions.
// Invariants: mutex_ guards the outlets. Transports' callbacks and publishes do not take it, so the bridge may be
// called under it, except for what waits for callbacks: detaching an outlet.
class OutboundChannels {
 public:
  OutboundChannels(MessageId publisher, std::shared_ptr<Log> log, std::shared_ptr<HostClocks> clocks);

  // The outlet of the channel; a new one is passed to `wire` before others see it. Null after Close().
  std::shared_ptr<ChannelOutlet> Open(const std::string& channel, const TypeInfo& type,
                                      const std::function<OutletEvents()>& events,
                                      const std::function<void(const std::shared_ptr<ChannelOutlet>&)>& wire);
  std::shared_ptr<ChannelOutlet> OpenForService(const std::string& channel, const TypeInfo& type, OutletEvents events);
  void CloseForService(const std::string& channel, const std::shared_ptr<SessionOutlet>& outlet);

  // The bridge is there: channels leave through it, now and from now on.
  void Join(NetworkBridge& bridge);
  // Makes no more outlets.
  void Close();
  // Later publishes stay inside the process.
  void Detach();

  // Null: the channel is not published.
  [[nodiscard]] std::shared_ptr<ChannelOutlet> Find(std::string_view channel) const;
  void AddTo(std::vector<ChannelUse>& uses) const;
  void AddTo(std::vector<ChannelTraffic>& traffic) const;

 private:
  const MessageId publisher_;
  const std::shared_ptr<Log> log_;
  const std::shared_ptr<HostClocks> clocks_;

  mutable std::mutex mutex_;
  NetworkBridge* bridge_ = nullptr;
  bool closed_ = false;
  std::map<std::string, std::shared_ptr<ChannelOutlet>, std::less<>> outlets_;
  std::vector<std::shared_ptr<ChannelOutlet>> service_outlets_;
  std::uint64_t last_incarnation_ = 0;  // Of these.
};

}  // namespace hgros
