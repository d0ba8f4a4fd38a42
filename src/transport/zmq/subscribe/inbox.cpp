#include "transport/zmq/subscribe/inbox.hpp"

namespace hgros::zmq {

LeaderPool::Task Inbox::DeliverAll(SharedState& shared, const std::string& endpoint) {
  while (!arrivals_.empty()) {
    Arrival arrival = std::move(arrivals_.front());
    arrivals_.pop_front();
    if (!arrival.core) {
      arrival.action();
      continue;
    }
    auto task = DeliverPacket(arrival.core, std::move(arrival.packet), shared, endpoint);
    if (task) return task;
  }
  return {};
}

}  // namespace hgros::zmq
