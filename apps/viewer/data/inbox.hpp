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

/// Messages that wait for the drawing thread: the newest `depth`, with at most `most_bytes`. Older ones are dropped and
/// counted. The newest message always stays, even if it is larger. Thread-safe.
template <class T>
class Inbox {
 public:
  using Message = std::shared_ptr<const T>;
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20U;

  explicit Inbox(std::size_t depth, std::size_t most_bytes = kMostBytes) : depth_(depth), most_bytes_(most_bytes) {}

  /// Returns whether it was empty before, so that the drawing thread must be woken. `bytes` is the size of the message.
  bool Put(Message message, std::size_t bytes = 0) {
    const std::scoped_lock lock(mutex_);
    const bool first = messages_.empty();
    while (!messages_.empty() && (messages_.size() == depth_ || bytes_ + bytes > most_bytes_)) DropOldest();
    messages_.push_back({std::move(message), bytes});
    bytes_ += bytes;
    ++received_;
    return first;
  }

  /// Takes all messages, oldest first. If there are more than `most`, the older ones are dropped.
  [[nodiscard]] std::vector<Message> TakeAll(std::size_t most = std::numeric_limits<std::size_t>::max()) {
    const std::scoped_lock lock(mutex_);
    while (messages_.size() > most) DropOldest();
    std::vector<Message> taken;
    taken.reserve(messages_.size());
    for (Waiting& waiting : messages_) taken.push_back(std::move(waiting.message));
    messages_.clear();
    bytes_ = 0;
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
  struct Waiting {
    Message message;
    std::size_t bytes;
  };

  void DropOldest() {
    bytes_ -= messages_.front().bytes;
    messages_.pop_front();
    ++dropped_;
  }

  const std::size_t depth_, most_bytes_;
  mutable std::mutex mutex_;
  std::deque<Waiting> messages_;
  std::size_t bytes_ = 0;
  std::uint64_t received_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace hgros::viewer
