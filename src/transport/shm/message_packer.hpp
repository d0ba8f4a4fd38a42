#pragma once

#include <memory>
#include <optional>

#include "hgros/internal/codec/packet.hpp"
#include "transport/shm/out_link.hpp"
#include "transport/shm/shm_session.hpp"

namespace hgros::shm {

/// Puts each message into the shared memory of this session, once for all its receivers.
///
/// Thread safety: all functions. Invariants: bytes that are already in the pool are not copied; bytes without an
/// owner are always copied.
class MessagePacker {
 public:
  explicit MessagePacker(ShmSession& session)
      : session_(session), pool_(std::make_shared<BlockPool>(session.options.limit_bytes)) {}

  /// The result has no place if there is no shared memory left; this is logged. Throws std::bad_alloc if there is no
  /// memory at all.
  [[nodiscard]] std::shared_ptr<const ShmMessage> Pack(const PacketHead& head, const Payload& data);
  /// Nothing if there is no shared memory left.
  [[nodiscard]] std::optional<Block> Loan(std::size_t size_bytes);

  [[nodiscard]] BlockPool& pool() const noexcept { return *pool_; }

 private:
  ShmSession& session_;
  const std::shared_ptr<BlockPool> pool_;
};

}  // namespace hgros::shm
