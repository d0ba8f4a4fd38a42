#include "transport/zmq/link_credit.hpp"

#include <algorithm>
#include <utility>

namespace hgros::zmq {

struct LinkCredit::Token {
  Token(std::shared_ptr<LinkCredit> account, std::uint64_t size) : link(std::move(account)), bytes(size) {}
  ~Token() { link->Consume(bytes); }
  Token(const Token&) = delete;
  Token& operator=(const Token&) = delete;
  std::shared_ptr<LinkCredit> link;
  std::uint64_t bytes;
};

LinkCredit::LinkCredit(std::uint64_t window_messages, std::uint64_t window_bytes, std::shared_ptr<Waker> waker)
    : window_messages_(window_messages),
      window_bytes_(window_bytes),
      widest_messages_(window_messages),
      widest_bytes_(window_bytes),
      waker_(std::move(waker)) {}

std::shared_ptr<const void> LinkCredit::Take(std::uint64_t bytes) {
  auto token = std::make_shared<const Token>(shared_from_this(), bytes);
  received_messages_.fetch_add(1);
  received_bytes_.fetch_add(bytes);
  return token;
}

void LinkCredit::Skip(std::uint64_t bytes) noexcept {
  received_messages_.fetch_add(1);
  received_bytes_.fetch_add(bytes);
  Consume(bytes);
}

void LinkCredit::Consume(std::uint64_t bytes) noexcept {
  // Bytes first: who sees the message counted sees its bytes as well.
  consumed_bytes_.fetch_add(bytes);
  consumed_messages_.fetch_add(1);
  if (Due() && !woken_.exchange(true)) waker_->Wake();
}

bool LinkCredit::Due() const noexcept {
  const std::uint64_t told_messages = told_messages_.load();
  const std::uint64_t told_bytes = told_bytes_.load();
  const std::uint64_t news_messages = consumed_messages_.load() - told_messages;
  const std::uint64_t news_bytes = consumed_bytes_.load() - told_bytes;
  if (untold_) return true;
  if (news_messages == 0) return false;
  const std::uint64_t window_messages = window_messages_.load(std::memory_order_relaxed);
  const std::uint64_t window_bytes = window_bytes_.load(std::memory_order_relaxed);
  return news_messages * 4 >= window_messages || news_bytes * 4 >= window_bytes ||
         received_messages_.load() - told_messages >= window_messages ||
         received_bytes_.load() - told_bytes >= window_bytes;
}

bool LinkCredit::TellIfNews(Totals& consumed) noexcept {
  woken_.store(false);  // Before reading: what is consumed from here on wakes again.
  const std::uint64_t messages = consumed_messages_.load();
  const std::uint64_t bytes = consumed_bytes_.load();
  if (!untold_.exchange(false) && messages == told_messages_.load()) return false;
  told_messages_.store(messages);
  told_bytes_.store(bytes);
  consumed = {messages, bytes};
  return true;
}

void LinkCredit::SetWindow(std::uint64_t messages, std::uint64_t bytes) noexcept {
  window_messages_.store(messages, std::memory_order_relaxed);
  window_bytes_.store(bytes, std::memory_order_relaxed);
  widest_messages_ = std::max(widest_messages_, messages);
  widest_bytes_ = std::max(widest_bytes_, bytes);
}

bool LinkCredit::Within(std::uint64_t messages, std::uint64_t bytes) const noexcept {
  return received_messages_.load() - consumed_messages_.load() < messages &&
         received_bytes_.load() - consumed_bytes_.load() < bytes;
}

bool LinkCredit::HasRoom() const noexcept {
  return Within(window_messages_.load(std::memory_order_relaxed), window_bytes_.load(std::memory_order_relaxed));
}

bool LinkCredit::HadRoom() const noexcept { return Within(widest_messages_, widest_bytes_); }

}  // namespace hgros::zmq
