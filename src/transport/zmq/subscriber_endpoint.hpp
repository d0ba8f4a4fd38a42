#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "transport/inbound_core.hpp"
#include "transport/zmq/carrier.hpp"
#include "transport/zmq/clock_question.hpp"
#include "transport/zmq/inbound_packet.hpp"
#include "transport/zmq/link_credit.hpp"

namespace hgros::zmq {

/// One XSUB socket connected to one publish endpoint of another session, and the links over it.
///
/// Thread safety: all functions; `mutex_` guards socket, publisher and links. Serve() and Tick() are the leading
/// thread's. `inbox_` belongs to the leading thread alone: what was read waits there in its order, packets and calls
/// into the session alike, and goes on without the mutex.
/// Invariants: a link has an id only between Subscribed and the end of that link; then every packet on it has the
/// number received + 1, others are repeats, or the first ones after a cut that will be sent again.
class SubscriberEndpoint {
 public:
  /// Connects. `claims_freed` is called without a lock when channels may be asked for at another endpoint.
  /// Throws Error.
  SubscriberEndpoint(Carrier& carrier, const SubscribeEndpoint& endpoint, std::function<void()> claims_freed);
  ~SubscriberEndpoint();

  /// What is published there.
  void AddOffers(std::vector<SessionChannels>& known) const;
  [[nodiscard]] const std::string& endpoint() const noexcept { return endpoint_; }
  [[nodiscard]] int fd() const noexcept { return fd_; }
  [[nodiscard]] int monitor_fd() const noexcept { return monitor_fd_; }

  void Want(const std::shared_ptr<InboundCore>& core);
  void Unwant(const std::shared_ptr<InboundCore>& core);
  void ChangeDemand(const std::shared_ptr<InboundCore>& core);
  void SetChannels(const ChannelList& list);
  /// Asks for channels whose claims are free now.
  void AskAgain();

  /// To be set when the descriptors have become readable.
  [[nodiscard]] std::atomic<bool>& input() noexcept { return input_; }
  [[nodiscard]] std::atomic<bool>& monitor_input() noexcept { return monitor_input_; }
  /// Something is left to be read or delivered.
  [[nodiscard]] bool pending() const noexcept { return !inbox_.empty() || input_.load() || monitor_input_.load(); }
  /// Reads and delivers what has come; returns early with what has to run apart. `busy` is set if there may be more.
  [[nodiscard]] LeaderPool::Task Serve(bool& busy);
  /// Tells the publisher of consumed messages where it waits for that, or of all.
  void TellCredits(bool all);
  void Tick(SteadyTime now);
  void Forgive(SteadyTime now);
  /// When Tick() must be called next besides the heartbeats.
  [[nodiscard]] std::optional<SteadyTime> Deadline() const;
  /// Says goodbye, but not where `others` still listen to the same socket of the publisher's: then the channels that
  /// came here are let go of.
  void Close(int linger_ms, bool others, Actions& actions);
  /// Whether both lead to one socket of one publisher.
  [[nodiscard]] static bool LeadAlike(const SubscriberEndpoint& one, const SubscriberEndpoint& other);
  /// After Close(): Serve() makes these calls when it has delivered what was received.
  void MakeLast(Actions&& actions);

 private:
  struct Link {
    std::shared_ptr<InboundCore> core;
    bool allowed = true;
    bool subscribed = false;  // The peer topic, with ZeroMQ.
    bool plain = false;       // The plain topic, likewise.
    bool asked = false;       // Subscribe was sent since the last Welcome.
    bool active = false;      // Counted as a publisher.
    std::uint64_t id = 0;
    std::uint64_t fingerprint = 0;                // Of the publisher's type, compared with ours.
    std::shared_ptr<const MessageSchema> schema;  // That type, if it is another one.
    // The widest window that was asked for: whatever a publisher says, it was granted no more.
    std::uint64_t asked_messages = 1;
    std::uint64_t asked_bytes = 1;
    std::shared_ptr<LinkCredit> credit;
    std::vector<std::weak_ptr<LinkCredit>> earlier;  // Of ended links; they live while messages are in flight.
    std::shared_ptr<LinkCredit> plain_credit;        // Of plain publishers, who are told nothing of it.
  };
  struct Publisher {
    SessionFacts facts;
    std::uint64_t handshake = 0;
    SteadyTime last_heard{};
    bool alive = false;
    ClockQuestion clock;
    std::unordered_set<std::string> told_mismatch;
    std::map<std::string, ChannelUse> offers;
  };
  struct Arrival {
    std::shared_ptr<InboundCore> core;  // Null: `action` is to be done.
    InboundPacket packet;
    std::function<void()> action;
  };

  // subscriber_endpoint.cpp: channels and data.
  bool ReadBatch();
  void OnData(Message& topic, std::vector<Message>& frames);
  void Drop(const Link& link, PacketFault fault, std::string_view what, std::shared_ptr<const void> credit);
  void OnOverdraft(const Link& link);
  void AddActions(Actions& actions);
  void SubscribeTopic(std::string topic, bool subscribe);
  void SetPlain(Link& link, bool plain);
  static void SetPlainWindow(const Link& link);
  /// Its earlier links have left so much in flight that no more is taken.
  [[nodiscard]] static bool IsCrowded(Link& link);
  [[nodiscard]] bool Allowed(const std::string& channel) const;

  // subscriber_control.cpp: what the publisher says.
  void OnControl(const std::vector<Message>& frames, Actions& actions);
  void OnHeartbeat(const wire::Heartbeat& heartbeat, Actions& actions);
  void OnWelcome(SessionId session, const wire::Welcome& welcome, Actions& actions);
  void OnSubscribed(const wire::Subscribed& subscribed, Actions& actions);
  void OnRefused(const wire::Refused& refused, Actions& actions);
  void OnWithdrawn(const std::string& channel, Actions& actions);
  void OnOffers(const wire::Offers& offers, Actions& actions);
  void AddOffer(const wire::ChannelType& offered);
  void TellChannels(Actions& actions);
  void OnMonitor(Actions& actions);
  void TellUnreachable();
  void Ask(Link& link);
  void SendSubscribe(Link& link, bool change_only);
  void EndLink(Link& link, Actions& actions);
  static void EndCredit(Link& link);
  void Unsubscribe(const std::string& channel, std::string_view mismatch);
  void ReleaseClaim(const Link& link, Actions& actions);
  [[nodiscard]] bool IsClaimedBeside(const Link& link) const;
  void StopAsking(Link& link, std::string_view mismatch, Actions& actions);
  void LosePublisher(std::string_view reason, bool for_good, Actions& actions);
  void TellMismatch(const std::string& channel, const std::string& what, Actions& actions);
  void SayHello(std::uint64_t handshake);
  void Say(const wire::Control& control);

  Carrier& carrier_;
  const std::string endpoint_;
  const std::function<void()> claims_freed_;
  mutable std::mutex mutex_;
  Socket socket_;
  Socket monitor_;
  int fd_ = -1;
  int monitor_fd_ = -1;
  std::atomic<bool> input_{true};  // There may be input to read.
  std::atomic<bool> monitor_input_{true};
  std::optional<std::set<std::string, std::less<>>> allowed_;
  std::unordered_map<std::string, Link> links_;
  std::optional<Publisher> publisher_;
  bool connected_ = false;
  bool welcomed_ = false;  // Since it was connected.
  bool plain_mode_ = false;
  SteadyTime connected_since_{};
  // Disconnected, and ZeroMQ has not said that it will try again: after a breach of its protocol (somebody else had
  // the publisher's port) it never does.
  std::optional<SteadyTime> given_up_since_;
  // Since when there is no connection, until that was said.
  std::optional<SteadyTime> unreached_since_ = std::chrono::steady_clock::now();
  int handshake_failure_ = 0;  // The event that tells most of the attempts since the last connection.
  Actions last_;               // When the inbox of a closed endpoint is empty.
  std::deque<Arrival> inbox_;
};

}  // namespace hgros::zmq
