#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "transport/outbound_core.hpp"
#include "transport/peer_channel.hpp"
#include "transport/zmq/carrier.hpp"
#include "transport/zmq/clock_question.hpp"
#include "transport/zmq/wire_message.hpp"

namespace hgros::zmq {

/// One bound XPUB socket, the sessions that subscribe there, and their links.
///
/// Thread safety: all functions; `mutex_` guards socket, peers and links. Publishing threads send under it. Serve()
/// and Tick() are the leading thread's; calls into the session are handed back as actions, made without the mutex.
/// Invariants: a peer is one whose Hello answered our last Welcome. A link belongs to a peer's wish and is listed in
/// its channel. Between a Welcome and the Subscribe that answers it a link is paused: so what the subscriber had
/// received when it saw the Welcome is all it will ever receive of what was sent before. A connection whose filter is
/// none of the three topics is closed: what waits for it is bounded by nobody's credit.
class PublisherEndpoint {
 public:
  /// Binds. Throws Error.
  PublisherEndpoint(Carrier& carrier, const PublishEndpoint& endpoint);
  ~PublisherEndpoint();

  [[nodiscard]] const std::string& endpoint() const noexcept { return endpoint_; }
  [[nodiscard]] const std::string& bound() const noexcept { return bound_; }
  [[nodiscard]] int fd() const noexcept { return fd_; }

  void Offer(const std::shared_ptr<OutboundCore>& core);
  void Withdraw(const std::shared_ptr<OutboundCore>& core, Actions& actions);
  void SetChannels(const ChannelList& list);

  /// For Reserve(), which needs all endpoints at once: all are locked, asked, and then made to promise.
  [[nodiscard]] std::mutex& mutex() noexcept { return mutex_; }
  [[nodiscard]] bool HasRoomLocked(const OutboundCore& core) const;
  void ReserveLocked(const OutboundCore& core);
  void Cancel(const std::shared_ptr<OutboundCore>& core);
  void Commit(const std::shared_ptr<OutboundCore>& core, const std::shared_ptr<const WireMessage>& message,
              PeerChannel::Dropped& dropped);

  /// To be set when the descriptor has become readable.
  [[nodiscard]] std::atomic<bool>& input() noexcept { return input_; }
  /// Reads what has come, if input() is set. True if there may be more.
  bool Serve(Actions& actions);
  void Tick(SteadyTime now, Actions& actions);
  /// The waiting thread was asleep itself: nobody's silence counts.
  void Forgive(SteadyTime now);
  [[nodiscard]] bool AllSent() const;
  /// Who subscribes here, and to what.
  void AddWishes(std::vector<SessionChannels>& known) const;
  /// Says goodbye.
  void Close(int linger_ms, Actions& actions);

 private:
  struct Peer;
  struct Link {
    Link(Peer& owner, std::shared_ptr<OutboundCore> channel, const Demand& granted, SessionId subscriber);
    Peer& peer;
    const std::shared_ptr<OutboundCore> core;
    const std::uint64_t id;
    PeerChannel flow;
    std::string topic;                // The last 8 bytes are the message's number.
    std::uint64_t counted_bytes = 0;  // Of flow.waiting_bytes(), in the peer's and the channel's sums.
    SteadyTime paused_since{};
  };
  struct Wish {
    wire::Subscribe asked;
    std::unique_ptr<Link> link;
  };
  struct Peer {
    SessionFacts facts;
    std::string topic;  // Its control topic.
    std::uint64_t handshake = 0;
    SteadyTime last_heard{};
    bool cut = false;
    ClockQuestion clock;
    std::uint64_t waiting_bytes = 0;
    std::unordered_map<std::string, Wish> wishes;  // By channel.
    std::unordered_set<std::string> told_mismatch;
  };
  struct Channel {
    std::shared_ptr<OutboundCore> core;
    bool allowed = true;
    bool plain = false;
    std::vector<Link*> links;
  };
  struct Greeting {
    std::uint64_t handshake = 0;
    SteadyTime when{};
    // What is offered has changed since, and nobody has said Hello whom that could be told.
    bool stale = false;
    std::set<std::string> gone;
  };

  // publisher_endpoint.cpp: channels and data.
  void Drain(Link& link, PeerChannel::Dropped& dropped);
  /// Has the messages end when no mutex is held.
  static void Discard(PeerChannel::Dropped&& dropped, Actions& actions);
  void CountWaiting(Link& link);
  void UpdatePlain(Channel& channel, Actions& actions);
  void RemoveLink(Wish& wish, bool died, Actions& actions);
  void CloseChannel(Channel& channel, Actions& actions);
  void OpenChannel(Channel& channel, Actions& actions);
  void TellOffer(const Channel& channel, bool came);
  void TellAllOffers(const Peer& peer, Greeting& greeting);
  [[nodiscard]] bool Allowed(const std::string& channel) const;
  void StartLink(const std::shared_ptr<OutboundCore>& core, SessionId session, std::uint64_t link_id);

  // publisher_control.cpp: what subscribers say.
  void OnFrame(Message& frame, Actions& actions);
  void OnTopic(bool subscribed, std::string_view text, Message& frame, Actions& actions);
  void Refuse(std::string_view filter, Message& frame);
  void OnUpstream(Bytes bytes, Actions& actions);
  void OnHeartbeat(Peer& peer, const wire::Heartbeat& heartbeat, Actions& actions);
  void OnHello(SessionId session, const wire::Hello& hello, Actions& actions);
  void OnSubscribe(Peer& peer, const wire::Subscribe& subscribe, Actions& actions);
  void OnUnsubscribe(Peer& peer, const wire::Unsubscribe& unsubscribe, Actions& actions);
  void OnCredit(Peer& peer, const wire::Credit& credit, Actions& actions);
  void Activate(Peer& peer, Wish& wish, Actions& actions);
  void Greet(SessionId session, bool at_once);
  void DropPeer(SessionId session, std::string_view reason, Actions& actions);
  void PauseLinks(Peer& peer);
  void TellWishes(Actions& actions);
  void TellMismatch(Peer& peer, const std::string& channel, const std::string& what, Actions& actions);
  void SendSubscribed(Peer& peer, const Link& link, const std::string& descriptor_set);
  void Say(const Peer& peer, const wire::Control& control) { Say(peer.topic, control); }
  void Say(const std::string& topic, const wire::Control& control);

  Carrier& carrier_;
  const std::string endpoint_;
  std::string bound_;
  mutable std::mutex mutex_;
  Socket socket_;
  int fd_ = -1;
  std::atomic<bool> input_{true};  // There may be input to read.
  std::optional<std::set<std::string, std::less<>>> allowed_;
  std::unordered_map<std::string, Channel> channels_;
  std::unordered_map<SessionId, std::unique_ptr<Peer>> peers_;
  std::unordered_map<SessionId, Greeting> greetings_;
  std::uint64_t last_handshake_;
  std::set<std::string, std::less<>> plain_channels_;  // That plain subscribers ask for.
  const OutstandingBytes plain_bytes_ = std::make_shared<std::atomic<std::uint64_t>>(0);
};

}  // namespace hgros::zmq
