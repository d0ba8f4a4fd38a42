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

/// The subscribing functions of Session. Use it as a part of Session, which documents threading and errors.
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
  /// Calls `callback` with every message on `channel` as bytes, whatever its type, for programs that were built without
  /// the type. Messages from other sessions and of ToAnyRaw are passed on as they are; other messages of this session
  /// are encoded.
  ///
  /// Does not fix the channel's type: this session and others may use the channel with any type. If a typed
  /// subscription already exists, only publishers of that type are heard. No mismatch is counted.
  template <CallbackFor<RawMessage> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromAnyRaw(
      std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    return SubscribeAny(OpenToSubscribe(channel, AnyType(), where), AnyType(), invoke,
                        EraseCallback<RawMessage>(std::forward<F>(callback)), std::move(options));
  }
  /// The same for one type that the program names at run time. Others see it, so that `hgros pub` and `hgros doctor`
  /// know it, unless this session subscribes to the channel already without a type. Messages of another type come all
  /// the same and are reported; compare RawMessage::schema. Throws TypeMismatch if this session uses the channel with
  /// another type, and Error if the schema cannot be used.
  template <CallbackFor<RawMessage> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromAnyRaw(
      std::string_view channel, const MessageSchema& type, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    return SubscribeAny(OpenToSubscribe(channel, type, where), AnyType(), invoke,
                        EraseCallback<RawMessage>(std::forward<F>(callback)), std::move(options));
  }
  /// The schema of the messages on `channel`: this program's own, or that of the first publisher that sends it. Null if
  /// `timeout` came first. Subscribes to the channel while it waits. A FromAnyRaw subscription gets the schema with
  /// each message.
  [[nodiscard]] std::shared_ptr<const MessageSchema> AwaitSchema(std::string_view channel,
                                                                 std::chrono::nanoseconds timeout);

  /// As FromAny, for any type, but does not subscribe at other sessions. Gets the messages that this process publishes,
  /// and those that arrive from outside for a FromAny on the same channel.
  template <class T, CallbackFor<T> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromGraph(
      std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    return SubscribeGraph(OpenToSubscribe(channel, TypeOf<T>(), where), TypeOf<T>(), invoke,
                          EraseCallback<T>(std::forward<F>(callback)), std::move(options));
  }

  /// Waits until at least `count` other sessions that publish on `channel` are connected. False if `timeout` came
  /// first.
  [[nodiscard]] bool WaitForPublishers(std::string_view channel, std::size_t count,
                                       std::chrono::nanoseconds timeout) const;

 protected:
  explicit SessionSubscribing(SessionCore& core) noexcept : subscribing_core_(core) {}
  ~SessionSubscribing() = default;

 private:
  friend class SessionParts;
  Channel& OpenToSubscribe(std::string_view channel, const TypeInfo& type, const CallSite& where);
  Channel& OpenToSubscribe(std::string_view channel, const MessageSchema& type, const CallSite& where);
  Subscription SubscribeAny(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                            NodeOptions options);
  Subscription SubscribeGraph(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                              NodeOptions options);

  SessionCore& subscribing_core_;
};

}  // namespace hgros
