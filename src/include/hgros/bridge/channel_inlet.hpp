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
#include "hgros/clock/host_clocks.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

class JoinedInbound;
class NetworkBridge;

// One channel's way into the session: decodes each message once and hands it to the local nodes, in the order in
// which each publisher sent it. Exists while the session has subscriptions to the channel.
//
// Thread safety: Accept() and Run() as InboundSink says; the rest from any thread.
// Invariants: at most one thread delivers; runner_ names it from the Accept() that asked for it until the waiting
// messages are used up. A transport's thread runs no user code: what turns out to need some, such as a node that has
// come since Accept(), goes with all that follows to a thread of the session. What one publisher sends is counted by
// its sequence: gaps are losses, repeats are dropped.
class ChannelInlet final : public InboundSink {
 public:
  using Errand = std::function<void()>;

  // A publisher's messages are not what the channel is used with here.
  using TellMisfit = std::function<void(const std::string& channel, const PeerInfo& from, const std::string& what)>;

  // `run_apart` has its errand run, later, on a thread that owns no socket and that the channel outlives.
  // `brings_replies`: all that comes here are replies to calls of this session, whose node is the library's.
  ChannelInlet(Channel& channel, bool brings_replies, std::shared_ptr<Log> log, std::function<void()> on_publishers,
               std::function<void(Errand)> run_apart, TellMisfit tell_misfit, std::shared_ptr<const HostClocks> clocks);

  // Asks for messages of the type that the channel has now; for any, if it has none yet.
  void Join(NetworkBridge& bridge, const Demand& demand);
  void Detach();
  void SetDemand(const Demand& demand);

  Accepted Accept(InboundMessage&& message) noexcept override;
  void Run() noexcept override;
  void OnFault(PacketFault fault, std::string_view what) noexcept override;
  void OnPublishers(std::size_t count) noexcept override;
  void OnOffer(const PeerInfo& from, const std::shared_ptr<const MessageSchema>& schema) noexcept override;

  // The channel has got its type: who is asked for messages of any, and sends others, is told of.
  void CompareOffers();
  // What the latest of the publishers sends; null if none has said so yet, or the last one has gone.
  [[nodiscard]] std::shared_ptr<const MessageSchema> Schema() const;
  // What the channel is used with here: AnyType() if nobody has said.
  [[nodiscard]] const TypeInfo& channel_type() const noexcept { return DataGraph::TypeOfChannel(channel_); }
  [[nodiscard]] std::size_t publisher_count() const noexcept { return publishers_.load(std::memory_order_acquire); }
  void AddTo(ChannelTraffic& traffic) const;

 private:
  struct Life {
    std::uint64_t incarnation = 0;
    std::uint64_t last_sequence = 0;
    std::int64_t last_heard_ns = 0;
    bool away = false;  // We did not want its messages for a while.
    PublisherTraffic traffic;
  };

  enum class Runner {
    kNobody,
    kTransport,       // The transport's own thread, without user code.
    kVisitor,         // One that waits for a reply and reads it itself; the node of replies is the library's.
    kTransportApart,  // A thread of the transport without sockets.
    kTransportHelps,  // Likewise; it runs a node that would have to be woken for.
    kErrand,          // The session's thread, to which a kTransport has handed over.
  };
  struct Decoded {
    AnyMessage message;
    const TypeInfo* type = nullptr;
    MessageInfo info;
    std::shared_ptr<const void> credit;
    std::size_t latched = 0;
  };

  // Small, and decoded without user code.
  [[nodiscard]] bool IsQuick(const InboundMessage& message) const noexcept;
  enum class Taken { kMessage, kNone, kNotQuick };
  // The next message. If there is none, nobody runs any more.
  Taken Take(InboundMessage& message, UserCode user_code);
  // Counts and decodes; nothing if the message is not to be delivered.
  [[nodiscard]] std::optional<Decoded> Decode(InboundMessage&& message) noexcept;
  [[nodiscard]] bool Inject(const Decoded& decoded, UserCode user_code) noexcept;
  void RunErrand() noexcept;
  void SayLost(std::uint64_t count);
  // False for a repeat. `lost` is set to how many before it did not arrive.
  [[nodiscard]] bool CountIn(const InboundMessage& message, std::uint64_t& lost);
  [[nodiscard]] bool TakesAny() const noexcept { return IsAnyType(*type_.load(std::memory_order_acquire)); }
  [[nodiscard]] std::shared_ptr<const MessageSchema> SchemaOf(const InboundMessage& message);
  void ForgetOffers();
  struct Offer {
    PeerInfo from;
    std::shared_ptr<const MessageSchema> schema;
    bool compared = false;  // With the channel's type.
  };

  Channel& channel_;
  std::atomic<const TypeInfo*> type_;  // That was asked for.
  const bool brings_replies_;
  const std::shared_ptr<Log> log_;
  const std::function<void()> on_publishers_;
  const std::function<void(Errand)> run_apart_;
  const TellMisfit tell_misfit_;
  const std::shared_ptr<const HostClocks> clocks_;

  std::mutex transports_mutex_;
  std::shared_ptr<JoinedInbound> transports_;
  std::atomic<std::size_t> publishers_{0};
  std::atomic<bool> lossless_{false};

  std::mutex waiting_mutex_;
  Fifo<InboundMessage> waiting_;
  Runner runner_ = Runner::kNobody;
  std::optional<Decoded> handed_over_;  // Comes before those that wait.

  std::shared_ptr<const MessageSchema> said_schema_;  // Of those whose link has none. Whoever delivers.
  mutable std::mutex offers_mutex_;
  std::map<std::uint64_t, Offer> offers_;  // By session; those that have gone, too, while others are there.
  std::shared_ptr<const MessageSchema> newest_offer_;

  mutable std::mutex counts_mutex_;
  // By the session that sent it (0: none) and the publisher that it names, so that nobody can speak for another.
  std::map<std::pair<std::uint64_t, std::uint64_t>, Life> lives_;
  std::array<std::uint64_t, kPacketFaultCount> faults_{};
  LogHistogram transport_;
};

}  // namespace hgros
