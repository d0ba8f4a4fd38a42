#include "transport/credit_window.hpp"

#include <algorithm>

namespace hgros {

CreditWindow::Totals CreditWindow::in_flight() const noexcept {
  // Read the consumed counts first: they may grow meanwhile.
  const Totals consumed{consumed_messages_.load(), consumed_bytes_.load()};
  return {received_messages_.load() - consumed.messages, received_bytes_.load() - consumed.bytes};
}

bool CreditWindow::IsInFlightBelow(std::uint64_t messages, std::uint64_t bytes) const noexcept {
  return received_messages_.load() - consumed_messages_.load() < messages &&
         received_bytes_.load() - consumed_bytes_.load() < bytes;
}

bool CreditWindow::HasRoomNow() const noexcept {
  const Totals now = window();
  return IsInFlightBelow(now.messages, now.bytes);
}

void CreditWindow::SetWindow(std::uint64_t messages, std::uint64_t bytes) noexcept {
  window_messages_.store(messages, std::memory_order_relaxed);
  window_bytes_.store(bytes, std::memory_order_relaxed);
  Widen(messages, bytes);
}

void CreditWindow::Widen(std::uint64_t messages, std::uint64_t bytes) noexcept {
  widest_messages_ = std::max(widest_messages_, messages);
  widest_bytes_ = std::max(widest_bytes_, bytes);
}

}  // namespace hgros
