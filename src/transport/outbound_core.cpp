#include "transport/outbound_core.hpp"

namespace hgros {

void OutboundCore::CountSubscriber(const std::shared_ptr<OutboundCore>& core, bool plain, int change,
                                   Actions& actions) {
  {
    const std::scoped_lock lock(core->count_mutex_);
    (plain ? core->plain_endpoints_ : core->peers_) += change;
    core->subscribers.store(static_cast<std::size_t>(core->peers_ + (core->plain_endpoints_ > 0 ? 1 : 0)));
  }
  actions.emplace_back([core] { core->gate.Through([&] { core->source.OnSubscribers(core->subscribers.load()); }); });
}

void OutboundCore::TellRoom(const std::shared_ptr<OutboundCore>& core, Actions& actions) {
  if (!core->refused.exchange(false)) return;
  actions.emplace_back([core] { core->gate.Through([&] { core->source.OnRoom(); }); });
}

OutboundChannel::Stats OutboundCore::stats() const {
  return {.subscribers = subscribers.load(),
          .sent = sent.load(),
          .dropped = dropped.load(),
          .missed = missed.load(),
          .queued_bytes = queued_bytes.load(),
          .copied = copied.load()};
}

}  // namespace hgros
