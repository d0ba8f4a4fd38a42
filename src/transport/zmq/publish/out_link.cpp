#include "transport/zmq/publish/out_link.hpp"

#include <utility>

#include "transport/zmq/control.hpp"
#include "transport/zmq/publish/wire_message.hpp"

namespace hgros::zmq {

OutLink::OutLink(std::shared_ptr<OutboundCore> channel, const Demand& granted, SessionId session,
                 std::uint64_t& peer_waiting_bytes)
    : subscriber(session),
      core(std::move(channel)),
      id(RandomId()),
      flow(granted),
      topic_(PeerTopic(core->name, session)),
      peer_waiting_bytes_(peer_waiting_bytes) {
  topic_.append(sizeof(std::uint64_t), '\0');
}

void OutLink::SendWaiting(Socket& socket, std::uint64_t peer_limit_bytes, PeerChannel::Dropped& ended) {
  while (auto message = flow.Pop()) {
    WriteLinkNumber(topic_, flow.sent());
    static_cast<const WireMessage&>(*message->packed).SendTo(socket, topic_);
    core->sent.fetch_add(1, std::memory_order_relaxed);
    ended.push_back(std::move(*message));
  }
  const std::uint64_t others = peer_waiting_bytes_ - counted_bytes_;
  if (const auto count = flow.Trim(peer_limit_bytes > others ? peer_limit_bytes - others : 0, ended); count > 0) {
    core->dropped.fetch_add(count, std::memory_order_relaxed);
  }
  CountWaiting();
}

void OutLink::CountWaiting() {
  const std::uint64_t now = flow.unsent_bytes();
  peer_waiting_bytes_ += now - counted_bytes_;  // Wraps around to the right sum.
  core->queued_bytes.fetch_add(now - counted_bytes_, std::memory_order_relaxed);
  counted_bytes_ = now;
}

void OutLink::Pause(SteadyTime now) {
  if (flow.paused()) return;
  flow.Pause();
  CountWaiting();
  paused_since_ = now;
}

void OutLink::LeaveSums() {
  peer_waiting_bytes_ -= counted_bytes_;
  core->queued_bytes.fetch_sub(counted_bytes_, std::memory_order_relaxed);
  if (flow.lossless()) core->lossless.fetch_sub(1);
}

}  // namespace hgros::zmq
