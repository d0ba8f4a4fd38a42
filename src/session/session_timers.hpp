#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "hgros/base/log.hpp"
#include "hgros/base/reserved_names.hpp"
#include "hgros/clock/timer_queue.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/session/node_timer.hpp"

namespace hgros {

// The timers of one session: one thread that fires them, started with the first timer, and a channel and a node for
// each timer.
//
// Thread safety: all functions.
class SessionTimers {
 public:
  SessionTimers(std::shared_ptr<Clock> clock, DataGraph& graph, std::shared_ptr<Log> log);

  NodeTimer Create(std::string_view name, Duration period, TimerCallback callback, NodeTimerOptions options);
  // Waits until every timer that is due by now has fired. Returns when the next one is due; Time::Never() without one.
  Time Settle();
  // Stops all timers. Waits for a running inline callback.
  void Stop();

 private:
  // Reserves the name until the result is destroyed. Throws Error if a timer has that name.
  [[nodiscard]] std::shared_ptr<const void> ReserveName(std::string_view name);
  [[nodiscard]] Timer Fire(Duration period, TimerCallback fire, const TimerOptions& options);

  const std::shared_ptr<Clock> clock_;
  DataGraph& graph_;
  const std::shared_ptr<Log> log_;
  ReservedNames names_;

  std::mutex mutex_;
  std::unique_ptr<TimerQueue> queue_;  // guarded by mutex_, as all below
  bool stopped_ = false;
};

}  // namespace hgros
