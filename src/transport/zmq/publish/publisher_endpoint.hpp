#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/transport/inbound_channel.hpp"
#include "transport/outbound_core.hpp"
#include "transport/peer_channel.hpp"
#include "transport/zmq/arrival_wait.hpp"
#include "transport/zmq/publish/connection_watch.hpp"
#include "transport/zmq/publish/published_channels.hpp"
#include "transport/zmq/publish/subscriber_peers.hpp"
#include "transport/zmq/publish/subscriptions.hpp"
#include "transport/zmq/publish/wire_message.hpp"
#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

/// One bound XPUB socket: reads the messages of subscribers and passes them to the channels, peers and subscriptions.
///
/// Thread safety: thread-safe. `mutex_` guards the socket and everything that uses it. Publishing threads send under
/// it. Serve() and Tick() belong to the leading thread. Calls into the session are returned as actions and made
/// without the mutex.
/// Invariant: a connection whose filter is none of the three topics is closed, because no credit would limit the
/// packets that wait for it (docs/decisions/0008).
class PublisherEndpoint {
 public:
  /// Gets the orders of subscribers, on the leading thread and without the mutex.
  using TakeOrder = std::function<void(InboundMessage&&)>;

  /// Binds. Throws Error.
  PublisherEndpoint(SharedState& shared, const PublishEndpoint& endpoint, TakeOrder take_order);
  ~PublisherEndpoint();

  [[nodiscard]] const std::string& endpoint() const noexcept { return endpoint_; }
  /// The endpoint at which it is bound, with the port that the system chose.
  [[nodiscard]] const std::string& bound() const noexcept { return bound_; }
  [[nodiscard]] int fd() const noexcept { return fd_; }
  [[nodiscard]] ConnectionWatch& watch() noexcept { return watch_; }

  void Offer(const std::shared_ptr<OutboundCore>& core);
  void Withdraw(const std::shared_ptr<OutboundCore>& core, Actions& actions);
  void SetChannels(const ChannelList& list);

  /// Reserve() needs all endpoints at once: it locks them all, then asks each for room, then reserves at each.
  [[nodiscard]] std::mutex& mutex() noexcept { return mutex_; }
  [[nodiscard]] bool HasRoomLocked(const OutboundCore& core) const { return channels_.HasRoom(core); }
  void ReserveLocked(const OutboundCore& core) { channels_.Reserve(core); }
  void CancelReservation(const std::shared_ptr<OutboundCore>& core);
  void Commit(const std::shared_ptr<OutboundCore>& core, const std::shared_ptr<const WireMessage>& message,
              PeerChannel::Dropped& ended);

  /// To be set when the descriptor has become readable.
  [[nodiscard]] std::atomic<bool>& input() noexcept { return input_; }
  /// Whether Serve() has something to do.
  [[nodiscard]] bool pending() noexcept {
    return input_.load() || watch_.input().load() || watch_.unfinished().input().load();
  }
  /// Reads what has arrived, if pending(). True if there may be more.
  bool Serve(Actions& actions);
  void Tick(SteadyTime now, Actions& actions);
  /// Another session publishes where this one did: it is not waited for.
  void OnReplaced(SessionId session, Actions& actions);
  /// The waiting thread itself did not run for a while: counts all peers as heard now.
  void ForgiveSilence(SteadyTime now);
  /// Adds what its subscribers may not have received yet, and asks them. For the end of the transport.
  void LookAtArriving(Arriving& arriving);
  [[nodiscard]] std::size_t Unfinished(const OutboundCore& core) const;
  /// Adds the sessions that subscribe here, with their channels.
  void AddWishes(std::vector<SessionChannels>& known) const;
  /// Sends Bye to all peers.
  void Close(int linger_ms, Actions& actions);

 private:
  void OnFrame(Message& frame, Actions& actions);
  void OnTopic(bool subscribed, std::string_view text, Message& frame, Actions& actions);
  void RefuseFilter(std::string_view filter, Message& frame);
  void OnUpstream(Message& frame, Actions& actions);
  void OnOrder(const SubscriberPeer& peer, wire::Order&& order, const Message& frame, Actions& actions) const;
  [[nodiscard]] bool MayClaim(SessionId session, const Message& frame);
  void FetchLatched(const std::shared_ptr<OutboundCore>& core, SessionId session, std::uint64_t link);

  SharedState& shared_;
  const TakeOrder take_order_;
  const std::string endpoint_;
  std::string bound_;
  mutable std::mutex mutex_;
  Socket socket_;
  ConnectionWatch watch_;
  int fd_ = -1;
  std::atomic<bool> input_{true};  // There may be input to read.
  PublishedChannels channels_;
  SubscriberPeers peers_;
  Subscriptions subscriptions_;
};

}  // namespace hgros::zmq
