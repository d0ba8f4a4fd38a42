// Callbacks that are too slow or keep others waiting, queues that are full, callbacks that fail.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "doctor/evidence.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {
namespace {

constexpr double kBusy = 0.9;  // Share of the time.
constexpr double kOften = 0.25;
constexpr std::int64_t kLongTurnNs = 5'000'000;
// For nodes that hand messages over, as those of Python do.
constexpr const char* kForPython =
    "Callbacks of a Python session take turns on one thread. Do less there: give long work to another thread or "
    "process, use fewer points, or take only the newest message (queue=hgros.KeepLast(1)).";

// What a node did between the two readings.
struct NodeWork {
  std::string name;  // "mapper:12 match"
  std::string channel;
  double seconds = 0;
  std::uint64_t received = 0;
  std::uint64_t dropped = 0;
  std::uint64_t run = 0;
  std::uint64_t failed = 0;
  double busy = 0;  // Share of the time in its callbacks; above 1 if several run at once.
  const Snapshot::Node* node = nullptr;
  const Snapshot::Node* before = nullptr;
};

void Check(const NodeWork& work, Findings& findings) {
  const Snapshot::Node& node = *work.node;
  const auto mean_ns = static_cast<std::int64_t>(std::min(work.busy, 1e6) * work.seconds * 1e9 /
                                                 static_cast<double>(std::max<std::uint64_t>(work.run, 1)));
  const double period_ns = work.received == 0 ? 0 : work.seconds * 1e9 / static_cast<double>(work.received);
  const bool slow = node.serial() && work.busy > kBusy && work.received > 0;
  // Its callbacks have not ended since the first look, or ever.
  const std::string taken = work.run > 0 ? fmt::format("its callback takes {}", DurationText(mean_ns, false))
                            : node.run() == 0
                                ? "its callback has never returned"
                                : fmt::format("its callback has not returned for {}",
                                              DurationText(static_cast<std::int64_t>(work.seconds * 1e9), false));
  const std::string how =
      fmt::format("{} and a message comes every {}", taken, DurationText(static_cast<std::int64_t>(period_ns), false));
  if (work.dropped > 0 && node.queue_depth() > 1) {  // A queue of one drops by design.
    findings.push_back(
        {Severity::kFault, "queue",
         fmt::format("{} drops {:.0f} of {:.0f} messages per second of \"{}\", because its queue of {} is full: {}.",
                     work.name, static_cast<double>(work.dropped) / work.seconds,
                     static_cast<double>(work.received) / work.seconds, work.channel, node.queue_depth(), how),
         node.handed_over() ? kForPython
         : slow             ? "Make the callback faster or the publisher slower. A larger queue only helps with bursts."
                            : "Give it a larger queue, or its executor more threads."});
  } else if (slow) {
    findings.push_back(
        {Severity::kWarning, "callback",
         fmt::format("{} is busy for {:.0f} % of the time: {}.", work.name, 100 * work.busy, how),
         node.handed_over()
             ? kForPython
             : "Make the callback faster, the publisher slower, or the node concurrent, before messages pile up."});
  } else if (node.queue_depth() > 1 && work.before != nullptr && node.queued() >= node.queue_depth() &&
             work.before->queued() >= work.before->queue_depth()) {
    findings.push_back(
        {Severity::kWarning, "queue",
         fmt::format("The queue of {} on \"{}\" is always full ({} messages): {}.", work.name, work.channel,
                     node.queue_depth(), how),
         node.handed_over() ? kForPython : "Make the callback faster; messages are as old as the queue is long."});
  }
  if (work.failed > 0) {
    findings.push_back({Severity::kFault, "callback",
                        fmt::format("The callback of {} on \"{}\" ends with exceptions ({} since the last look).",
                                    work.name, work.channel, work.failed),
                        "The log of its process has the text of the exception."});
  }
}

// A worker runs one callback at a time. `works` are the nodes of one session that share its workers.
void CheckTurns(const std::vector<NodeWork>& works, Findings& findings) {
  if (works.empty()) return;
  const NodeWork& longest = *std::ranges::max_element(works, {}, &NodeWork::busy);
  if (longest.busy < kOften || longest.run == 0) return;
  const auto turn_ns =
      static_cast<std::int64_t>(longest.busy * longest.seconds * 1e9 / static_cast<double>(longest.run));
  if (turn_ns < kLongTurnNs) return;
  const auto waits = [&](const NodeWork& work) {  // A queue of one drops what comes while it waits.
    const bool queued = work.before != nullptr && work.before->queued() > 0 && work.node->queued() > 0;
    return work.run > 0 && work.busy < longest.busy / 2 && (queued || work.dropped > work.run) &&
           work.node->wait_p99_ns() > turn_ns / 4;
  };
  const auto waiting = std::ranges::find_if(works, waits);
  if (waiting == works.end()) return;
  findings.push_back(
      {Severity::kWarning, "turns",
       fmt::format("{} waits for its turn, because {} keeps a worker of the session for {} at a time.", waiting->name,
                   longest.name, DurationText(turn_ns, false)),
       "Give the longer one `executor: dedicated`, or the session more workers: data_graph: {threads: N}."});
}

}  // namespace

void CheckNodes(const Evidence& evidence, Findings& findings) {
  for (const auto& [session, after] : evidence.after) {
    const double seconds = evidence.SecondsOf(session);
    if (seconds <= 0) continue;
    std::vector<NodeWork> on_workers;
    for (const Snapshot::Channel& channel : after->channels()) {
      const Snapshot::Channel* earlier = CountersOf(evidence.before, session, channel.name());
      std::map<std::string, std::size_t> places;
      for (const Snapshot::Node& node : channel.nodes()) {
        const Snapshot::Node* was = FindNode(earlier, node.name(), places[node.name()]++);
        if (was == nullptr) continue;
        NodeWork work{.name = evidence.NameOf(session) + " " + node.name(),
                      .channel = channel.name(),
                      .seconds = seconds,
                      .node = &node,
                      .before = was};
        work.received = Growth(was->received(), node.received());
        work.dropped = Growth(was->dropped(), node.dropped());
        work.run = Growth(was->run(), node.run());
        work.failed = Growth(was->failed(), node.failed());
        work.busy = static_cast<double>(Growth(was->run_sum_ns(), node.run_sum_ns())) / 1e9 / seconds;
        Check(work, findings);
        if (node.executor() == "tbb") on_workers.push_back(std::move(work));
      }
    }
    CheckTurns(on_workers, findings);
  }
}

}  // namespace hgros::cli
