#include "session/clock_follower.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "hgros/base/forced_unwind.hpp"
#include "hgros/base/readable_text.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/discovery/announcement.hpp"
#include "hgros/session/clock_publisher.hpp"

namespace hgros {
namespace {

constexpr std::int64_t kFarthest = std::int64_t{1} << 62U;  // The difference of two such times does not overflow.
constexpr std::int64_t kLongestTransitNs = 10'000'000'000;
// A running clock is published ten times per second; after this silence another one is followed.
constexpr std::int64_t kSilenceNs = 2'000'000'000;
// A simulation that starts together with the session has published its clock by then.
constexpr auto kTimeForAClock = std::chrono::seconds(5);

std::string Seconds(Duration time) { return std::to_string(std::chrono::duration<double>(time).count()) + " s"; }

bool IsGood(const SimulatedTime& time) {
  const auto near = [](std::int64_t ns) { return ns > -kFarthest && ns < kFarthest; };
  return near(time.time_ns()) && near(time.jumped_ns()) && time.rate() > 0 && time.rate() <= SimulatedClock::kMostRate;
}

}  // namespace

std::vector<Subscription> ClockFollower::Follow(const std::shared_ptr<FollowingClock>& clock, DataGraph& graph,
                                                const std::shared_ptr<Log>& log, ErrandThread& errands,
                                                const Subscribe& subscribe) {
  const auto follower = std::make_shared<ClockFollower>(clock, log);
  errands.PostIn(kTimeForAClock, [follower] { follower->SayIfNoneWasHeard(); });
  std::vector<Subscription> subscriptions;
  NodeOptions options{"hgros/clock", {}, Executor::Inline()};
  const TypeInfo& type = TypeOf<SimulatedTime>();
  subscriptions.push_back(
      subscribe(graph.Open(kClockChannel, type, CallSite::Current()), type,
                EraseCallback<SimulatedTime>(
                    [follower](const SimulatedTime& time, const MessageInfo& info) { follower->OnTime(time, info); }),
                options));
  options.name = "hgros/clock peers";
  subscriptions.push_back(graph.FromGraph<PeerEvent>(
      kPeerEventsChannel, Invoke::kSerial, [follower](const PeerEvent& event) { follower->OnPeer(event); }, options));
  return subscriptions;
}

ClockFollower::ClockFollower(std::shared_ptr<FollowingClock> clock, std::shared_ptr<Log> log)
    : clock_(std::move(clock)), log_(std::move(log)), boot_id_(AnnouncementOfThisProcess({}, 0).boot_id) {}

std::string ClockFollower::Heard::Name() const { return Readable(publisher, 128); }

// On the same host the transit time of the message is known. From other hosts it is taken as zero.
ClockFollower::Heard ClockFollower::Hear(const SimulatedTime& time, std::uint64_t session) const {
  Heard heard{session, time.clock_id(), time.publisher(), {}, MonotonicNow(), time.ended()};
  heard.state.reading = {Time{time.time_ns()}, Duration(time.jumped_ns())};
  heard.state.rate = time.rate();
  heard.state.paused = time.paused() || time.ended();
  const bool same_host = !boot_id_.empty() && time.boot_id() == boot_id_ && time.steady_ns() <= heard.at_ns &&
                         time.steady_ns() > heard.at_ns - kLongestTransitNs;
  if (same_host) heard.publisher.resize(std::min(heard.publisher.size(), heard.publisher.rfind('@')));
  heard.state.source = Time{same_host ? time.steady_ns() : heard.at_ns};
  return heard;
}

void ClockFollower::OnTime(const SimulatedTime& time, const MessageInfo& info) {
  if (!IsGood(time)) {
    log_->WriteLimited(LogLevel::kWarning, "clock",
                       "A message on the channel \"clock\" was ignored: its content cannot be a clock.");
    return;
  }
  const std::scoped_lock lock(mutex_);
  Heard heard = Hear(time, info.id.publisher);
  if (gone_ == 0 || heard.session != gone_) return Apply(std::move(heard));
  early_ = std::move(heard);
}

void ClockFollower::Apply(Heard heard) {
  const bool ended = heard.ended;
  if (followed_ && followed_->SameClock(heard)) {
    if (heard.state.reading.elapsed() < followed_->state.reading.elapsed()) {
      log_->WriteLimited(LogLevel::kWarning, "clock back",
                         "The clock that " + followed_->Name() + " publishes went back by " +
                             Seconds(followed_->state.reading.elapsed() - heard.state.reading.elapsed()) +
                             " without saying that it jumped. It is taken as a jump. Let it add its jumps to jumped_ns "
                             "(docs/wire-protocol.md).");
      Set([&] { clock_->FollowAnother(heard.state); });
    } else {
      Set([&] { clock_->Follow(heard.state); });
    }
    followed_ = std::move(heard);
    if (ended) End();
    return;
  }
  if (rival_ && ended && rival_->SameClock(heard)) rival_.reset();
  const bool silent = followed_ && !followed_->state.paused && heard.at_ns - followed_->at_ns > kSilenceNs;
  if (followed_ && !silent) {
    if (ended) return;
    Report(heard);
    rival_ = std::move(heard);
    return;
  }
  Begin(std::move(heard));
  if (ended) End();
}

void ClockFollower::OnPeer(const PeerEvent& event) {
  if (event.kind != PeerEvent::Kind::kCame && event.kind != PeerEvent::Kind::kGone) return;
  const std::scoped_lock lock(mutex_);
  const std::uint64_t session = event.peer.id.value;
  if (event.kind == PeerEvent::Kind::kCame) {
    if (gone_ != session) return;
    gone_ = 0;
    if (early_) Apply(*std::exchange(early_, std::nullopt));
    return;
  }
  if (gone_ == session) early_.reset();
  if (rival_ && rival_->session == session) rival_.reset();
  if (followed_ && followed_->session == session) {
    gone_ = session;
    early_.reset();
    log_->WriteLimited(LogLevel::kWarning, "clock stands",
                       "The clock stands still: " + followed_->Name() + ", which published it, is gone.");
    End();
  }
}

void ClockFollower::SayIfNoneWasHeard() {
  const std::scoped_lock lock(mutex_);
  if (heard_any_) return;
  log_->Write(
      LogLevel::kWarning,
      "No clock was heard on the channel \"clock\" so far, so the time of this session stands at 0 and its timers "
      "wait. Start the program that publishes the clock, or remove `time: simulated`.");
}

void ClockFollower::Set(const std::function<void()>& set) {
  constexpr const char* kWho = "A callback for jumps of the session's clock";
  const auto failed = [&](const char* what) {
    log_->WriteLimited(LogLevel::kError, "clock callback", std::string(kWho) + " threw: " + what + ".");
  };
  try {
    set();
  } catch (const std::exception& error) {
    failed(error.what());
  } catch (const ForcedUnwind&) {
    EndAfterForcedUnwind(*log_, kWho);
  } catch (...) {
    failed("something that is not a std::exception");
  }
}

void ClockFollower::Begin(Heard heard) {
  heard_any_ = true;
  followed_ = std::move(heard);
  Set([&] { clock_->FollowAnother(followed_->state); });
}

void ClockFollower::End() {
  followed_.reset();
  Set([&] { clock_->Pause(); });
  if (!rival_) return;
  Begin(*std::exchange(rival_, std::nullopt));
}

void ClockFollower::Report(const Heard& other) {
  log_->WriteLimited(LogLevel::kError, "two clocks",
                     "Two clocks are published on the channel \"clock\": by " + followed_->Name() +
                         ", which this session follows, and by " + other.Name() + ". End one of them.");
}

}  // namespace hgros
