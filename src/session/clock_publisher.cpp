#include "hgros/session/clock_publisher.hpp"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include <hgros/SimulatedTime.pb.h>

#include "hgros/base/fork_guard.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/base/system_limits.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros {
namespace {

constexpr auto kTellingPeriod = std::chrono::milliseconds(100);

}  // namespace

class ClockPublisher::Core {
 public:
  const ForkGuard fork;  // A child has none of the threads.
  Core(Session& session, std::shared_ptr<SimulatedClock> clock)
      : clock_(std::move(clock)), publish_(session.Advertise<SimulatedTime>(kClockChannel, {.latched = 1})) {
    always_.set_clock_id(RandomId());
    const Announcement here = AnnouncementOfThisProcess(session.id(), 0);
    always_.set_publisher(session.NameOf(session.id()) + "@" + here.host);
    always_.set_boot_id(here.boot_id);
    listening_ = clock_->OnChange([this] {
      {
        const std::scoped_lock lock(mutex_);
        changed_ = true;
      }
      woken_.notify_one();
    });
    thread_ = StartThread<std::jthread>("the thread that publishes the clock",
                                        [this](const std::stop_token& stop) { Loop(stop); });
  }
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;
  ~Core() {
    listening_.Reset();
    thread_.request_stop();
    thread_.join();
    Say(true, {});
  }

 private:
  void Loop(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      changed_ = false;
      lock.unlock();
      const bool paused = Say(false, stop);
      lock.lock();
      const auto changed = [this] { return changed_; };
      if (paused) {
        woken_.wait(lock, stop, changed);
      } else {
        woken_.wait_for(lock, stop, kTellingPeriod, changed);
      }
    }
  }

  // Publishes the clock's state and returns true if the clock is paused. Waits for a limited time if a lossless
  // subscriber has no room; the next turn then publishes the newer state.
  bool Say(bool ended, const std::stop_token& stop) {
    const std::int64_t steady = MonotonicNow();
    const ClockState state = clock_->State();
    auto time = std::make_unique<SimulatedTime>(always_);
    time->set_time_ns(state.reading.now.nanoseconds);
    time->set_jumped_ns(state.reading.jumped.count());
    time->set_rate(state.rate);
    time->set_paused(state.paused || ended);
    time->set_ended(ended);
    time->set_steady_ns(steady);
    const auto deadline = std::chrono::steady_clock::now() + kTellingPeriod;
    const bool said = publish_.Wait(std::move(time), deadline, stop) != PublishStatus::kTimedOut;
    if (!said) {
      const std::scoped_lock lock(mutex_);
      changed_ = true;
    }
    return state.paused;
  }

  const std::shared_ptr<SimulatedClock> clock_;
  const Publisher<SimulatedTime> publish_;
  SimulatedTime always_;  // The fields that are equal in all messages.

  std::mutex mutex_;
  std::condition_variable_any woken_;
  bool changed_ = false;  // guarded by mutex_
  Listening listening_;
  std::jthread thread_;  // last: it uses the rest
};

ClockPublisher::ClockPublisher(Session& session, std::shared_ptr<SimulatedClock> clock)
    : core_(std::make_unique<Core>(session, std::move(clock))) {}
ClockPublisher::~ClockPublisher() {
  if (core_->fork.IsChild()) LeaveToParent(std::shared_ptr<const Core>(std::move(core_)));
}

}  // namespace hgros
