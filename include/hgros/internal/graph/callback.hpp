#pragma once

#include <concepts>
#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

#include "hgros/codec/type_info.hpp"
#include "hgros/graph/message_info.hpp"

namespace hgros {

/// A callback for messages of type T. It takes std::shared_ptr<const T> (to keep the message) or const T& (to look at
/// it), optionally followed by const MessageInfo&.
template <class F, class T>
concept CallbackFor = std::invocable < F&,
        std::shared_ptr<const T>,
const MessageInfo& > || std::invocable<F&, std::shared_ptr<const T>> ||
    std::invocable<F&, const T&, const MessageInfo&> || std::invocable<F&, const T&>;

/// A callback whose message type was checked against its channel's type when it subscribed.
using AnyCallback = std::function<void(const AnyMessage& message, const MessageInfo& info)>;

/// Calls `call` with the arguments that it accepts. The message is a T, as checked when the callback subscribed.
template <class T, class Call>
void CallWith(Call& call, const AnyMessage& message, const MessageInfo& info) {
  const T* typed = static_cast<const T*>(message.get());
  if constexpr (std::invocable<Call&, std::shared_ptr<const T>, const MessageInfo&>) {
    call(std::shared_ptr<const T>(message, typed), info);
  } else if constexpr (std::invocable<Call&, std::shared_ptr<const T>>) {
    call(std::shared_ptr<const T>(message, typed));
  } else if constexpr (std::invocable<Call&, const T&, const MessageInfo&>) {
    call(*typed, info);
  } else {
    call(*typed);
  }
}

/// Wraps a callback; one that cannot be copied is held by a shared pointer.
template <class T, CallbackFor<T> F>
[[nodiscard]] AnyCallback EraseCallback(F&& callback) {
  using Call = std::decay_t<F>;
  if constexpr (!std::copy_constructible<Call>) {
    return [shared = std::make_shared<Call>(std::forward<F>(callback))](
               const AnyMessage& message, const MessageInfo& info) { CallWith<T>(*shared, message, info); };
  } else {
    return [call = Call(std::forward<F>(callback))](const AnyMessage& message, const MessageInfo& info) mutable {
      CallWith<T>(call, message, info);
    };
  }
}

}  // namespace hgros
