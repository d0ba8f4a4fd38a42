#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <random>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/clock/time.hpp"
#include "hgros/transport/shm_transport.hpp"

namespace hgros::resilience {

// Messages that carry their number, so that a receiver detects lost and damaged ones.

inline const TypeInfo& NumberType() {
  static const TypeInfo type = [] {
    TypeInfo made;
    made.name = "hgros.test.Number";
    made.encoding = Encoding::kCustom;
    return made;
  }();
  return type;
}

inline ShmOptions NumberOptions(const std::string& process) {
  ShmOptions options;
  options.process = process;
  options.heartbeat = std::chrono::milliseconds(100);
  options.peer_timeout = std::chrono::milliseconds(2000);
  options.limit_bytes = 16 << 20;
  options.linger = std::chrono::milliseconds(100);
  return options;
}

class QuietListener : public TransportListener {
 public:
  void OnPeerCame(const PeerInfo&) noexcept override {}
  void OnPeerGone(const PeerInfo&, std::string_view) noexcept override { ++gone; }
  void OnTypeMismatch(std::string_view, const PeerInfo&, std::string_view) noexcept override {}
  std::atomic<int> gone{0};
};

/// Publishes 1, 2, 3 ... in messages of all sizes, or of at least `least_bytes`.
class NumberStream : public OutboundSource {
 public:
  NumberStream(Transport& transport, const std::string& channel, std::size_t largest_bytes = 100'000,
               std::size_t least_bytes = 0)
      : channel_name_(channel), largest_bytes_(largest_bytes), least_bytes_(least_bytes) {
    static std::atomic<std::uint64_t> incarnation{static_cast<std::uint64_t>(MonotonicNow())};
    incarnation_ = ++incarnation;
    channel_ = transport.Advertise(channel, NumberType(), *this);
  }
  std::vector<OutboundMessage> Latched(SessionId /*subscriber*/) noexcept override { return {}; }
  void OnRoom() noexcept override {
    {
      const std::scoped_lock lock(mutex_);
      ++rooms_;
    }
    room_.notify_all();
  }
  void OnSubscribers(std::size_t) noexcept override { OnRoom(); }

  /// Publishes the next number; waits while there is no subscriber. False after a stop.
  bool PublishNext(const std::stop_token& stop) {
    for (;;) {
      std::unique_lock lock(mutex_);
      const auto seen = rooms_;
      lock.unlock();
      if (channel_->subscriber_count() > 0 && channel_->Reserve() == PublishStatus::kOk) break;
      lock.lock();
      if (!room_.wait(lock, stop, [&] { return rooms_ != seen; })) return false;
    }
    const std::uint64_t number = published + 1;
    const std::size_t extra = random_() % 20 == 0 ? random_() % largest_bytes_ : random_() % 200;
    std::string bytes(sizeof number + std::clamp(extra, least_bytes_, largest_bytes_), static_cast<char>(number));
    std::memcpy(bytes.data(), &number, sizeof number);
    PacketHead head;
    head.channel = channel_name_;
    head.type_name = NumberType().name;
    head.encoding = Encoding::kCustom;
    head.id = {0, incarnation_, number};
    channel_->Commit(head, {AsBytes(bytes), nullptr});
    published = number;
    return true;
  }
  [[nodiscard]] OutboundChannel& channel() { return *channel_; }
  std::atomic<std::uint64_t> published{0};

 private:
  const std::string channel_name_;
  const std::size_t largest_bytes_;
  const std::size_t least_bytes_;
  std::uint64_t incarnation_ = 0;
  std::minstd_rand random_{7};
  std::mutex mutex_;
  std::condition_variable_any room_;
  std::uint64_t rooms_ = 0;  // Guarded by mutex_.
  std::unique_ptr<OutboundChannel> channel_;
};

/// Checks the messages of each session: their numbers follow each other, and their data are whole. It keeps the last
/// messages, and checks each again when it releases it.
class NumberSink : public InboundSink {
 public:
  explicit NumberSink(std::size_t most_held = 20) : most_held_(most_held) {}
  Accepted Accept(InboundMessage&& message) noexcept override {
    const std::uint64_t number = NumberOf(message);
    {
      const std::scoped_lock lock(mutex_);
      std::uint64_t& last = last_[{message.from.value, message.head.id.incarnation}];
      if (!Whole(message) || (last != 0 && number != last + 1)) ++faults;
      last = number;
    }
    held_.push_back(std::move(message));
    if (held_.size() > most_held_) {
      if (!Whole(held_.front())) ++faults;
      held_.pop_front();
    }
    ++received;
    return Accepted::kNothing;
  }
  void Run() noexcept override {}
  void OnFault(PacketFault, std::string_view) noexcept override { ++faults; }
  void OnPublishers(std::size_t count) noexcept override { publishers = count; }
  /// Only when no more messages come.
  void LetGo() { held_.clear(); }
  [[nodiscard]] std::uint64_t last_of(SessionId session) const {
    const std::scoped_lock lock(mutex_);
    const auto first = last_.lower_bound({session.value, 0});
    return first != last_.end() && first->first.first == session.value ? first->second : 0;
  }

  std::atomic<std::uint64_t> received{0};
  std::atomic<std::uint64_t> faults{0};
  std::atomic<std::size_t> publishers{0};

 private:
  static std::uint64_t NumberOf(const InboundMessage& message) {
    std::uint64_t number = 0;
    if (message.data.bytes.size() >= sizeof number) std::memcpy(&number, message.data.bytes.data(), sizeof number);
    return number;
  }
  static bool Whole(const InboundMessage& message) {
    const Bytes bytes = message.data.bytes;
    if (bytes.size() < 8) return false;
    const std::string_view rest = AsText(bytes.subspan(8));
    // Without a loop of its own, which takes long without optimization: all are equal if each equals the next.
    return rest.empty() ||
           (rest.front() == static_cast<char>(NumberOf(message)) && rest.substr(1) == rest.substr(0, rest.size() - 1));
  }
  const std::size_t most_held_;
  mutable std::mutex mutex_;
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::uint64_t> last_;  // Guarded by mutex_.
  std::deque<InboundMessage> held_;
};

}  // namespace hgros::resilience
