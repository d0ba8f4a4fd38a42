#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/session/snapshot.hpp"

namespace hgros {

// Publishes the counters of this session while another session subscribes to them: once per second, and when a new one
// subscribes, so that a program that only looks once need not wait. Otherwise it costs only an entry in the session's
// announcement. A lossless subscriber without room loses messages, so that others still
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
  void Plan(std::atomic<bool>& planned, std::chrono::nanoseconds delay) noexcept;
  void TellNewSubscriber();
  void Tell();
  void TellEverySecond();

  const Means means_;
  std::atomic<bool> newcomer_waits_{false};
  std::atomic<bool> next_is_planned_{false};
  std::atomic<std::int64_t> told_ns_{0};
  std::atomic<std::int64_t> telling_took_ns_{0};
  std::shared_ptr<ChannelOutlet> outlet_;
};

}  // namespace hgros
