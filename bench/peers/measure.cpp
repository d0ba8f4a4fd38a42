// The measurement, the same for every peer. Results go to standard output, one per line:
//   latency,LANE,SENT,NS NS NS ...      one-way latencies of the timed messages that arrived; with several receivers
//                                       until the last receiver had the message
//   flood,LANE,SENT,RECEIVED,SECONDS    from the first publish to the last arrival
//   silent,LANE                         no message of this size arrives at all
//   damaged,COUNT                       messages whose contents differed from what was sent, over all lanes
#include <sys/prctl.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <thread>

#include "buffers.hpp"
#include "peer.hpp"
#include "stamp.hpp"

namespace hgros::bench {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kStartLimitNs = 10'000 * kMs;
constexpr std::int64_t kSilentAfterNs = 4'000 * kMs;
constexpr std::int64_t kLostAfterNs = 250 * kMs;  // Plus several times the line's time.
constexpr std::int64_t kProbeEveryNs = 10 * kMs;
constexpr int kLossesInARow = 4;  // After these the lane is given up: nothing arrives at this size.

class Sending {
 public:
  Sending(const Task& task, const Lane& lane, Control& control, Outlet& outlet)
      : receivers_(task.receivers),
        lane_(lane),
        control_(control),
        outlet_(outlet),
        transit_ns_(std::int64_t{1000} * lane.transit_us),
        lost_after_ns_(kLostAfterNs + 4 * transit_ns_),
        pattern_(FilledBuffer(lane.size_bytes)) {}

  /// Sends probes until one has arrived at every receiver, then waits for those in flight. False if none arrives.
  bool AwaitWay() {
    const std::int64_t deadline = NowNs() + (lane_.index == 0 ? kStartLimitNs : kSilentAfterNs) + 4 * transit_ns_;
    const std::uint32_t wanted = control_.probed.Get() + receivers_;
    std::uint64_t sent = 0;
    for (std::int64_t patience_ns = 0; !control_.probed.AwaitAtLeast(wanted, patience_ns);) {
      if (NowNs() > deadline) {
        std::printf("silent,%u\n", lane_.index);
        return false;
      }
      const bool gone = Send(Phase::kProbe, sent);
      sent += gone ? 1 : 0;
      patience_ns = kProbeEveryNs + (gone ? 2 * transit_ns_ : 0);
    }
    const std::int64_t underway_ns = sent > 1 ? 2 * transit_ns_ : 0;
    std::this_thread::sleep_for(std::chrono::nanoseconds(20 * kMs + underway_ns));
    return true;
  }

  void Time() {
    for (int i = 0; i < lane_.timed; ++i) control_.latency_ns[static_cast<std::size_t>(i)] = 0;
    int lost_in_a_row = 0;
    int sent = 0;
    for (int i = -lane_.warm_up; i < lane_.timed && lost_in_a_row < kLossesInARow; ++i) {
      std::this_thread::sleep_for(std::chrono::microseconds(lane_.pause_us));
      const std::uint32_t arrived = control_.timed.Get();
      // Warm-up messages fall into slots that are not read.
      if (Send(Phase::kTimed, i < 0 ? Control::kTimed - 1 : static_cast<std::uint64_t>(i))) sent += i >= 0 ? 1 : 0;
      const bool here = control_.timed.AwaitAtLeast(arrived + receivers_, lost_after_ns_);
      lost_in_a_row = here ? 0 : lost_in_a_row + 1;
      // A message that only some receivers got counts as lost.
      if (!here && i >= 0) control_.latency_ns[static_cast<std::size_t>(i)] = kLost;
    }
    std::printf("latency,%u,%d,", lane_.index, sent);
    for (int i = 0; i < lane_.timed; ++i) {
      const std::int64_t latency = control_.latency_ns[static_cast<std::size_t>(i)];
      if (latency > 0 && latency != kLost) std::printf("%lld ", static_cast<long long>(latency));
    }
    std::printf("\n");
  }

  void Flood() {
    control_.flooded = 0;
    std::uint64_t sent = 0;
    const std::int64_t start = NowNs();
    const std::int64_t end = start + lane_.flood_ms * kMs;
    while (NowNs() < end) {
      if (Send(Phase::kFlood, sent)) ++sent;
    }
    std::uint64_t seen = 0;
    for (std::int64_t since = NowNs();
         (seen = control_.flooded) < sent * receivers_ && NowNs() - since < lost_after_ns_;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      if (control_.flooded != seen) since = NowNs();
    }
    const std::int64_t last = seen > 0 ? control_.last_flooded_ns.load() : start;
    std::printf("flood,%u,%llu,%llu,%.9f\n", lane_.index, static_cast<unsigned long long>(sent),
                static_cast<unsigned long long>(seen / receivers_), static_cast<double>(last - start) / 1e9);
  }

 private:
  bool Send(Phase phase, std::uint64_t index) {
    std::byte* bytes = outlet_.Take();
    if (bytes == nullptr) return false;
    // Filling stands for the program that produces the data, and is not timed.
    if (outlet_.lends() && phase != Phase::kFlood) std::memcpy(bytes, pattern_.data(), lane_.size_bytes);
    WriteStamp(bytes, lane_.size_bytes, {0, index, lane_.index, phase});
    return outlet_.Publish();
  }

  /// Larger than any latency, so that a late arrival does not change it.
  static constexpr std::int64_t kLost = INT64_MAX;

  const std::uint32_t receivers_;
  const Lane& lane_;
  Control& control_;
  Outlet& outlet_;
  const std::int64_t transit_ns_;
  const std::int64_t lost_after_ns_;
  const std::vector<std::byte> pattern_;
};

/// Counts a lane that is not measured, so that both sides go on to the next.
void SkipLane(const Task& task, Control& control) {
  if (task.role != Task::Role::kPublish) control.subscribed.Add(1);
  if (task.role == Task::Role::kSubscribe) return;
  control.finished.Add(1);
}

void RunLane(const Task& task, Peer& peer, const Lane& lane, Control& control) {
  Sink sink(lane, control);
  std::unique_ptr<Inlet> inlet;
  if (task.role != Task::Role::kPublish) {
    inlet = peer.Subscribe(lane, sink);
    control.subscribed.Add(1);
  }
  if (task.role == Task::Role::kSubscribe) {
    if (!control.finished.AwaitAtLeast(lane.index + 1, 60'000 * kMs)) Fail("the sender did not finish within 60 s");
    return;
  }
  if (!control.subscribed.AwaitAtLeast((lane.index + 1) * task.receivers, kStartLimitNs))
    Fail("the receiver did not start within 10 s");
  const std::unique_ptr<Outlet> outlet = peer.Publish(lane);
  Sending sending(task, lane, control, *outlet);
  if (sending.AwaitWay()) {
    if (lane.timed > 0) sending.Time();
    if (lane.flood_ms > 0) sending.Flood();
  }
  std::fflush(stdout);
  control.finished.Add(1);
  // The receiver ends first, so that no sender disconnects while a receiver still counts.
  if (task.role == Task::Role::kBoth) inlet.reset();
}

int Run(int argc, char** argv) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const Task task = Task::Parse(argc, argv);
  Control& control = OpenControl(task);
  const std::unique_ptr<Peer> peer = MakePeer(task);
  for (const Lane& lane : task.lanes) {
    if (lane.timed == 0 && lane.flood_ms == 0) {
      SkipLane(task, control);
    } else {
      RunLane(task, *peer, lane, control);
    }
  }
  if (task.role != Task::Role::kSubscribe) {
    std::printf("damaged,%llu\n", static_cast<unsigned long long>(control.damaged.load()));
  }
  return 0;
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) { return hgros::bench::Run(argc, argv); }
