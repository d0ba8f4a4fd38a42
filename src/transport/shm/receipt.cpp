#include "transport/shm/receipt.hpp"

namespace hgros::shm {

std::shared_ptr<Receipt> Receipt::Make(const std::shared_ptr<Slip>& slip) {
  const auto cell = slip->AllocateCell();
  if (!cell) return nullptr;
  return std::shared_ptr<Receipt>(new Receipt(slip, *cell));
}

Receipt::~Receipt() { slip_->FreeCell(cell_); }

// Our own sums were counted first: a publisher that reads the slip may send the next message at once, and then
// HasRoom() must already know it. The slip's sums decide which thread rings: if several threads count at once, the
// last one sees all of them there.
void Receipt::OnConsumed(std::uint64_t bytes) noexcept {
  const auto [messages, total_bytes] = slip_->Count(cell_, bytes);
  const Totals known = told();
  if (!IsQuarter({messages - known.messages, total_bytes - known.bytes}) && messages != received()) return;
  SetTold({messages, total_bytes});
  slip_->TellIfHungry(kForCredit);
}

}  // namespace hgros::shm
