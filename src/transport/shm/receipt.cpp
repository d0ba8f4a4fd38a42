#include "transport/shm/receipt.hpp"

#include <algorithm>
#include <utility>

namespace hgros::shm {

struct Receipt::Token {
  Token(std::shared_ptr<Receipt> account, std::uint64_t size) : receipt(std::move(account)), bytes(size) {}
  ~Token() { receipt->Consume(bytes); }
  Token(const Token&) = delete;
  Token& operator=(const Token&) = delete;
  const std::shared_ptr<Receipt> receipt;
  const std::uint64_t bytes;
};

std::shared_ptr<Receipt> Receipt::Make(const std::shared_ptr<Slip>& slip) {
  const auto cell = slip->TakeCell();
  if (!cell) return nullptr;
  return std::shared_ptr<Receipt>(new Receipt(slip, *cell));
}

Receipt::~Receipt() { slip_->FreeCell(cell_); }

std::shared_ptr<const void> Receipt::Take(std::uint64_t bytes) {
  auto token = std::make_shared<const Token>(shared_from_this(), bytes);
  received_messages_.fetch_add(1);
  received_bytes_.fetch_add(bytes);
  return token;
}

void Receipt::Consume(std::uint64_t bytes) noexcept {
  // Our own sums first: a publisher that reads the slip may send the next message at once, and HasRoom() is to know
  // why. The slip's sums decide who tells: of several threads the last one has all of them counted there.
  consumed_bytes_.fetch_add(bytes);
  consumed_messages_.fetch_add(1);
  const auto [total, total_bytes] = slip_->Count(cell_, bytes);
  const bool quarter = (total - told_messages_.load()) * 4 >= window_messages_.load(std::memory_order_relaxed) ||
                       (total_bytes - told_bytes_.load()) * 4 >= window_bytes_.load(std::memory_order_relaxed);
  if (!quarter && total != received_messages_.load()) return;
  told_messages_.store(total);
  told_bytes_.store(total_bytes);
  slip_->TellIfHungry(kForCredit);
}

bool Receipt::HasRoom() const noexcept {
  return received_messages_.load() - consumed_messages_.load() < widest_messages_ &&
         received_bytes_.load() - consumed_bytes_.load() < widest_bytes_;
}

void Receipt::SetWindow(std::uint64_t messages, std::uint64_t bytes) noexcept {
  window_messages_.store(messages, std::memory_order_relaxed);
  window_bytes_.store(bytes, std::memory_order_relaxed);
  widest_messages_ = std::max(widest_messages_, messages);
  widest_bytes_ = std::max(widest_bytes_, bytes);
}

}  // namespace hgros::shm
