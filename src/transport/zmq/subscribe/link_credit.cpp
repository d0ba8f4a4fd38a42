#include "transport/zmq/subscribe/link_credit.hpp"

namespace hgros::zmq {

void LinkCredit::OnConsumed(std::uint64_t /*bytes*/) noexcept {
  if (IsDue() && !woken_.exchange(true)) waker_->Wake();
}

bool LinkCredit::IsDue() const noexcept {
  const Totals known = told();
  const Totals used = consumed();
  if (untold_) return true;
  if (used.messages == known.messages) return false;
  if (IsQuarter({used.messages - known.messages, used.bytes - known.bytes})) return true;
  const Totals whole = window();
  return received() - known.messages >= whole.messages || received_bytes() - known.bytes >= whole.bytes;
}

bool LinkCredit::CollectNews(Totals& totals) noexcept {
  woken_.store(false);  // Stored before the counts are read: messages consumed after this wake again.
  const Totals used = consumed();
  if (!untold_.exchange(false) && used.messages == told().messages) return false;
  SetTold(used);
  totals = used;
  return true;
}

}  // namespace hgros::zmq
