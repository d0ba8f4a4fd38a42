#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "transport/shm/lane_reader.hpp"

namespace hgros::shm {

/// The receiving side's account of one link: what came, what was consumed. The publisher reads the sums in the slip,
/// and is woken, if it waits, when a quarter of the window was consumed since it was last woken or when nothing is
/// left.
///
/// Thread safety: tokens may end anywhere; Take(), SetWindow() and HasRoom() belong to the reading thread.
class Receipt : public std::enable_shared_from_this<Receipt> {
 public:
  /// Takes a cell of the slip; null if it has none left.
  [[nodiscard]] static std::shared_ptr<Receipt> Make(const std::shared_ptr<Slip>& slip);
  ~Receipt();
  Receipt(const Receipt&) = delete;
  Receipt& operator=(const Receipt&) = delete;

  [[nodiscard]] std::uint32_t cell() const noexcept { return cell_; }
  /// Counts a message as received; the end of the token counts it as consumed.
  [[nodiscard]] std::shared_ptr<const void> Take(std::uint64_t bytes);
  /// A publisher that keeps to the widest window so far may send one more message.
  [[nodiscard]] bool HasRoom() const noexcept;
  void SetWindow(std::uint64_t messages, std::uint64_t bytes) noexcept;
  [[nodiscard]] std::uint64_t received() const noexcept { return received_messages_.load(std::memory_order_relaxed); }

 private:
  struct Token;
  Receipt(std::shared_ptr<Slip> slip, std::uint32_t cell) noexcept : slip_(std::move(slip)), cell_(cell) {}
  void Consume(std::uint64_t bytes) noexcept;

  const std::shared_ptr<Slip> slip_;
  const std::uint32_t cell_;
  std::atomic<std::uint64_t> window_messages_{1};
  std::atomic<std::uint64_t> window_bytes_{1};
  std::uint64_t widest_messages_ = 1;
  std::uint64_t widest_bytes_ = 1;
  std::atomic<std::uint64_t> received_messages_{0};
  std::atomic<std::uint64_t> received_bytes_{0};
  std::atomic<std::uint64_t> consumed_messages_{0};
  std::atomic<std::uint64_t> consumed_bytes_{0};
  std::atomic<std::uint64_t> told_messages_{0};
  std::atomic<std::uint64_t> told_bytes_{0};
};

}  // namespace hgros::shm
