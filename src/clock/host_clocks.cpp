#include "hgros/clock/host_clocks.hpp"

namespace hgros {
namespace {

// True for times from 1970 to 2116. Other times are not a wall clock. Within this range sums of differences do not
// overflow.
bool IsGood(Time time) { return time.nanoseconds >= 0 && time.nanoseconds < std::int64_t{1} << 62U; }

}  // namespace

void HostClocks::Add(SessionId peer, const ClockExchange& exchange) {
  if (!IsGood(exchange.received) || !IsGood(exchange.answered)) return;
  const std::scoped_lock lock(mutex_);
  Peer& known = peers_[peer];
  if (!known.estimator.Add(exchange)) return;
  known.latest = known.estimator.At(exchange.got).value_or(ClockOffset{});
  known.at = exchange.got;
  empty_.store(false, std::memory_order_relaxed);
}

void HostClocks::Forget(SessionId peer) {
  const std::scoped_lock lock(mutex_);
  peers_.erase(peer);
  empty_.store(peers_.empty(), std::memory_order_relaxed);
}

std::optional<ClockOffset> HostClocks::OffsetTo(SessionId peer) const {
  const Time now = Now();
  const std::scoped_lock lock(mutex_);
  const auto known = peers_.find(peer);
  return known == peers_.end() ? std::nullopt : known->second.estimator.At(now);
}

Duration HostClocks::Since(std::int64_t then_ns, SessionId peer) const {
  const Time now = Now();
  Duration offset{0};
  if (!empty_.load(std::memory_order_relaxed)) {
    const std::scoped_lock lock(mutex_);
    if (const auto known = peers_.find(peer); known != peers_.end()) {
      const auto since = static_cast<double>((now - known->second.at).count());
      offset = known->second.latest.offset + Duration(static_cast<std::int64_t>(since * known->second.latest.drift));
    }
  }
  return now - Later(Time{then_ns}, -offset);
}

}  // namespace hgros
