#include "tracing/traced.hpp"

#include <algorithm>
#include <mutex>
#include <set>
#include <utility>

#include "hgros/session/trace_message.hpp"
#include "robot/overview.hpp"
#include "robot/robot.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"
#include "terminal/progress.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kMostEvents = 500'000;     // Some hundred MB, also as JSON.
constexpr std::size_t kMostBytes = 100'000'000;  // As sent.
constexpr std::size_t kMostNameBytes = 256;      // Each event has its own copy.
constexpr std::chrono::seconds kTraceAnswerTime{1};
constexpr std::chrono::milliseconds kLastBatch{200};  // Sessions tell ten times a second.
constexpr std::chrono::seconds kClockTime{3};         // Clocks are compared once per heartbeat.
constexpr std::chrono::seconds kOldest{10};           // What was published this long before may still lead to messages.

// Peers may send any numbers.
std::int64_t Sum(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}

// What a channel carries that belongs to services, such as "locate (request)"; empty for others.
std::string ServiceChannelText(std::string_view channel) {
  if (const std::string_view service = ServiceOf(channel); !service.empty()) return std::string(service) + " (request)";
  constexpr std::string_view kTurns = "hgros/serve/";
  if (channel.starts_with(kTurns)) return std::string(channel.substr(kTurns.size())) + " (handler)";
  constexpr std::string_view kReplies = "hgros/reply/";  // Followed by the caller's session and the service.
  if (channel.starts_with(kReplies)) {
    const std::size_t slash = channel.find('/', kReplies.size());
    if (slash != std::string_view::npos) return std::string(channel.substr(slash + 1)) + " (reply)";
  }
  return channel == "hgros/answers" ? "replies (callback)" : std::string();
}

class Assembly {
 public:
  explicit Assembly(const std::map<SessionId, ClockOffset>& clocks) : clocks_(clocks) {}

  void Add(SessionId from, const Trace& trace) {
    const std::size_t session = IndexOf(from, trace);
    // From the clock of intervals there to our wall clock.
    const std::int64_t shift = Difference(Difference(trace.time_ns(), trace.steady_ns()), OffsetOf(from));
    static const std::string none;
    const auto name = [&trace](std::uint32_t index) -> const std::string& {  // Not a copy: a name may be very long.
      return index < static_cast<std::uint32_t>(trace.names_size()) ? trace.names(static_cast<int>(index)) : none;
    };
    result_.lost += trace.lost();
    for (const Trace::Publish& event : trace.publishes()) {
      if (!Takes(name(event.channel()), name(event.node()))) continue;
      if (!published_.insert(event.message()).second) {
        ++result_.lost;
        continue;
      }
      result_.publishes.push_back({session, Text(name(event.channel())), Text(name(event.node())), event.thread(),
                                   event.message(), event.cause(), Sum(event.at_ns(), shift)});
    }
    for (const Trace::Run& event : trace.runs()) {
      if (event.end_ns() < event.start_ns() || event.start_ns() < event.received_ns()) continue;
      if (!Takes(name(event.channel()), name(event.node()))) continue;
      Traced::Run& run = result_.runs.emplace_back();
      run.session = session;
      run.channel = Text(name(event.channel()));
      run.node = Text(name(event.node()));
      run.thread = event.thread();
      run.message = event.message();
      if (event.sent_ns() != 0) run.sent_ns = Difference(event.sent_ns(), OffsetOf(SessionId{event.publisher()}));
      run.received_ns = Sum(event.received_ns(), shift);
      run.start_ns = Sum(event.start_ns(), shift);
      run.end_ns = Sum(event.end_ns(), shift);
    }
  }
  [[nodiscard]] Traced Take() { return std::move(result_); }

 private:
  [[nodiscard]] bool Takes(const std::string& channel, const std::string& node) {
    if (IsInternal(channel) && ServiceChannelText(channel).empty()) return false;
    const bool fits = channel.size() <= kMostNameBytes && node.size() <= kMostNameBytes;
    if (fits && result_.publishes.size() + result_.runs.size() < kMostEvents) return true;
    ++result_.lost;
    return false;
  }
  // The library's nodes on channels of services have the channels' names.
  [[nodiscard]] static std::string Text(const std::string& name) {
    std::string text = ServiceChannelText(name);
    return text.empty() ? name : text;
  }
  [[nodiscard]] std::int64_t OffsetOf(SessionId session) const {
    const auto clock = clocks_.find(session);
    return clock == clocks_.end() ? 0 : clock->second.offset.count();
  }
  [[nodiscard]] std::size_t IndexOf(SessionId id, const Trace& trace) {
    const auto [entry, is_new] = indexes_.try_emplace(id, result_.sessions.size());
    if (is_new) {
      const auto clock = clocks_.find(id);
      result_.sessions.push_back({id, trace.process(), trace.host(), trace.pid(),
                                  clock == clocks_.end() ? std::nullopt : std::optional(clock->second)});
    }
    return entry->second;
  }

  const std::map<SessionId, ClockOffset>& clocks_;
  std::map<SessionId, std::size_t> indexes_;
  std::set<std::uint64_t> published_;  // Ordered: peers choose the keys, and could make hashes collide.
  Traced result_;
};

// The messages that arrive while it lives.
class Arriving {
 public:
  explicit Arriving(Robot& robot)
      : pause_(robot.surroundings().pause),
        subscription_(robot.session().FromAny<Trace>(
            kTraceChannel, Invoke::kSerial,
            [this](const std::shared_ptr<const Trace>& trace, const MessageInfo& info) {
              const std::scoped_lock lock(mutex_);
              const SessionId from{info.id.publisher};
              if (answered_.insert(from).second) pause_.Wake();
              const std::size_t events =
                  static_cast<std::size_t>(trace->publishes_size()) + static_cast<std::size_t>(trace->runs_size());
              const std::size_t bytes = trace->ByteSizeLong();
              if (events_ + events > 2 * kMostEvents || bytes_ + bytes > kMostBytes) {
                lost_ += events;
                return;
              }
              events_ += events;
              bytes_ += bytes;
              messages_.emplace_back(from, trace);
            },
            {.queue = Queue::KeepLast(1000), .executor = Executor::Inline()})) {}

  [[nodiscard]] bool Answered(SessionId session) const {
    const std::scoped_lock lock(mutex_);
    return answered_.contains(session);
  }
  // What has come since the last call, and how many events were too many.
  [[nodiscard]] std::pair<std::vector<TraceMessage>, std::uint64_t> Take() {
    const std::scoped_lock lock(mutex_);
    events_ = 0;
    bytes_ = 0;
    return {std::exchange(messages_, {}), std::exchange(lost_, 0)};
  }

 private:
  Pause& pause_;
  mutable std::mutex mutex_;
  std::set<SessionId> answered_;
  std::size_t events_ = 0;  // In messages_, as the next.
  std::size_t bytes_ = 0;
  std::uint64_t lost_ = 0;
  std::vector<TraceMessage> messages_;
  Subscription subscription_;  // Ends first.
};

std::map<SessionId, ChannelUser> Traceable(const Robot& robot) {
  std::map<SessionId, ChannelUser> sessions;
  for (const KnownChannel& channel : robot.Channels(true)) {
    if (channel.name != kTraceChannel) continue;
    for (const ChannelUser& user : channel.publishers) sessions.emplace(user.session, user);
  }
  return sessions;
}

}  // namespace

Traced Assemble(std::span<const TraceMessage> messages, const std::map<SessionId, ClockOffset>& clocks) {
  Assembly assembly(clocks);
  for (const auto& [from, trace] : messages) assembly.Add(from, *trace);
  return assembly.Take();
}

std::optional<Traced> Watch(Robot& robot, std::chrono::nanoseconds time, std::chrono::nanoseconds timeout) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point latest = Clock::now() + timeout;
  const auto too_long = [&robot] {
    robot.surroundings().console.Say("This takes longer than --timeout allows.");
    return std::nullopt;
  };
  (void)robot.Counters();  // Afterwards all sessions are known.
  const std::map<SessionId, ChannelUser> sessions = Traceable(robot);
  Pause& pause = robot.surroundings().pause;
  Arriving arriving(robot);
  const auto all = [&](const auto& holds) { return std::ranges::all_of(sessions, holds); };
  const auto await = [&](Clock::time_point deadline, const auto& holds) {
    while (!all(holds) && Clock::now() < std::min(deadline, latest)) {
      const auto soon = std::min(std::min(deadline, latest), Clock::now() + std::chrono::milliseconds(20));
      if (pause.Until(soon) == Pause::End::kInterrupted) throw OutputClosed();
    }
  };
  const auto answered = [&](const auto& one) { return arriving.Answered(one.first); };
  await(Clock::now() + kTraceAnswerTime, answered);
  if (Clock::now() >= latest) return too_long();
  for (const auto& [id, user] : sessions) {
    if (arriving.Answered(id)) continue;
    robot.surroundings().console.Say("Session " + Visible(SessionName(user.process, user.pid, user.host)) +
                                     " does not answer; what it does is missing.");
  }
  await(Clock::now() + kClockTime, [&](const auto& one) {
    return !arriving.Answered(one.first) || robot.session().OffsetTo(one.first).has_value();
  });
  (void)arriving.Take();  // From here on all sessions record.
  const Progress progress(robot.surroundings().console, pause, "recording", time);
  const std::int64_t begin_ns = WallNow().nanoseconds;
  const auto wait_until = [&pause](Clock::time_point end) {
    while (Clock::now() < end && pause.Until(end) != Pause::End::kInterrupted) {
    }
  };
  wait_until(std::min(Clock::now() + time, latest));
  if (Clock::now() >= latest) return too_long();
  const std::int64_t end_ns = WallNow().nanoseconds;
  wait_until(Clock::now() + kLastBatch);
  std::map<SessionId, ClockOffset> clocks;
  for (const auto& [id, user] : sessions) {
    if (const auto clock = robot.session().OffsetTo(id)) clocks.emplace(id, *clock);
  }
  const auto [messages, lost] = arriving.Take();
  Traced traced = Assemble(messages, clocks);
  traced.lost += lost;
  std::erase_if(traced.runs, [&](const Traced::Run& run) { return run.start_ns < begin_ns || run.start_ns > end_ns; });
  std::erase_if(traced.publishes, [&](const Traced::Publish& one) {
    return one.at_ns > end_ns || one.at_ns < begin_ns - std::chrono::nanoseconds(kOldest).count();
  });
  return traced;
}

std::vector<std::string> DescribeClocks(const Traced& traced, bool exact) {
  std::map<std::string, std::string> by_host;
  for (const Traced::Session& session : traced.sessions) {
    if (session.clock && session.clock->offset.count() == 0 && session.clock->uncertainty.count() == 0) continue;
    const std::string host = Visible(session.host);
    by_host[host] = session.clock ? "The clock of " + host + " is ahead by " +
                                        DurationText(session.clock->offset.count(), exact) + ", known to " +
                                        DurationText(session.clock->uncertainty.count(), exact) + "; corrected."
                                  : "The clock of " + host + " could not be compared; it is taken as right.";
  }
  std::vector<std::string> lines;
  for (auto& [host, line] : by_host) lines.push_back(std::move(line));
  return lines;
}

}  // namespace hgros::cli
