#include "transport/zmq/unread_bytes.hpp"

#include <algorithm>

#include "hgros/base/memory_room.hpp"
#include "transport/zmq/connection.hpp"

namespace hgros::zmq {
namespace {

constexpr std::uint64_t kBetweenChecks = 256ULL << 10;
constexpr std::size_t kLeast = 4ULL << 20;
constexpr std::uint64_t kPartOfFreeMemory = 16;

}  // namespace

void UnreadBytes::Watch(int connection) {
  *this = {};
  const auto acked = connection < 0 ? std::nullopt : BytesAcknowledged(connection);
  if (!acked) return;
  connection_ = connection;
  acked_ = *acked;
}

bool UnreadBytes::Add(std::size_t bytes) {
  if (connection_ < 0) return false;
  sent_ += bytes;
  if (sent_ - checked_ < kBetweenChecks) return false;
  checked_ = sent_;
  const auto acked = BytesAcknowledged(connection_);
  if (!acked) return false;
  const std::uint64_t read = *acked - acked_;
  if (read >= sent_) {
    sent_ = checked_ = 0;
    acked_ = *acked;
    return false;
  }
  if (sent_ - read <= (most_ == 0 ? kLeast : most_)) return false;
  if (most_ == 0) {  // Found only now: that takes system calls, and most connections never come here.
    const auto free = FreeMemory();
    most_ = free ? std::clamp<std::size_t>(*free / kPartOfFreeMemory, kLeast, kMost) : kMost;
    if (sent_ - read <= most_) return false;
  }
  connection_ = -1;
  return true;
}

}  // namespace hgros::zmq
