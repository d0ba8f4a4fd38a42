#pragma once

#include <chrono>
#include <concepts>
#include <memory>
#include <stop_token>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/base/publish_status.hpp"
#include "hgros/codec/message.hpp"

namespace hgros {

class Channel;

/// How far a published message goes.
enum class Reach {
  kGraph,  ///< To this process' nodes only.
  kAny,    ///< To whoever subscribes, anywhere.
};

/// A message that is about to be published: it changes hands only once every lossless subscriber has room for it.
struct MessageOffer {
  const void* message;
  AnyMessage (*take)(void* context);
  void* context;
  const TypeInfo& (*type)();  ///< Asked only on channels that are used with two types.
};

/// The wires behind Publisher and the named calls. Thread-safe, never blocks, never throws.
HGROS_EXPORT PublishStatus Publish(Channel& channel, const MessageOffer& offer, Reach reach) noexcept;
/// Likewise, but waits for room until `deadline` or a stop request; kWouldDeadlock instead of waiting inside a
/// callback or on a library thread.
HGROS_EXPORT PublishStatus PublishWait(Channel& channel, const MessageOffer& offer, Reach reach,
                                       std::chrono::steady_clock::time_point deadline, const std::stop_token& stop);

/// Offers a message that the caller owns alone; it is moved from only if it is taken.
template <class T>
[[nodiscard]] MessageOffer OfferOf(std::unique_ptr<T>& message) noexcept {
  return {message.get(),
          [](void* context) -> AnyMessage {
            return std::shared_ptr<const T>(std::move(*static_cast<std::unique_ptr<T>*>(context)));
          },
          &message, &TypeOf<T>};
}

/// Offers a message that may be shared already; the pointer is copied if it is taken.
template <class T>
[[nodiscard]] MessageOffer OfferOf(const std::shared_ptr<const T>& message) noexcept {
  return {message.get(),
          [](void* context) -> AnyMessage { return *static_cast<const std::shared_ptr<const T>*>(context); },
          const_cast<std::shared_ptr<const T>*>(&message), &TypeOf<T>};
}

/// Publishes on one channel without looking its name up each time. Copying shares; a handle that outlives its session
/// (or graph), or never had one, answers kClosed. Thread-safe.
template <class T>
class Publisher {
 public:
  Publisher() = default;
  /// For DataGraph and Session, which have compared T with the channel's type.
  Publisher(std::shared_ptr<Channel> channel, Reach reach) : channel_(std::move(channel)), reach_(reach) {}

  /// Hands the message to every subscriber. On kFull, kClosed nobody got it and `message` still owns it.
  /// Ordering: what is published one after the other arrives so everywhere. What an inline callback publishes on the
  /// channel that it is called for is therefore handed over only after everybody has got the message of that call.
  PublishStatus operator()(std::unique_ptr<T>&& message) const {
    return channel_ ? Publish(*channel_, OfferOf<T>(message), reach_) : PublishStatus::kClosed;
  }
  PublishStatus operator()(const std::shared_ptr<const T>& message) const {
    return channel_ ? Publish(*channel_, OfferOf<T>(message), reach_) : PublishStatus::kClosed;
  }

  /// A copy of `message`, for small ones.
  PublishStatus operator()(const T& message) const requires std::copy_constructible<T> {
    return (*this)(std::make_unique<T>(message));
  }

  /// As the first two, but waits for room in lossless subscribers: until `deadline`, or until `stop` is requested.
  PublishStatus Wait(std::unique_ptr<T>&& message, std::chrono::steady_clock::time_point deadline,
                     const std::stop_token& stop = {}) const {
    return channel_ ? PublishWait(*channel_, OfferOf<T>(message), reach_, deadline, stop) : PublishStatus::kClosed;
  }
  PublishStatus Wait(const std::shared_ptr<const T>& message, std::chrono::steady_clock::time_point deadline,
                     const std::stop_token& stop = {}) const {
    return channel_ ? PublishWait(*channel_, OfferOf<T>(message), reach_, deadline, stop) : PublishStatus::kClosed;
  }

  [[nodiscard]] explicit operator bool() const noexcept { return channel_ != nullptr; }

 private:
  std::shared_ptr<Channel> channel_;
  Reach reach_ = Reach::kAny;
};

}  // namespace hgros
