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

namespace hgros {

/// How many carriers one channel may go through at once.
inline constexpr std::size_t kMaxCarriers = 2;

/// One advertised channel over all carriers of a session: a message is promised by all of them or by none, and handed
/// to all. Which subscriber takes it from which carrier is the subscribers' affair.
///
/// Thread safety: all functions. Invariants: a carrier that was added stays until the end.
class JoinedOutbound {
 public:
  JoinedOutbound(std::string channel, const TypeInfo& type, OutboundSource& source);
  ~JoinedOutbound();
  JoinedOutbound(const JoinedOutbound&) = delete;
  JoinedOutbound& operator=(const JoinedOutbound&) = delete;

  void Add(Transport& transport);
  [[nodiscard]] const std::string& channel() const noexcept { return channel_; }

  [[nodiscard]] std::size_t subscriber_count() const noexcept;
  PublishStatus Reserve() noexcept;
  void Commit(const PacketHead& head, const Payload& data) noexcept;
  void Cancel() noexcept;
  /// Memory of a carrier that has subscribers.
  [[nodiscard]] std::optional<Block> Loan(std::size_t size_bytes);
  [[nodiscard]] OutboundChannel::Stats stats() const;

 private:
  class Part;
  const std::string channel_;
  const TypeInfo& type_;
  OutboundSource& source_;
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
