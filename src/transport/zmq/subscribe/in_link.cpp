#include "transport/zmq/subscribe/in_link.hpp"

#include <algorithm>

namespace hgros::zmq {
namespace {

// When a link ends, its messages stay in flight, and the next link has a new window. A publisher that begins one link
// after another gets at most this number of windows in flight.
constexpr std::uint64_t kWindowsInFlight = 4;

}  // namespace

void InLink::Begin(const wire::Subscribed& answer, const std::shared_ptr<DueCredits>& due) {
  End();
  id = answer.link();
  fingerprint = answer.offered().fingerprint();
  credit = std::make_shared<LinkCredit>(std::min<std::uint64_t>(answer.credit_messages(), asked_messages),
                                        std::min(answer.credit_bytes(), asked_bytes), core->name, due);
}

void InLink::SetWindow(const wire::Subscribed& answer) {
  credit->SetWindow(std::min<std::uint64_t>(answer.credit_messages(), asked_messages),
                    std::min(answer.credit_bytes(), asked_bytes));
  credit->ForgetTold();
}

void InLink::End() {
  id = 0;
  const std::weak_ptr<LinkCredit> ended = credit;
  credit.reset();
  if (!ended.expired()) earlier.push_back(ended);
}

bool InLink::IsCrowded() {
  if (earlier.empty()) return false;
  std::erase_if(earlier, [](const auto& one) { return one.expired(); });
  LinkCredit::Totals sum = credit->in_flight();
  for (const auto& one : earlier) {
    if (const auto account = one.lock()) {
      const auto left = account->in_flight();
      sum.messages += left.messages;
      sum.bytes += left.bytes;
    }
  }
  return sum.messages / kWindowsInFlight >= asked_messages || sum.bytes / kWindowsInFlight >= asked_bytes;
}

void InLink::SetPlainWindow() {
  if (!plain_credit) return;
  // A session would keep the rest of the queue's depth on its side; a plain publisher keeps nothing.
  const Demand demand = core->demand();
  plain_credit->SetWindow(std::max({demand.credit_messages, demand.queue_depth, 1u}),
                          std::max<std::uint64_t>(demand.credit_bytes, 1));
}

}  // namespace hgros::zmq
