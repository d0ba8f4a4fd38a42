#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "transport/inbound_core.hpp"
#include "transport/leader_pool.hpp"
#include "transport/poller.hpp"
#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/subscribe/inbox.hpp"
#include "transport/zmq/subscribe/packet_reader.hpp"
#include "transport/zmq/subscribe/publisher_connection.hpp"
#include "transport/zmq/subscribe/remote_publisher.hpp"
#include "transport/zmq/subscribe/subscribed_channels.hpp"
#include "transport/zmq/subscribe/unfinished_message.hpp"

namespace hgros::zmq {

/// Receives from one publish endpoint of another session: reads the publisher's messages, and passes them to the
/// connection, the channels and the inbox.
///
/// Thread safety: thread-safe. `mutex_` guards the socket and everything that uses it. Serve(), Look() and Tick()
/// belong to the leading thread; so do `unfinished_`, and `inbox_`, from which it delivers without the mutex.
class SubscriberEndpoint {
 public:
  using Replaced = std::function<void(SessionId)>;

  /// Connects. `claims_freed` is called without a lock when channels may be asked for at another endpoint, and
  /// `replaced` when another session has taken the place of that one. Throws Error.
  SubscriberEndpoint(SharedState& shared, Poller& poller, const SubscribeEndpoint& endpoint, ClaimsFreed claims_freed,
                     Replaced replaced);
  ~SubscriberEndpoint();

  /// Adds what is published there.
  void AddOffers(std::vector<SessionChannels>& known) const;
  [[nodiscard]] const std::string& endpoint() const noexcept { return connection_.endpoint(); }
  [[nodiscard]] int fd() const noexcept { return connection_.fd(); }
  [[nodiscard]] int monitor_fd() const noexcept { return connection_.monitor_fd(); }

  void Subscribe(const std::shared_ptr<InboundCore>& core);
  void Unsubscribe(const std::shared_ptr<InboundCore>& core);
  void UpdateDemand(const std::shared_ptr<InboundCore>& core);
  void SetChannels(const ChannelList& list);
  /// Asks for channels whose claims are free now; only for that of `core`, if it is not null.
  void AskAgain(const InboundCore* core);

  /// To be set when the descriptors have become readable.
  [[nodiscard]] std::atomic<bool>& input() noexcept { return input_; }
  [[nodiscard]] std::atomic<bool>& monitor_input() noexcept { return monitor_input_; }
  /// Whether something is left to be read or delivered.
  [[nodiscard]] bool pending() const noexcept { return !inbox_.empty() || input_.load() || monitor_input_.load(); }
  /// Reads and delivers what has arrived; returns early with a task that must run on another thread. Sets `busy` if
  /// there may be more.
  [[nodiscard]] LeaderPool::Task Serve(bool& busy);
  /// See ZmqTransport::SendOrder().
  [[nodiscard]] OrderWay SendOrder(SessionId publisher, std::string_view request);
  /// Sends credit to the publisher if it waits for that, or always if `all`.
  void SendCredit(bool all);
  void Tick(SteadyTime now);
  /// Closes the connection if the publisher sends a message without an end. To be called at NextLook().
  void Look(SteadyTime now);
  [[nodiscard]] std::optional<SteadyTime> NextLook() const noexcept { return unfinished_.NextLook(); }
  /// The waiting thread itself did not run for a while: the publisher's silence does not count.
  void ForgiveSilence(SteadyTime now);
  /// When Tick() must be called next besides the heartbeats.
  [[nodiscard]] std::optional<SteadyTime> Deadline() const;
  /// Sends Bye. If `others` still listen to the same socket of the publisher, only ends the channels that came here.
  void Close(int linger_ms, bool others, Actions& actions);
  /// Whether both lead to one socket of one publisher.
  [[nodiscard]] static bool LeadAlike(const SubscriberEndpoint& one, const SubscriberEndpoint& other);
  /// After Close(): Serve() makes these calls when it has delivered what was received.
  void SetLastActions(Actions&& actions);

 private:
  /// Under the mutex. True if there may be more to read.
  bool ReadBatch();
  void ReadMonitor(Actions& actions);
  /// A message is missing.
  void OnGap(Actions& actions);
  /// The end of the connection, once what came before it was read.
  void TakeEnd(Actions& actions);
  void OnControl(const std::vector<Message>& frames, Actions& actions);
  void OnWelcome(SessionId session, const wire::Welcome& welcome, Actions& actions);
  void OnHeartbeat(const wire::Heartbeat& heartbeat, Actions& actions);
  /// The publisher exceeds its credit, or is not the session that it claims to be: nothing more is read from this
  /// connection.
  void AbortConnection(std::string_view reason, bool for_good, Actions& actions, std::chrono::milliseconds pause = {});
  void WaitForBytes() noexcept;
  void LosePublisher(std::string_view reason, bool for_good, Actions& actions);
  void Report(EndpointEvent event, Actions& actions) const;
  void SayHello(std::uint64_t handshake);

  SharedState& shared_;
  Poller& poller_;
  const std::function<void(EndpointEvent, SessionId)> on_event_;
  const Replaced replaced_;
  mutable std::mutex mutex_;
  PublisherConnection connection_;
  const LentFlag lent_input_{shared_.input_flags};
  const LentFlag lent_monitor_input_{shared_.input_flags};
  const LentFlag lent_bytes_{shared_.input_flags};
  std::atomic<bool>& input_ = *lent_input_;  // There may be input to read.
  std::atomic<bool>& monitor_input_ = *lent_monitor_input_;
  std::atomic<bool>& bytes_ = *lent_bytes_;  // Bytes have come after a silence.
  RemotePublisher publisher_;
  bool end_waits_ = false;  // The connection has ended; what came before it is still being read.
  bool ended_ = false;      // The connection, while what came over it is still being read.
  SubscribedChannels channels_;
  UnfinishedMessage unfinished_{shared_.options.max_message_bytes};
  Actions last_;  // Called when the inbox of the closed endpoint is empty.
  Inbox inbox_;
  PacketReader packets_{shared_, connection_, publisher_, channels_, inbox_};
};

}  // namespace hgros::zmq
