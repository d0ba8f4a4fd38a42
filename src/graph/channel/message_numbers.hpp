#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>

#include "hgros/base/message_key.hpp"
#include "hgros/base/thread_cause.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/graph/message_info.hpp"

namespace hgros {

// What the local messages of one channel get: numbers from 1 without gaps, keys, and causes.
//
// Thread safety: all functions.
class MessageNumbers {
 public:
  MessageNumbers(std::string_view channel, const MessageId& publisher)
      : origin_(Cause::OriginOf(channel)), key_seed_(KeySeed(publisher.publisher, publisher.incarnation, origin_)) {}

  // All of it except the numbers and the key.
  [[nodiscard]] MessageInfo NewInfo(const MessageId& publisher) const noexcept {
    MessageInfo info;
    info.id = publisher;
    info.publish_monotonic_ns = MonotonicNow();
    const Cause* const here = thread_cause;
    info.cause = here == nullptr || here->message == 0 ? Beginning(info) : *here;
    return info;
  }
  void Number(MessageInfo& info) noexcept {
    info.id.sequence = last_.fetch_add(1, std::memory_order_relaxed) + 1;
    info.number = info.id.sequence;
    info.key = MessageKey(key_seed_, info.number);
  }
  // Of a message that begins a chain.
  [[nodiscard]] Cause Beginning(const MessageInfo& info) const noexcept {
    return {0, info.publish_monotonic_ns, origin_};
  }
  [[nodiscard]] std::uint64_t last() const noexcept { return last_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> last_{0};
  const std::uint32_t origin_;  // Of chains that begin here.
  const std::uint64_t key_seed_;
};

}  // namespace hgros
