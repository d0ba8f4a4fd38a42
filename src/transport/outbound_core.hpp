#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hgros/internal/codec/packet.hpp"
#include "hgros/transport/transport.hpp"
#include "transport/actions.hpp"
#include "transport/call_gate.hpp"

namespace hgros {

/// One advertised channel, as all endpoints of a transport see it.
/// Thread safety: thread-safe.
struct OutboundCore {
  OutboundCore(std::string_view channel, const TypeInfo& message_type, OutboundSource& owner)
      : name(channel), plain_topic(PlainTopic(channel)), type(message_type), source(owner) {}

  /// A subscriber has come or gone: a session, or, if `who` is none, the plain subscribers of one endpoint.
  static void CountSubscriber(const std::shared_ptr<OutboundCore>& core, SessionId who, int change, Actions& actions);
  /// Reports room to the source, if the source was refused. Called under the transport's mutex.
  static void TellRoom(const std::shared_ptr<OutboundCore>& core, Actions& actions);

  [[nodiscard]] OutboundStats stats() const;
  /// The sessions among the subscribers, in the order in which they came.
  [[nodiscard]] std::vector<SessionId> Sessions() const;

  const std::string name;
  const std::string plain_topic;
  const TypeInfo& type;
  OutboundSource& source;  // Called through `gate` only.
  CallGate gate;
  std::atomic<std::size_t> subscribers{0};
  std::atomic<std::size_t> lossless{0};
  std::atomic<bool> refused{false};  // Reserve() has returned kFull since the source was last told of room.
  std::atomic<std::uint64_t> sent{0};
  std::atomic<std::uint64_t> dropped{0};
  std::atomic<std::uint64_t> missed{0};
  std::atomic<std::uint64_t> queued_bytes{0};
  std::atomic<std::uint64_t> copied{0};

 private:
  mutable std::mutex count_mutex_;
  std::vector<SessionId> sessions_;
  int plain_endpoints_ = 0;
};

}  // namespace hgros
