#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bridge/joined/transport_move.hpp"
#include "hgros/bridge/transport_list.hpp"
#include "hgros/transport/call_gate.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// One subscribed channel over all transports of a session, into one sink.
///
/// Thread safety: all functions. Invariants: one Accept() at a time, over whichever transport the message comes.
class JoinedInbound {
 public:
  /// Called, on a transport's thread, when the publisher's messages come over the new transport only.
  using OnMoved = std::function<void(SessionId publisher, TransportIndex from)>;
  /// Picks moves.
  using Which = std::function<bool(MoveWay)>;

  /// `most_transports`: how many can be added.
  JoinedInbound(std::string channel, const TypeInfo& type, const Demand& demand, InboundSink& sink,
                std::size_t most_transports, OnMoved on_moved);
  ~JoinedInbound();
  JoinedInbound(const JoinedInbound&) = delete;
  JoinedInbound& operator=(const JoinedInbound&) = delete;

  void Add(Transport& transport, TransportIndex index);
  [[nodiscard]] const std::string& channel() const noexcept { return channel_; }

  /// That session's messages will come over both transports, and then over the new one alone. False if they do not
  /// come over the old one, so that there is nothing to wait for. An earlier move of the session must be finished.
  [[nodiscard]] bool Move(SessionId publisher, MoveWay way);
  /// The old transport delivers nothing more. Call this on a thread that may run user code.
  void FinishMove(
      SessionId publisher, const Which& which = [](MoveWay) { return true; });
  /// From now on all messages are again delivered as they come.
  void ForgetMove(SessionId publisher, const Which& which);

  [[nodiscard]] std::size_t publisher_count() const noexcept;
  void SetDemand(const Demand& demand);
  /// As those of InboundChannel. They may not run during Close() or later, either.
  [[nodiscard]] bool busy() const;
  void End();
  /// Leaves the transports and waits for active calls into the sink, which may end afterwards. publisher_count() and
  /// SetDemand() may not run meanwhile or later; the other functions do nothing then.
  void Close();

 private:
  class Part;
  [[nodiscard]] std::span<const std::unique_ptr<Part>> Parts() const noexcept {
    return std::span(parts_).first(count_.load(std::memory_order_acquire));
  }
  [[nodiscard]] bool Comes(SessionId publisher, TransportIndex over) const;
  // Under accepting_.
  [[nodiscard]] Accepted Accept(InboundMessage&& message, TransportIndex transport);
  [[nodiscard]] Accepted PassOn(std::vector<InboundMessage>&& messages);

  const std::string channel_;
  const TypeInfo& type_;
  InboundSink& sink_;
  const OnMoved on_moved_;
  CallGate gate_;      // For calls of the bridge into the transports' channels and the sink.
  std::mutex adding_;  // Guards demand_, too.
  bool no_more_parts_ = false;
  Demand demand_;
  std::vector<std::unique_ptr<Part>> parts_;  // Never resized: it is read while a part is added.
  std::atomic<std::size_t> count_{0};
  std::mutex accepting_;
  std::unordered_map<SessionId, TransportMove> moves_;  // Under accepting_.
  std::mutex telling_;
  std::vector<std::size_t> publishers_;                     // By part.
  std::set<std::pair<std::uint64_t, std::size_t>> offers_;  // Session and part; under telling_.
};

}  // namespace hgros
