#include "transport/zmq/subscribe/link_credit.hpp"

#include <utility>

namespace hgros::zmq {

LinkCredit::LinkCredit(std::uint64_t window_messages, std::uint64_t window_bytes, std::string channel,
                       std::shared_ptr<DueCredits> due)
    : TokenWindow(window_messages, window_bytes), channel_(std::move(channel)), due_(std::move(due)) {
  if (due_) due_->Join();
}

LinkCredit::~LinkCredit() {
  if (due_) due_->Leave();
}

void LinkCredit::OnConsumed(std::uint64_t /*bytes*/) noexcept { AddIfDue(true); }

void LinkCredit::AddIfDue(bool wake) noexcept {
  if (due_ && IsDue() && !listed_.exchange(true)) due_->Add(weak_from_this(), wake);
}

bool LinkCredit::IsDue() const noexcept {
  if (untold_) return true;
  const Totals known = told();
  const Totals used = consumed();
  if (used.messages == known.messages) return false;
  if (IsQuarter({used.messages - known.messages, used.bytes - known.bytes})) return true;
  const Totals whole = window();
  return received() - known.messages >= whole.messages || received_bytes() - known.bytes >= whole.bytes;
}

bool LinkCredit::CollectNews(Totals& totals) noexcept {
  const Totals used = consumed();
  if (!untold_.exchange(false) && used.messages == told().messages) return false;
  SetTold(used);
  totals = used;
  return true;
}

void LinkCredit::ForgetTold() noexcept {
  untold_ = true;
  AddIfDue(false);
}

}  // namespace hgros::zmq
