#pragma once

#include <memory>
#include <optional>

#include "hgros/internal/codec/packet.hpp"
#include "transport/shm/out_link.hpp"
#include "transport/shm/shm_session.hpp"

namespace hgros::shm {

/// Puts messages into the shared memory of this session, once for all their receivers.
///
/// Thread safety: all functions. Invariants: bytes that lie in the pool already are not copied; bytes that the caller
/// does not share (no owner) always are.
class MessagePacker {
 public:
  explicit MessagePacker(ShmSession& session)
      : session_(session), pool_(std::make_shared<BlockPool>(session.options.limit_bytes)) {}

  /// Without a place if there is no shared memory left; that is logged.
  [[nodiscard]] std::shared_ptr<const ShmMessage> Pack(const PacketHead& head, const Payload& data);
  /// Nothing if there is no shared memory left.
  [[nodiscard]] std::optional<Block> Loan(std::size_t size_bytes);

  [[nodiscard]] BlockPool& pool() const noexcept { return *pool_; }

 private:
  ShmSession& session_;
  const std::shared_ptr<BlockPool> pool_;
};

}  // namespace hgros::shm
