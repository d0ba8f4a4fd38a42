#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace hgros::viewer {

/// Where messages wait for the thread that draws: the newest `depth`; older ones are dropped and counted.
/// Thread safety: all of it.
template <class T>
class Inbox {
 public:
  using Message = std::shared_ptr<const T>;

  explicit Inbox(std::size_t depth) : depth_(depth) {}

  /// Whether it was empty before, so that somebody has to be told.
  bool Put(Message message) {
    const std::scoped_lock lock(mutex_);
    const bool first = messages_.empty();
    if (messages_.size() == depth_) {
      messages_.pop_front();
      ++dropped_;
    }
    messages_.push_back(std::move(message));
    ++received_;
    return first;
  }

  /// All that wait, oldest first; only the newest `most` if there are more, and the others are dropped.
  [[nodiscard]] std::vector<Message> TakeAll(std::size_t most = std::numeric_limits<std::size_t>::max()) {
    const std::scoped_lock lock(mutex_);
    for (; messages_.size() > most; messages_.pop_front()) ++dropped_;
    std::vector<Message> taken(std::make_move_iterator(messages_.begin()), std::make_move_iterator(messages_.end()));
    messages_.clear();
    return taken;
  }

  [[nodiscard]] std::uint64_t received() const {
    const std::scoped_lock lock(mutex_);
    return received_;
  }
  [[nodiscard]] std::uint64_t dropped() const {
    const std::scoped_lock lock(mutex_);
    return dropped_;
  }

 private:
  const std::size_t depth_;
  mutable std::mutex mutex_;
  std::deque<Message> messages_;
  std::uint64_t received_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace hgros::viewer
