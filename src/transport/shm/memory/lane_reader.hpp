#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hgros/base/fork_guard.hpp"
#include "transport/shm/memory/bell.hpp"
#include "transport/shm/memory/layout.hpp"
#include "transport/shm/memory/memory.hpp"

namespace hgros::shm {

/// The receiving session's page for one publishing session: returns slots and counts consumed messages. It lives as
/// long as any message of that publisher, and keeps the socket open until then. The end of the socket shows the
/// publisher that nothing is read any more.
///
/// Thread safety: all functions. Invariants: each slot that was read from the lane is returned once. In a forked child
/// nothing is returned, counted or closed: page and socket belong to the parent.
class Slip {
 public:
  ~Slip();
  Slip(const Slip&) = delete;
  Slip& operator=(const Slip&) = delete;
  /// Null, and `fault` is set, if there is no shared memory.
  [[nodiscard]] static std::shared_ptr<Slip> Make(std::shared_ptr<const Handle> socket,
                                                  std::shared_ptr<const ForkGuard> fork, std::string& fault);

  [[nodiscard]] const std::shared_ptr<const Handle>& handle() const noexcept { return handle_; }
  /// Called once, before the first descriptor is read.
  void SetPublisher(std::shared_ptr<Mapping> lane, std::shared_ptr<const PeerBell> bell);

  /// Counts a slot that was read and is not returned yet.
  void Hold() noexcept { held_.fetch_add(1, std::memory_order_relaxed); }
  [[nodiscard]] std::size_t held() const noexcept { return held_.load(std::memory_order_relaxed); }
  void Return(std::uint32_t slot) noexcept;

  /// Takes a free cell and sets its counters to zero; none if all are in use.
  [[nodiscard]] std::optional<std::uint32_t> AllocateCell();
  void FreeCell(std::uint32_t cell) noexcept;
  struct Counted {
    std::uint64_t messages = 0;
    std::uint64_t bytes = 0;
  };
  /// Counts one more consumed message, and returns the totals. A caller that sees the last message also sees all bytes.
  Counted Count(std::uint32_t cell, std::uint64_t bytes) noexcept;
  /// Rings the publisher's bell if it waits for this: kForCredit or kForSlots.
  void TellIfHungry(std::uint32_t what) const noexcept;
  void Beat() noexcept { page().heartbeat.fetch_add(1, std::memory_order_relaxed); }

 private:
  Slip(Segment segment, std::shared_ptr<const Handle> socket, std::shared_ptr<const ForkGuard> fork);
  [[nodiscard]] SlipPage& page() const noexcept { return mapping_->as<SlipPage>(); }

  const std::shared_ptr<Mapping> mapping_;
  const std::shared_ptr<const Handle> handle_;
  const std::shared_ptr<const Handle> socket_;
  const std::shared_ptr<const ForkGuard> fork_;
  std::shared_ptr<Mapping> lane_;
  std::shared_ptr<const PeerBell> bell_;
  std::atomic<std::size_t> held_{0};
  std::mutex mutex_;                       // Guards the ring of slots and the cells that are free.
  std::uint32_t used_cells_ = 0;           // Cells from here on were never used, so their memory is not touched.
  std::vector<std::uint32_t> free_cells_;  // Used before.
};

/// The receiving end of the lane from one peer.
/// Thread safety: none; one thread reads.
class LaneReader {
 public:
  /// Null, and `fault` is set, if `lane` is not a lane.
  [[nodiscard]] static std::unique_ptr<LaneReader> Open(const Handle& lane, std::string& fault);

  enum class Read { kNothing, kDescriptor, kLie };
  /// Copies the next descriptor without consuming it.
  [[nodiscard]] Read Peek(Descriptor& descriptor) noexcept;
  void Next() noexcept { ++read_; }
  [[nodiscard]] std::uint32_t peer_heartbeat() const noexcept {
    return mapping_->as<LanePage>().heartbeat.load(std::memory_order_relaxed);
  }
  [[nodiscard]] const std::shared_ptr<Mapping>& mapping() const noexcept { return mapping_; }

 private:
  explicit LaneReader(std::shared_ptr<Mapping> mapping) noexcept : mapping_(std::move(mapping)) {}
  const std::shared_ptr<Mapping> mapping_;
  std::uint64_t read_ = 0;
};

}  // namespace hgros::shm
