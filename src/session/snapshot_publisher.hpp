#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>

#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/session/snapshot.hpp"

namespace hgros {

// Tells other sessions once a second what this one counts, while one of them subscribes to that. Until then it is an
// entry in what the session announces, and nothing else. While a lossless subscriber has no room nobody is told.
//
// Thread safety: all functions from any thread.
class SnapshotPublisher {
 public:
  struct Means {
    std::function<SessionSnapshot()> count;
    // Runs an errand after a while, not at once, and never after this has ended.
    std::function<void(std::chrono::nanoseconds, std::function<void()>)> later;
  };

  SnapshotPublisher(MessageId publisher, const std::shared_ptr<Log>& log,
                    const std::shared_ptr<const HostClocks>& clocks, Means means);

  [[nodiscard]] const std::shared_ptr<ChannelOutlet>& outlet() const noexcept { return outlet_; }

 private:
  void TellSoon(std::chrono::nanoseconds delay);
  void Tell();

  const Means means_;
  const std::shared_ptr<Log> log_;
  std::atomic<bool> telling_{false};
  std::shared_ptr<ChannelOutlet> outlet_;
};

}  // namespace hgros
