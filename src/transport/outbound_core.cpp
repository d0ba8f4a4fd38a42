#include "transport/outbound_core.hpp"

#include <algorithm>
#include <utility>

#include "transport/peer_channel.hpp"

namespace hgros {
namespace {

constexpr std::size_t kMostLosers = 64;  // Most sessions never come back.
constexpr auto kRepeatsWithin = std::chrono::seconds(10);

}  // namespace

void OutboundCore::CountSubscriber(const std::shared_ptr<OutboundCore>& core, SessionId who, int change,
                                   Actions& actions) {
  {
    const std::scoped_lock lock(core->count_mutex_);
    auto& sessions = core->sessions_;
    if (who == SessionId{}) {
      core->plain_endpoints_ += change;
    } else if (change > 0) {
      sessions.push_back(who);
      for (Loser& loser : core->losers_) {
        if (loser.session != who || loser.state != Loser::State::kGone) continue;
        loser.state = Loser::State::kBack;
        core->some_are_back_.store(true, std::memory_order_relaxed);
      }
    } else if (const auto place = std::ranges::find(sessions, who); place != sessions.end()) {
      sessions.erase(place);
    }
    core->subscribers.store(sessions.size() + (core->plain_endpoints_ > 0 ? 1 : 0));
  }
  actions.emplace_back([core] { core->gate.Through([&] { core->source.OnSubscribers(core->subscribers.load()); }); });
}

void OutboundCore::TellUnsubscribed(const std::shared_ptr<OutboundCore>& core, SessionId who, Actions& actions) {
  actions.emplace_back([core, who] { core->gate.Through([&] { core->source.OnUnsubscribed(who); }); });
}

void OutboundCore::TellRoom(const std::shared_ptr<OutboundCore>& core, Actions& actions) {
  if (!core->refused.load()) return;
  actions.emplace_back([core] { core->gate.Through([&] { core->source.OnRoom(); }); });
  core->refused.store(false);  // Last: without memory for the action, the next call reports the room.
}

void OutboundCore::SayHeldUp(Log& log, const std::string& who) const {
  log.WriteLimited(
      LogLevel::kWarning, "held up " + name + " " + who,
      "Channel \"" + name + "\" waits for " + who +
          ": its lossless subscription is full, and it has taken "
          "no message for " +
          std::to_string(PeerChannel::kHoldsUpAfter.count()) +
          " s. Other subscribers get none meanwhile. Look at its callback, or let it subscribe keep-last.");
}

void OutboundCore::TellMissed(const std::shared_ptr<OutboundCore>& core, Log& log, SessionId session,
                              const std::string& who, std::uint64_t messages, Actions& actions) {
  if (messages == 0) return;
  core->missed.fetch_add(messages, std::memory_order_relaxed);
  Loser lost{session, who};
  lost.messages = messages;
  lost.sequence = core->last_sequence_.load(std::memory_order_relaxed);
  {
    const std::scoped_lock lock(core->count_mutex_);
    auto& losers = core->losers_;
    if (const auto known = std::ranges::find(losers, session, &Loser::session); known != losers.end()) {
      if (known->state == Loser::State::kReported) {
        lost.repeats = std::chrono::steady_clock::now() - known->reported < kRepeatsWithin;
      } else {  // It was back for so short a time that no message came: the whole time is reported at once.
        lost.messages += known->messages;
        lost.sequence = std::min(lost.sequence, known->sequence);
        lost.repeats = known->repeats;
      }
      losers.erase(known);
    }
    if (losers.size() >= kMostLosers) losers.erase(losers.begin());
    losers.push_back(lost);
  }
  std::string text = lost.repeats ? who + " misses messages of the lossless channel \"" + core->name +
                                        "\" again and again. OutboundStats::missed counts them."
                                  : who + " has gone without confirming " + std::to_string(messages) +
                                        " messages of the lossless channel \"" + core->name +
                                        "\". It may miss these, and misses those that are published until it is back.";
  actions.emplace_back(
      [core, &log, text = std::move(text)] { log.WriteLimited(LogLevel::kWarning, "missed " + core->name, text); });
}

void OutboundCore::ReportThoseBack(Log& log, std::uint64_t sequence) {
  std::vector<std::string> lines;
  {
    const std::scoped_lock lock(count_mutex_);
    some_are_back_.store(false, std::memory_order_relaxed);
    for (Loser& loser : losers_) {
      if (loser.state != Loser::State::kBack) continue;
      loser.state = Loser::State::kReported;
      const std::uint64_t since = sequence > loser.sequence ? sequence - loser.sequence - 1 : 0;
      missed.fetch_add(since, std::memory_order_relaxed);
      loser.reported = std::chrono::steady_clock::now();
      if (loser.repeats) continue;
      lines.push_back(loser.name + " has missed up to " + std::to_string(loser.messages + since) +
                      " messages of the lossless channel \"" + name + "\", and is back.");
    }
  }
  for (const std::string& line : lines) log.WriteLimited(LogLevel::kWarning, "back " + name, line);
}

std::vector<SessionId> OutboundCore::Sessions() const {
  const std::scoped_lock lock(count_mutex_);
  return sessions_;
}

OutboundStats OutboundCore::stats() const {
  return {.subscribers = subscribers.load(),
          .sent = sent.load(),
          .dropped = dropped.load(),
          .missed = missed.load(),
          .queued_bytes = queued_bytes.load(),
          .copied = copied.load()};
}

}  // namespace hgros
