#include "transport/outbound_core.hpp"

#include <algorithm>

namespace hgros {

void OutboundCore::CountSubscriber(const std::shared_ptr<OutboundCore>& core, SessionId who, int change,
                                   Actions& actions) {
  {
    const std::scoped_lock lock(core->count_mutex_);
    auto& sessions = core->sessions_;
    if (who == SessionId{}) {
      core->plain_endpoints_ += change;
    } else if (change > 0) {
      sessions.push_back(who);
    } else if (const auto place = std::ranges::find(sessions, who); place != sessions.end()) {
      sessions.erase(place);
    }
    core->subscribers.store(sessions.size() + (core->plain_endpoints_ > 0 ? 1 : 0));
  }
  actions.emplace_back([core] { core->gate.Through([&] { core->source.OnSubscribers(core->subscribers.load()); }); });
}

void OutboundCore::TellRoom(const std::shared_ptr<OutboundCore>& core, Actions& actions) {
  if (!core->refused.exchange(false)) return;
  actions.emplace_back([core] { core->gate.Through([&] { core->source.OnRoom(); }); });
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
