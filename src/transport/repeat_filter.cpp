#include "transport/repeat_filter.hpp"

namespace hgros {
namespace {

// A peer could invent publishers. Above this number all are forgotten, so that memory does not grow.
constexpr std::size_t kMaxPublishers = 1024;

}  // namespace

bool RepeatFilter::Pass(SessionId from, const MessageId& id) {
  if (id.publisher == 0 || id.sequence == 0) return true;
  const std::pair key(from.value, id.publisher);
  auto found = publishers_.find(key);
  if (found == publishers_.end()) {
    if (publishers_.size() >= kMaxPublishers) publishers_.clear();
    found = publishers_.emplace(key, Seen{.incarnation = id.incarnation}).first;
  }
  Seen& seen = found->second;
  if (id.incarnation < seen.incarnation) return false;
  if (id.incarnation > seen.incarnation) seen = Seen{.incarnation = id.incarnation};

  const auto word = [](std::uint64_t sequence) { return static_cast<std::size_t>(sequence % kWindow / 64); };
  const auto bit = [](std::uint64_t sequence) { return std::uint64_t{1} << (sequence % 64); };
  if (id.sequence > seen.highest) {
    if (id.sequence - seen.highest >= kWindow) {
      seen.bits.fill(0);
    } else {
      for (std::uint64_t s = seen.highest + 1; s < id.sequence; ++s) seen.bits[word(s)] &= ~bit(s);
    }
    seen.highest = id.sequence;
    seen.bits[word(id.sequence)] |= bit(id.sequence);
    return true;
  }
  if (seen.highest - id.sequence >= kWindow) return false;
  if ((seen.bits[word(id.sequence)] & bit(id.sequence)) != 0) return false;
  seen.bits[word(id.sequence)] |= bit(id.sequence);
  return true;
}

}  // namespace hgros
