#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>

#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/session/snapshot.hpp"

namespace hgros {

// Publishes the counters of this session once per second while another session subscribes to them. Otherwise it costs
// only an entry in the session's announcement. A lossless subscriber without room loses messages, so that others still
// get them.
//
// Thread safety: all functions from any thread.
class SnapshotPublisher {
 public:
  struct Means {
    std::function<SessionSnapshot()> count;
    // Runs an errand after the delay, never inside the call, and never after this object has ended.
    std::function<void(std::chrono::nanoseconds, std::function<void()>)> later;
  };

  SnapshotPublisher(MessageId publisher, const std::shared_ptr<Log>& log,
                    const std::shared_ptr<const HostClocks>& clocks, Means means);

  [[nodiscard]] const std::shared_ptr<ChannelOutlet>& outlet() const noexcept { return outlet_; }

 private:
  void TellSoon(std::chrono::nanoseconds delay);
  void Tell();

  const Means means_;
  std::atomic<bool> telling_{false};
  std::shared_ptr<ChannelOutlet> outlet_;
};

}  // namespace hgros
