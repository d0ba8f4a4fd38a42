#pragma once

#include <chrono>
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
#include "session/change_signal.hpp"

namespace hgros {

// The channels that a session publishes to others: one outlet per channel, and the outlets of its services.
//
// Thread safety: all functions.
// Invariants: mutex_ guards the outlets. Transports' callbacks and publishes do not take it, so the bridge may be
// called under it. An outlet is detached outside it, because that waits for callbacks.
class OutboundChannels {
 public:
  OutboundChannels(MessageId publisher, std::shared_ptr<Log> log, std::shared_ptr<HostClocks> clocks);

  // The outlet of the channel. A new outlet is passed to `wire` before other threads see it. Null after Close().
  std::shared_ptr<ChannelOutlet> Open(const std::string& channel, const TypeInfo& type,
                                      const std::function<OutletEvents()>& events,
                                      const std::function<void(const std::shared_ptr<ChannelOutlet>&)>& wire);
  // `promises`: whether subscribers may be lossless. After Close() the outlet reaches nobody.
  std::shared_ptr<ChannelOutlet> OpenForService(const std::string& channel, const TypeInfo& type, OutletEvents events,
                                                bool promises = true);
  void CloseForService(const std::string& channel, const std::shared_ptr<SessionOutlet>& outlet);

  // From now on, channels are published through `bridge`.
  void Join(NetworkBridge& bridge);
  // A forbidden channel does not leave the session: what is published from now on stays inside. What was accepted still
  // leaves, but only for a limited time; then it is withdrawn from others. One thread at a time; `later` runs an errand
  // on that thread. If it throws, nothing has changed.
  using Later = std::function<void(std::chrono::nanoseconds, std::function<void()>)>;
  void SetForbidden(const std::string& channel, bool forbidden, const Later& later);
  // Creates no more outlets.
  void Close();
  // Waits until everything was sent to lossless subscribers: `at_most` without progress, and `at_most_with_progress`
  // while the number of messages falls. Logs it if they do not take it in time. Returns the times that are left for the
  // rest of the end.
  struct TimeLeft {
    int linger_ms = 0;  // Without progress.
    int at_most_ms = 0;
  };
  [[nodiscard]] TimeLeft AwaitSent(std::chrono::milliseconds at_most, std::chrono::milliseconds at_most_with_progress,
                                   const ChangeSignal& changes) const;
  // Later publishes stay inside the process.
  void Detach();

  // Null if the channel is not published.
  [[nodiscard]] std::shared_ptr<ChannelOutlet> Find(std::string_view channel) const;
  void AddTo(std::vector<ChannelUse>& uses) const;
  void AddTo(std::vector<ChannelTraffic>& traffic) const;

 private:
  struct Waiting {
    std::size_t messages = 0;
    std::string channel;  // One of those that they wait in.
  };
  // Messages of channels in which some still wait to be sent to lossless subscribers.
  [[nodiscard]] Waiting Unsent() const;
  struct Forbidden {
    bool apart;            // Its outlet, if there is one, is not joined. Otherwise accepted messages still leave it.
    std::uint64_t number;  // Counts the calls that have forbidden a channel.
  };
  // Ends what the call with that number has begun, unless the channel was allowed meanwhile.
  void Withdraw(const std::string& channel, std::uint64_t number, std::chrono::steady_clock::time_point deadline,
                const Later& later);

  const MessageId publisher_;
  const std::shared_ptr<Log> log_;
  const std::shared_ptr<HostClocks> clocks_;

  mutable std::mutex mutex_;
  NetworkBridge* bridge_ = nullptr;
  bool closed_ = false;
  std::map<std::string, std::shared_ptr<ChannelOutlet>, std::less<>> outlets_;
  std::map<std::string, Forbidden, std::less<>> forbidden_;
  std::uint64_t last_forbidden_ = 0;
  std::vector<std::shared_ptr<ChannelOutlet>> service_outlets_;
  std::uint64_t last_incarnation_ = 0;  // The largest incarnation in service_outlets_ so far.
};

}  // namespace hgros
