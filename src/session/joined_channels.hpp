#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/transport/transport.hpp"

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
  JoinedInbound(std::string channel, const TypeInfo& type, const Demand& demand, InboundSink& sink);
  ~JoinedInbound();
  JoinedInbound(const JoinedInbound&) = delete;
  JoinedInbound& operator=(const JoinedInbound&) = delete;

  void Add(Transport& transport);
  [[nodiscard]] const std::string& channel() const noexcept { return channel_; }

  [[nodiscard]] std::size_t publisher_count() const noexcept;
  void SetDemand(const Demand& demand);

 private:
  class Part;
  const std::string channel_;
  const TypeInfo& type_;
  InboundSink& sink_;
  std::mutex adding_;  // Guards demand_, too.
  Demand demand_;
  std::array<std::unique_ptr<Part>, kMaxCarriers> parts_;
  std::atomic<std::size_t> count_{0};
  std::mutex accepting_;
  std::mutex telling_;
  std::array<std::size_t, kMaxCarriers> publishers_{};
};

}  // namespace hgros
