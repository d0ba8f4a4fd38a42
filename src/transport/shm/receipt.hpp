#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "transport/credit_window.hpp"
#include "transport/shm/memory/lane_reader.hpp"

namespace hgros::shm {

/// The credit of one link over shared memory: the publisher reads what was consumed in a cell of the slip.
///
/// A publisher that waits is woken when a quarter of the window was consumed since it was last woken, or when nothing
/// is in flight.
///
/// Thread safety: tokens may end anywhere; the rest belongs to the reading thread.
class Receipt : public TokenWindow<Receipt> {
 public:
  /// Takes a cell of the slip; null if it has none left.
  [[nodiscard]] static std::shared_ptr<Receipt> Make(const std::shared_ptr<Slip>& slip);
  ~Receipt();

  [[nodiscard]] std::uint32_t cell() const noexcept { return cell_; }

 private:
  friend class TokenWindow<Receipt>;
  Receipt(std::shared_ptr<Slip> slip, std::uint32_t cell) noexcept
      : TokenWindow(1, 1), slip_(std::move(slip)), cell_(cell) {}
  void OnConsumed(std::uint64_t bytes) noexcept;

  const std::shared_ptr<Slip> slip_;
  const std::uint32_t cell_;
};

}  // namespace hgros::shm
