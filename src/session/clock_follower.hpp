#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <hgros/SimulatedTime.pb.h>

#include "hgros/base/log.hpp"
#include "hgros/clock/errand_thread.hpp"
#include "hgros/clock/following_clock.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/graph/message_info.hpp"
#include "hgros/session/peer_event.hpp"

namespace hgros {

// Decides which published clock a session follows: the first one, until it ends or its session is gone. Then the rival
// that was published meanwhile is followed.
//
// Thread safety: all functions. Listeners of the clock run under the lock.
class ClockFollower {
 public:
  // Subscribes to a channel that other sessions may publish.
  using Subscribe =
      std::function<Subscription(Channel& channel, const TypeInfo& type, AnyCallback callback, NodeOptions options)>;
  // Lets `clock` follow the clocks that are published, as long as the result lives.
  [[nodiscard]] static std::vector<Subscription> Follow(const std::shared_ptr<FollowingClock>& clock, DataGraph& graph,
                                                        const std::shared_ptr<Log>& log, ErrandThread& errands,
                                                        const Subscribe& subscribe);

  ClockFollower(std::shared_ptr<FollowingClock> clock, std::shared_ptr<Log> log);

  void OnTime(const SimulatedTime& time, const MessageInfo& info);
  void OnPeer(const PeerEvent& event);
  // Logs that the clock stands at 0 if no clock was published so far.
  void SayIfNoneWasHeard();

 private:
  // The latest message of a clock.
  struct Heard {
    std::uint64_t session = 0;
    std::uint64_t clock = 0;
    std::string publisher;
    ClockState state;
    std::int64_t at_ns = 0;  // CLOCK_MONOTONIC
    bool ended = false;

    [[nodiscard]] bool SameClock(const Heard& other) const { return session == other.session && clock == other.clock; }
    [[nodiscard]] std::string Name() const;
  };

  [[nodiscard]] Heard Hear(const SimulatedTime& time, std::uint64_t session) const;
  void Apply(Heard heard);
  void Begin(Heard heard);
  void End();
  // Sets the clock. What a listener of its jumps throws is logged.
  void Set(const std::function<void()>& set);
  void Report(const Heard& other);

  const std::shared_ptr<FollowingClock> clock_;
  const std::shared_ptr<Log> log_;
  const std::string boot_id_;

  std::mutex mutex_;
  std::optional<Heard> followed_;  // guarded by mutex_, as all below
  std::optional<Heard> rival_;
  bool heard_any_ = false;
  // The session that was followed last and is gone. Its messages are late ones and are ignored, unless the session is
  // reported as back: then the latest of them, early_, counts.
  std::uint64_t gone_ = 0;
  std::optional<Heard> early_;
};

}  // namespace hgros
