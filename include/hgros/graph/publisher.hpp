#pragma once

#include <chrono>
#include <concepts>
#include <memory>
#include <new>
#include <stop_token>
#include <type_traits>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/base/publish_status.hpp"
#include "hgros/codec/message.hpp"

namespace hgros {

class Channel;

/// How far a published message goes.
enum class Reach {
  kGraph,  ///< To nodes of this process only.
  kAny,    ///< To all subscribers, in this process and in others.
};

/// A message that is about to be published. It is taken from the caller only when every lossless subscriber has room.
struct MessageOffer {
  const void* message;
  AnyMessage (*take)(void* context);
  void* context;
  const TypeInfo& (*type)();  ///< Called only on channels that are used with two types.
};

/// The implementation of Publisher and of the calls by name. Thread-safe, never blocks, never throws.
HGROS_EXPORT PublishStatus Publish(Channel& channel, const MessageOffer& offer, Reach reach) noexcept;
/// The same, but waits for room until `deadline` or a stop request. Returns kWouldDeadlock instead of waiting inside a
/// callback or on a library thread.
HGROS_EXPORT PublishStatus PublishWait(Channel& channel, const MessageOffer& offer, Reach reach,
                                       std::chrono::steady_clock::time_point deadline, const std::stop_token& stop);

/// Counts a message that could not be copied as refused, and logs it. Returns kNoMemory.
HGROS_EXPORT PublishStatus RefuseCopy(Channel& channel) noexcept;

/// Offers a message of which the caller is the only owner. The pointer is moved from only if the message is taken.
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

/// Publishes a copy of `message`; one that is moved in is moved from only if it is taken. Throws nothing but what
/// copying or moving throws, other than std::bad_alloc.
template <class M>
PublishStatus PublishValue(Channel& channel, M&& message, Reach reach) {
  using T = std::remove_cvref_t<M>;
  std::unique_ptr<T> own;
  try {
    own = std::make_unique<T>(std::forward<M>(message));
  } catch (const std::bad_alloc&) {
    return RefuseCopy(channel);
  }
  const PublishStatus status = Publish(channel, OfferOf<T>(own), reach);
  if constexpr (!std::is_lvalue_reference_v<M>) {
    if (own) message = std::move(*own);
  }
  return status;
}

/// Publishes on one channel without looking up its name each time. Copies share the channel. A handle that outlives its
/// session (or graph), or never had one, returns kClosed. Thread-safe.
template <class T>
class Publisher {
 public:
  Publisher() = default;
  /// For DataGraph and Session, which have compared T with the channel's type.
  Publisher(std::shared_ptr<Channel> channel, Reach reach) : channel_(std::move(channel)), reach_(reach) {}

  /// Hands the message to every subscriber. On any status except kOk nobody got it, and `message` still owns it.
  /// Ordering: messages arrive everywhere in the order in which they were published. If an inline callback publishes on
  /// its own channel, the new message is therefore handed over only after all subscribers have got the current one.
  PublishStatus operator()(std::unique_ptr<T>&& message) const {
    return channel_ ? Publish(*channel_, OfferOf<T>(message), reach_) : PublishStatus::kClosed;
  }
  template <class U>
  PublishStatus operator()(const std::shared_ptr<U>& message) const {
    const std::shared_ptr<const T>& shared = message;
    return channel_ ? Publish(*channel_, OfferOf<T>(shared), reach_) : PublishStatus::kClosed;
  }

  /// Publishes a copy of `message`, for small messages; kNoMemory if there is no memory for it.
  PublishStatus operator()(const T& message) const requires std::copy_constructible<T> {
    return channel_ ? PublishValue(*channel_, message, reach_) : PublishStatus::kClosed;
  }
  /// Moves from `message`. On any status except kOk it is as it was.
  PublishStatus operator()(T&& message) const requires std::movable<T> {
    return channel_ ? PublishValue(*channel_, std::move(message), reach_) : PublishStatus::kClosed;
  }

  /// As the first two, but waits until lossless subscribers have room, `deadline` has passed or `stop` is requested.
  PublishStatus Wait(std::unique_ptr<T>&& message, std::chrono::steady_clock::time_point deadline,
                     const std::stop_token& stop = {}) const {
    return channel_ ? PublishWait(*channel_, OfferOf<T>(message), reach_, deadline, stop) : PublishStatus::kClosed;
  }
  template <class U>
  PublishStatus Wait(const std::shared_ptr<U>& message, std::chrono::steady_clock::time_point deadline,
                     const std::stop_token& stop = {}) const {
    const std::shared_ptr<const T>& shared = message;
    return channel_ ? PublishWait(*channel_, OfferOf<T>(shared), reach_, deadline, stop) : PublishStatus::kClosed;
  }

  /// A pointer of another type would have to be converted, and would be empty then even if the message is refused.
  template <class U, class D>
  PublishStatus operator()(std::unique_ptr<U, D>&& message) const = delete;
  template <class U, class D>
  PublishStatus Wait(std::unique_ptr<U, D>&& message, std::chrono::steady_clock::time_point deadline,
                     const std::stop_token& stop = {}) const = delete;

  [[nodiscard]] explicit operator bool() const noexcept { return channel_ != nullptr; }

 private:
  std::shared_ptr<Channel> channel_;
  Reach reach_ = Reach::kAny;
};

}  // namespace hgros
