#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "hgros/session/session.hpp"
#include "viewer/scene/display.hpp"

namespace hgros::viewer {

/// The newest message of a channel. The session's thread reads it, so that the drawing thread does not wait for large
/// messages. A message that was not taken before the next one arrives is dropped and counted.
///
/// Thread safety: none. The internal callback uses only what a mutex guards. Invariants: Take returns the result of
/// reading with the last options.
template <class Message, class Options, class Shown>
class NewestMessage {
 public:
  /// Returns what is wrong, as a sentence, or nothing.
  using Reader = std::function<std::string(const Message&, const Options&, Shown&)>;
  struct Read {
    Shown shown;
    std::string fault;                       ///< If it is not empty, nothing is shown.
    std::shared_ptr<const Message> message;  ///< The message that it was read from.
  };

  NewestMessage(const DisplayInputs& inputs, Options options, Reader read)
      : shared_(std::make_shared<Shared>(std::move(options), std::move(read))),
        subscription_(inputs.session.FromAny<Message>(
            inputs.channel, Invoke::kSerial,
            [shared = shared_, wake = inputs.wake](std::shared_ptr<const Message> message) {
              if (shared->Put(std::move(message))) wake();
            },
            {.queue = Queue::Latest()})) {}

  /// Sets the options. The calling thread reads the last message again.
  void SetOptions(Options options) {
    std::shared_ptr<const Message> last;
    again_ = true;
    {
      const std::scoped_lock lock(shared_->mutex);
      shared_->options = std::move(options);
      ++shared_->version;
      last = shared_->last;
    }
    if (last) (void)shared_->Put(std::move(last), true);
  }
  /// The message that has arrived since the last call.
  [[nodiscard]] std::optional<Read> Take() {
    const std::scoped_lock lock(shared_->mutex);
    if (shared_->waiting) {
      shown_ = shared_->last;
      again_ = false;
    }
    return std::exchange(shared_->waiting, std::nullopt);
  }
  /// The last taken message, read again with the current options. None if that is not necessary, or there is no
  /// message.
  [[nodiscard]] std::optional<Read> TakeAgain() {
    if (!shown_ || !std::exchange(again_, false)) return std::nullopt;
    Options with;
    {
      const std::scoped_lock lock(shared_->mutex);
      if (shared_->waiting && shared_->waiting->message == shown_) return std::exchange(shared_->waiting, std::nullopt);
      with = shared_->options;
    }
    Read again;
    again.fault = shared_->read(*shown_, with, again.shown);
    again.message = shown_;
    return again;
  }
  void Clear() {
    const std::scoped_lock lock(shared_->mutex);
    shared_->waiting.reset();
    shared_->last.reset();
    shown_.reset();
  }

  [[nodiscard]] std::uint64_t received() const {
    const std::scoped_lock lock(shared_->mutex);
    return shared_->received;
  }
  [[nodiscard]] std::uint64_t dropped() const {
    const std::scoped_lock lock(shared_->mutex);
    return shared_->dropped;
  }

 private:
  struct Shared {
    Shared(Options with, Reader reader) : read(std::move(reader)), options(std::move(with)) {}

    /// Returns whether the drawing thread must be woken.
    bool Put(std::shared_ptr<const Message> message, bool again = false) {
      for (;;) {
        Options with;
        std::uint64_t of = 0;
        {
          const std::scoped_lock lock(mutex);
          with = options;
          of = version;
        }
        Read result;
        result.fault = read(*message, with, result.shown);
        result.message = message;
        const std::scoped_lock lock(mutex);
        if (of != version) continue;
        if (again && message != last) return false;  // A newer message has arrived meanwhile.
        const bool first = !waiting;
        if (!again) {
          ++received;
          dropped += first ? 0 : 1;
        }
        waiting = std::move(result);
        last = std::move(message);
        return first;
      }
    }

    const Reader read;
    mutable std::mutex mutex;
    Options options;
    std::uint64_t version = 0;  ///< Version of the options.
    std::optional<Read> waiting;
    std::shared_ptr<const Message> last;
    std::uint64_t received = 0;
    std::uint64_t dropped = 0;
  };

  std::shared_ptr<Shared> shared_;
  std::shared_ptr<const Message> shown_;  ///< The last taken message; a newer one may wait.
  bool again_ = false;                    ///< The options have changed since it was read.
  Subscription subscription_;
};

}  // namespace hgros::viewer
