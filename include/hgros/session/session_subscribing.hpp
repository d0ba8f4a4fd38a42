#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string_view>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/internal/base/call_site.hpp"

namespace hgros {

class SessionCore;

/// What a Session subscribes to. Use it as a part of Session, which says how it is threaded and what it throws.
class HGROS_EXPORT SessionSubscribing {
 public:
  /// Calls `callback` with every message on `channel`, wherever it was published: in this process (the same object,
  /// no copy) or in another (decoded once, then shared by all subscriptions of this session).
  ///
  /// Ordering: each publisher's send order under kSerial; none between publishers.
  /// Lifetime: ends with the returned Subscription. Messages that do not decode are dropped and counted.
  template <class T, CallbackFor<T> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromAny(
      std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    RequireMessage<T>();
    return SubscribeAny(OpenToSubscribe(channel, TypeOf<T>(), where), TypeOf<T>(), invoke,
                        EraseCallback<T>(std::forward<F>(callback)), std::move(options));
  }
  /// Calls `callback` with every message on `channel` as bytes, whatever its type: for programs that were built without
  /// it. Messages from outside, and those of ToAnyRaw, are passed on as they came; the others of this session are
  /// encoded for it.
  ///
  /// Does not fix the channel's type: others may use it with any type, also in this session. If a typed subscription
  /// already exists, only publishers of that type are heard. No mismatch is counted.
  template <CallbackFor<RawMessage> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromAnyRaw(
      std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    return SubscribeAny(OpenToSubscribe(channel, AnyType(), where), AnyType(), invoke,
                        EraseCallback<RawMessage>(std::forward<F>(callback)), std::move(options));
  }
  /// The schema of what is published on `channel`: this program's own, or that of the first publisher that tells it.
  /// Null if `timeout` comes first. While it waits, it is a subscriber. A FromAnyRaw subscription gets the schema with
  /// each message.
  [[nodiscard]] std::shared_ptr<const MessageSchema> AwaitSchema(std::string_view channel,
                                                                 std::chrono::nanoseconds timeout);

  /// As FromAny without asking other sessions: what this process publishes (and what comes from outside for a FromAny
  /// on the same channel); any type.
  template <class T, CallbackFor<T> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromGraph(
      std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    return SubscribeGraph(OpenToSubscribe(channel, TypeOf<T>(), where), TypeOf<T>(), invoke,
                          EraseCallback<T>(std::forward<F>(callback)), std::move(options));
  }

  /// Waits until `channel` hears from at least `count` other sessions that publish on it. False if `timeout` came
  /// first.
  [[nodiscard]] bool WaitForPublishers(std::string_view channel, std::size_t count,
                                       std::chrono::nanoseconds timeout) const;

 protected:
  explicit SessionSubscribing(SessionCore& core) noexcept : subscribing_core_(core) {}
  ~SessionSubscribing() = default;

 private:
  Channel& OpenToSubscribe(std::string_view channel, const TypeInfo& type, const CallSite& where);
  Subscription SubscribeAny(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                            NodeOptions options);
  Subscription SubscribeGraph(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                              NodeOptions options);

  SessionCore& subscribing_core_;
};

}  // namespace hgros
