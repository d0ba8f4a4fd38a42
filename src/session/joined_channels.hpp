#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "hgros/session/carrier_set.hpp"
#include "hgros/transport/transport.hpp"
#include "session/carrier_move.hpp"
#include "session/cut_subscribers.hpp"

namespace hgros {

/// How many carriers one channel may go through at once.
inline constexpr std::size_t kMaxCarriers = 2;

/// One advertised channel over all carriers of a session: a message is promised by all of them or by none, and handed
/// to all. Which subscriber takes it from which carrier is the subscribers' affair. One that a carrier loses is kept
/// what it has not confirmed, and what is published until it is back.
///
/// Thread safety: all functions. Invariants: a carrier that was added stays until the end.
class JoinedOutbound : public std::enable_shared_from_this<JoinedOutbound> {
 public:
  /// A carrier has lost the subscriber: `give_up` is to be called later, when it could have come back. Under that
  /// carrier's lock.
  using Await = std::function<void(SessionId subscriber, std::function<void()> give_up)>;

  JoinedOutbound(std::string channel, const TypeInfo& type, OutboundSource& source, Await await);
  ~JoinedOutbound();
  JoinedOutbound(const JoinedOutbound&) = delete;
  JoinedOutbound& operator=(const JoinedOutbound&) = delete;

  void Add(Transport& transport);
  [[nodiscard]] const std::string& channel() const noexcept { return channel_; }

  [[nodiscard]] std::size_t subscriber_count() const noexcept;
  /// The sessions that subscribe now, each once; not those that were lost and may come back.
  [[nodiscard]] std::vector<SessionId> Subscribers() const;
  PublishStatus Reserve() noexcept;
  void Commit(const PacketHead& head, const Payload& data) noexcept;
  void Cancel() noexcept;
  /// Memory of a carrier that has subscribers.
  [[nodiscard]] std::optional<Block> Loan(std::size_t size_bytes);
  [[nodiscard]] OutboundChannel::Stats stats() const;
  /// The subscriber is not waited for any longer; of several cuts only that one is meant, if a number is given.
  void GiveUp(SessionId subscriber, std::optional<std::uint64_t> cut = std::nullopt);

 private:
  class Part;
  void Keep(SessionId subscriber, const Demand& demand, std::vector<OutboundMessage>&& unfinished);
  // What a subscriber gets before all else.
  [[nodiscard]] std::vector<OutboundMessage> First(SessionId subscriber);
  void TellSubscribers();

  const std::string channel_;
  const TypeInfo& type_;
  OutboundSource& source_;
  const Await await_;
  CutSubscribers cut_;
  std::atomic<bool> refused_{false};  // For want of room for those that are cut off.
  std::atomic<std::uint64_t> missed_{0};
  std::mutex adding_;
  std::array<std::unique_ptr<Part>, kMaxCarriers> parts_;
  std::atomic<std::size_t> count_{0};
  // The sum is made and told under one lock, so that the last one told is true.
  std::mutex telling_;
  std::array<std::size_t, kMaxCarriers> subscribers_{};
};

/// One subscribed channel over all carriers of a session, into one sink.
///
/// Thread safety: all functions. Invariants: one Accept() at a time, whichever carrier it comes from.
class JoinedInbound {
 public:
  /// `on_moved` is called, on a carrier's thread, when a move has come to its end.
  JoinedInbound(std::string channel, const TypeInfo& type, const Demand& demand, InboundSink& sink,
                std::function<void(SessionId)> on_moved);
  ~JoinedInbound();
  JoinedInbound(const JoinedInbound&) = delete;
  JoinedInbound& operator=(const JoinedInbound&) = delete;

  void Add(Transport& transport, CarrierKind kind);
  [[nodiscard]] const std::string& channel() const noexcept { return channel_; }

  /// That session's messages will come over `to` as well, and then over it alone. False if the other carrier does not
  /// bring them, so that there is nothing to wait for.
  [[nodiscard]] bool Move(SessionId publisher, CarrierKind to);
  /// The other carrier brings nothing more. On a thread that may run user code.
  void FinishMove(SessionId publisher);
  /// All that comes goes on again as it comes.
  void ForgetMove(SessionId publisher);

  [[nodiscard]] std::size_t publisher_count() const noexcept;
  void SetDemand(const Demand& demand);

 private:
  class Part;
  // Under accepting_.
  [[nodiscard]] Accepted Accept(InboundMessage&& message, CarrierKind kind);
  [[nodiscard]] Accepted PassOn(std::vector<InboundMessage>&& messages);

  const std::string channel_;
  const TypeInfo& type_;
  InboundSink& sink_;
  const std::function<void(SessionId)> on_moved_;
  std::mutex adding_;  // Guards demand_, too.
  Demand demand_;
  std::array<std::unique_ptr<Part>, kMaxCarriers> parts_;
  std::atomic<std::size_t> count_{0};
  std::mutex accepting_;
  std::unordered_map<SessionId, CarrierMove> moves_;  // Under accepting_.
  std::mutex telling_;
  std::array<std::size_t, kMaxCarriers> publishers_{};
};

}  // namespace hgros
