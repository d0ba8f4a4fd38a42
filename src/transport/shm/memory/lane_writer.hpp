#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hgros/base/bytes.hpp"
#include "transport/shm/memory/layout.hpp"
#include "transport/shm/memory/memory.hpp"

namespace hgros::shm {

/// The publishing end of the lane to one peer: writes descriptors, keeps their messages until the peer has returned
/// them, and reads how much the peer has consumed.
///
/// Thread safety: none; its owner guards it. Invariants: every slot is free, or holds the owner of one message's bytes.
class LaneWriter {
 public:
  /// Null, and `fault` is set, if there is no shared memory.
  [[nodiscard]] static std::unique_ptr<LaneWriter> Make(std::string& fault);

  /// The page's descriptor, which is sent to the peer.
  [[nodiscard]] const std::shared_ptr<const Handle>& handle() const noexcept { return handle_; }
  /// Maps the peer's slip. False, and `fault` is set, if it is not a slip.
  [[nodiscard]] bool Open(const Handle& slip, std::string& fault);

  [[nodiscard]] bool HasSlot() const noexcept { return slip_ && !free_.empty(); }
  /// Needs a free slot. Sets `descriptor.slot`.
  void Write(Descriptor descriptor, std::shared_ptr<const void> owner) noexcept;
  struct Held {
    Descriptor descriptor;
    std::shared_ptr<const void> owner;
  };
  /// The messages in that segment that the peer has not returned, oldest first; each one once.
  [[nodiscard]] std::vector<Held> TakeHeldIn(std::uint32_t segment);
  /// Frees the slots that the peer has returned, and moves their owners to `ended`. False if a returned slot was not
  /// in use, or more came back than were sent.
  [[nodiscard]] bool Collect(std::vector<std::shared_ptr<const void>>& ended);
  /// The events for which the peer should ring: kForCredit | kForSlots; 0: none. Call Collect() and read the cells
  /// after this.
  void SetHungry(std::uint32_t hungry) noexcept;
  [[nodiscard]] std::uint32_t hungry() const noexcept { return hungry_; }

  struct Consumed {
    std::uint64_t messages = 0;
    std::uint64_t bytes = 0;
  };
  /// The totals that the peer has consumed on the link with this cell.
  [[nodiscard]] Consumed ConsumedOf(std::uint32_t cell) const noexcept;

  void Beat() noexcept { page().heartbeat.fetch_add(1, std::memory_order_relaxed); }
  [[nodiscard]] std::uint32_t peer_heartbeat() const noexcept;
  /// Messages that the peer still holds.
  [[nodiscard]] std::size_t held() const noexcept { return kSlots - free_.size(); }

 private:
  explicit LaneWriter(Segment lane);
  [[nodiscard]] LanePage& page() const noexcept { return lane_->as<LanePage>(); }

  const std::shared_ptr<Mapping> lane_;
  const std::shared_ptr<const Handle> handle_;
  std::shared_ptr<Mapping> slip_;
  std::uint64_t written_ = 0;
  std::uint64_t collected_ = 0;
  std::uint32_t hungry_ = 0;
  std::vector<std::uint32_t> free_;
  std::array<std::shared_ptr<const void>, kSlots> owners_;
  std::array<bool, kSlots> used_{};
  std::array<std::uint64_t, kSlots> taken_{};  // By slot, the last descriptor that TakeHeldIn() returned; 0: none.
};

}  // namespace hgros::shm
