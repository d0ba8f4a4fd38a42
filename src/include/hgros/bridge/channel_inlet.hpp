#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hgros/base/fifo.hpp"
#include "hgros/base/log.hpp"
#include "hgros/bridge/channel_traffic.hpp"
#include "hgros/bridge/publisher_life.hpp"
#include "hgros/clock/host_clocks.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

class JoinedInbound;
class NetworkBridge;

// Receives one channel from other sessions: decodes each message once and delivers it to the local nodes, in the order
// of each publisher. Exists while the session has subscriptions to the channel.
//
// Thread safety: Accept() and Run() as InboundSink says; the rest from any thread.
// Invariants: at most one thread delivers. runner_ names it from the Accept() that asked for it until no message waits.
// A transport's thread runs no user code. If a message turns out to need user code, for example because a node came
// after Accept(), it and all later messages go to a thread of the session. The sequence numbers of each publisher are
// checked: gaps count as losses, repeats are dropped.
class ChannelInlet final : public InboundSink {
 public:
  using Errand = std::function<void()>;

  // Reports a publisher whose type differs from the channel's type here.
  using TellMisfit = std::function<void(const std::string& channel, const PeerInfo& from, const std::string& what)>;

  // `run_apart` runs its errand later, on a thread that owns no socket and ends before the channel. `brings_replies`:
  // all messages are replies to calls of this session, and the node is the library's.
  ChannelInlet(Channel& channel, bool brings_replies, std::shared_ptr<Log> log, std::function<void()> on_publishers,
               std::function<void(Errand)> run_apart, TellMisfit tell_misfit, std::shared_ptr<const HostClocks> clocks);

  // Subscribes with the current type of the channel, or with any type if it has none yet.
  void Join(NetworkBridge& bridge, const Demand& demand);
  // Nobody subscribes here any more: what comes until Detach() is dropped. It must not reach a subscription that is
  // made meanwhile, which misses what is published before the next Join(). Returns what waits, for the caller to
  // destroy.
  [[nodiscard]] Fifo<InboundMessage> Leave();
  void Detach();
  // Before Detach(), which waits for callbacks that run on threads of the transports: whether there are some, and to
  // end the subscription without waiting.
  [[nodiscard]] bool busy();
  void End();
  void SetDemand(const Demand& demand);
  // The channel has got a type since Join() subscribed with any.
  [[nodiscard]] bool AsksForTooMuch() const noexcept { return TakesAny() && !IsAnyType(TypeToAsk()); }

  Accepted Accept(InboundMessage&& message) noexcept override;
  void Run() noexcept override;
  void OnFault(PacketFault fault, std::string_view what) noexcept override;
  void OnPublishers(std::size_t count) noexcept override;
  void OnOffer(const PeerInfo& from, const std::shared_ptr<const MessageSchema>& schema) noexcept override;
  void OnOfferEnded(SessionId from, OfferEnd why) noexcept override;

  // Call it when the channel has got its type: reports publishers of another type that were subscribed to with any
  // type.
  void CompareOffers();
  // The schema of the publisher that came last and is not gone. Null if there is none.
  [[nodiscard]] std::shared_ptr<const MessageSchema> Schema() const;
  // The type of the channel here; AnyType() if it has none yet.
  [[nodiscard]] const TypeInfo& channel_type() const noexcept { return DataGraph::TypeOfChannel(channel_); }
  [[nodiscard]] std::size_t publisher_count() const noexcept { return publishers_.load(std::memory_order_acquire); }
  void AddTo(ChannelTraffic& traffic) const;

 private:
  enum class Runner {
    kNobody,
    kTransport,       // The transport's own thread, without user code.
    kVisitor,         // A thread that waits for a reply and receives it itself; the node of replies is the library's.
    kTransportApart,  // A thread of the transport without sockets.
    kTransportHelps,  // The same, and it runs a node instead of waking a worker.
    kErrand,          // The session's thread, to which a kTransport has handed over the messages.
  };
  struct Decoded {
    AnyMessage message;
    const TypeInfo* type = nullptr;
    MessageInfo info;
    std::shared_ptr<const void> credit;
    std::size_t latched = 0;
    std::uint64_t detached = 0;  // detached_ when the message was taken.
  };
  struct Turn {
    std::uint64_t detached = 0;  // detached_ when the message was taken.
    std::uint64_t number = 0;    // Of the messages that were accepted, in their order.
  };

  // True if the message is small and is decoded without user code.
  [[nodiscard]] bool IsQuick(const InboundMessage& message) const noexcept;
  enum class Taken { kMessage, kNone, kNotQuick };
  [[nodiscard]] bool HasWaiting() { return (std::scoped_lock(waiting_mutex_), !waiting_.empty()); }
  // Takes the next message. If there is none, no thread delivers any more.
  Taken TakeNext(InboundMessage& message, UserCode user_code, Turn& turn);
  // Counts and decodes the message. Empty if it must not be delivered.
  [[nodiscard]] std::optional<Decoded> Decode(InboundMessage&& message, const Turn& turn) noexcept;
  // Does nothing with a message that was taken before Detach(). False: it needs a thread for user code.
  [[nodiscard]] bool Inject(const Decoded& decoded, UserCode user_code) noexcept;
  void RunErrand() noexcept;
  void SayLost(const PublisherLife::Gap& lost, SessionId from);
  // False for a repeat, and for a message that was taken before Detach(). Sets `lost` to the messages before it that
  // did not arrive, and `way_ns` to the time since it was published.
  [[nodiscard]] bool CountIn(const InboundMessage& message, const Turn& turn, PublisherLife::Gap& lost,
                             std::int64_t& way_ns);
  [[nodiscard]] MessageInfo InfoOf(const InboundMessage& message, std::int64_t way_ns) const noexcept;
  [[nodiscard]] bool TakesAny() const noexcept { return IsAnyType(*type_.load(std::memory_order_acquire)); }
  [[nodiscard]] std::shared_ptr<const MessageSchema> SchemaOf(const InboundMessage& message);
  void ForgetOffers() { return (std::scoped_lock(offers_mutex_), offers_.clear()); }
  [[nodiscard]] const TypeInfo& TypeToAsk() const noexcept;
  struct Offer {
    PeerInfo from;
    std::shared_ptr<const MessageSchema> schema;
    bool compared = false;     // True once it was compared with the channel's type.
    std::uint64_t number = 0;  // Counts the offers.
  };

  Channel& channel_;
  std::atomic<const TypeInfo*> type_;  // The type of the subscription.
  const bool brings_replies_;
  const bool is_librarys_;  // Only sessions publish on it, under their own ids.
  const std::shared_ptr<Log> log_;
  const std::function<void()> on_publishers_;
  const std::function<void(Errand)> run_apart_;
  const TellMisfit tell_misfit_;
  const std::uint32_t origin_;  // OriginOf() the channel, for Cause.
  const std::shared_ptr<const HostClocks> clocks_;

  std::mutex transports_mutex_;
  std::shared_ptr<JoinedInbound> transports_;
  std::atomic<std::size_t> publishers_{0};
  std::atomic<bool> lossless_{false};

  std::mutex waiting_mutex_;
  Fifo<InboundMessage> waiting_;
  std::uint64_t taken_ = 0;  // Number of messages that were taken from waiting_.
  Runner runner_ = Runner::kNobody;
  std::optional<Decoded> handed_over_;  // Delivered before waiting_.
  bool leaves_ = false;                 // Between Leave() and Detach().
  // The number of calls of Leave() and Detach(). A message that an errand took before is not for the next subscription,
  // which would miss those between that message and its own first one. Changed under waiting_mutex_.
  std::atomic<std::uint64_t> detached_{0};

  // The latest schemas for messages whose link has none, newest last. Used by the delivering thread.
  std::vector<std::shared_ptr<const MessageSchema>> said_schemas_;
  mutable std::mutex offers_mutex_;
  std::map<std::uint64_t, Offer> offers_;  // By session.
  std::uint64_t last_offer_ = 0;

  mutable std::mutex counts_mutex_;
  // By the sending session (0: none) and the publisher in the message, so that no session can disturb another's counts.
  std::map<std::pair<std::uint64_t, std::uint64_t>, PublisherLife> lives_;
  std::array<std::uint64_t, kPacketFaultCount> faults_{};
  LogHistogram transport_;
};

}  // namespace hgros
