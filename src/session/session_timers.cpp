#include "session/session_timers.hpp"

#include <atomic>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros {
namespace {

constexpr std::size_t kCatchUpDepth = 1024;

// The message on a timer's channel.
struct TimerTurn {
  Tick tick;
  std::uint64_t number = 0;  // Counts the planned turns from 1; a gap means dropped turns.
  std::uint64_t timer = 0;   // Tells a timer from an earlier one of the same name.
};

std::uint64_t NextTimer() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

NodeOptions NodeOptionsOf(std::string_view name, const NodeTimerOptions& options) {
  if (options.executor.kind() == Executor::Kind::kPolled) {
    throw Error("Timer \"" + std::string(name) + "\" cannot be polled: nobody would run its callback.", {},
                "Choose another executor; Executor::Polled() is for subscriptions.");
  }
  const Queue by_policy = options.missed == Missed::kCatchUp ? Queue::KeepLast(kCatchUpDepth) : Queue::Latest();
  return {std::string(name), options.queue.value_or(by_policy), options.executor};
}

}  // namespace

SessionTimers::SessionTimers(std::shared_ptr<Clock> clock, DataGraph& graph, std::shared_ptr<Log> log)
    : clock_(std::move(clock)), graph_(graph), log_(std::move(log)) {}

std::shared_ptr<const void> SessionTimers::ReserveName(std::string_view name) {
  if (name.empty()) throw Error("A timer needs a name.", {}, "Name it after what it does, as in \"control\".");
  if (auto reserved = names_.TryReserve(name)) return reserved;
  throw Error("The session already has a timer \"" + std::string(name) + "\".", {},
              "End that one first, or give this one another name.");
}

Timer SessionTimers::Fire(Duration period, TimerCallback fire, const TimerOptions& options) {
  const std::scoped_lock lock(mutex_);
  if (stopped_) throw Error("The session is shutting down; it takes no new timers.");
  if (!queue_) {
    queue_ = std::make_unique<TimerQueue>(
        clock_, [log = log_](LogLevel level, std::string_view text) { log->Write(level, text); });
  }
  return queue_->Every(period, std::move(fire), options);
}

NodeTimer SessionTimers::Create(std::string_view name, Duration period, TimerCallback callback,
                                NodeTimerOptions options) {
  auto taken = ReserveName(name);
  const std::string channel = "timer/" + std::string(name);
  const auto publish = graph_.Advertise<TimerTurn>(channel);
  const std::uint64_t timer = NextTimer();
  Subscription node = graph_.FromGraph<TimerTurn>(
      channel, Invoke::kSerial,
      [timer, callback = std::move(callback), last = std::uint64_t{0}](const TimerTurn& turn) mutable {
        if (turn.timer != timer) return;
        Tick tick = turn.tick;
        tick.missed = turn.number - last - 1;
        last = turn.number;
        callback(tick);
      },
      NodeOptionsOf(name, options));
  // waits_at_end = false: a turn that still fires when the timer ends finds no node, so there is nothing to wait for.
  Timer firing = Fire(period,
                      [publish, timer, number = std::uint64_t{0}](const Tick& tick) mutable {
                        number += tick.missed + 1;
                        (void)publish(std::make_unique<TimerTurn>(TimerTurn{tick, number, timer}));
                      },
                      {.missed = options.missed, .first = options.first, .waits_at_end = false});
  return {std::move(firing), std::move(node), std::move(taken)};
}

Time SessionTimers::Settle() {
  TimerQueue* queue = nullptr;  // Stays until Stop().
  {
    const std::scoped_lock lock(mutex_);
    queue = queue_.get();
  }
  if (queue == nullptr) return Time::Never();
  queue->Settle();
  return queue->next();
}

void SessionTimers::Stop() {
  std::unique_ptr<TimerQueue> queue;  // Destroyed outside the lock: it waits for callbacks, which may create timers.
  {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
    queue = std::move(queue_);
  }
}

bool NodeTimer::Join() {
  firing_.Reset();
  const bool joined = node_.Join();
  if (joined) name_.reset();
  return joined;
}

void NodeTimer::Reset() {
  firing_.Reset();
  node_.Reset();
  name_.reset();
}

}  // namespace hgros
