#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

// For code of the library that is built on a session.
//
// Thread safety: all functions.
class SessionParts {
 public:
  explicit SessionParts(Session& session) : session_(session) {}

  // Reserves a name until the result is destroyed. Null if it is taken.
  [[nodiscard]] std::shared_ptr<const void> TryReserve(std::string_view name) { return session_.TryReserve(name); }
  [[nodiscard]] SessionCore& core() noexcept { return *session_.core_; }
  // Waits until every timer that is due by now has fired. Returns when the next one is due; Time::Never() without one.
  // Not while the session ends.
  Time SettleTimers() { return session_.SettleTimers(); }
  // Ends calls and services, and wakes all threads that wait for publishers, subscribers or schemas; later waits return
  // at once. Before the session is destroyed.
  HGROS_EXPORT void EndWaits() noexcept;
  // The session is about to be destroyed on a thread that it may have to wait for: it leaves its peers now, and its
  // threads and memory stay until the process ends.
  HGROS_EXPORT void LeaveInside() noexcept;

  // Whether this session is announced as a publisher of the channel.
  [[nodiscard]] bool IsPublished(std::string_view channel) const;

  // For components that move. Waits until the channel, which has a subscription, is received over links that stay as
  // long as the subscription. What comes before may come over those of an earlier subscription. Not in a callback.
  [[nodiscard]] bool SettleInput(std::string_view channel, std::chrono::nanoseconds timeout) const;
  // Waits until the sessions that receive these channels have taken over what was published before: what others publish
  // from then on, they receive behind it. False if that is not so at the deadline, because a subscriber lets messages
  // wait. Keep-last subscribers for whom nothing waits here, and who do not answer within 200 ms, are not waited for.
  // Not in a callback.
  [[nodiscard]] bool AwaitReceived(std::span<const std::string> channels,
                                   std::chrono::steady_clock::time_point deadline);
  // What the session has latched on the channel, encoded, oldest first. It moves along: the other place keeps it for
  // those who subscribe later, and this one forgets it.
  struct LatchedMessage {
    Payload data;
    std::int64_t publish_time_ns = 0;
  };
  [[nodiscard]] std::vector<LatchedMessage> LatchedOn(std::string_view channel) const;
  void KeepLatched(std::string_view channel, std::span<const LatchedMessage> messages, SessionId from);
  void ForgetLatched(std::string_view channel);
  // Services of another session end now, and are served here. It is no fault that it still announces them for a while.
  void TakeServicesFrom(SessionId other);

  // As Session::FromAny and Session::Serve, for types that were erased before. A type that is known at run time only
  // has callbacks as Session::FromAnyRaw. It is compared with the types of publishers: a mismatch in this session
  // throws TypeMismatch, one with another session is reported, whose messages may come all the same.
  [[nodiscard]] Subscription Subscribe(std::string_view channel, const TypeInfo& type, Invoke invoke,
                                       AnyCallback callback, NodeOptions options, const CallSite& where) {
    return session_.SubscribeAny(session_.OpenToSubscribe(channel, type, where), IsRunTimeType(type) ? AnyType() : type,
                                 invoke, std::move(callback), std::move(options));
  }
  using ServiceTypes = SessionServices::CallTypes;
  // A handler of bytes for Serve, whose replies are of the type `reply`, known at run time.
  [[nodiscard]] static AnyHandler HandlerOf(RawHandler handler, const TypeInfo& reply);
  [[nodiscard]] Service Serve(std::string_view name, const ServiceTypes& types, AnyHandler handler, Invoke invoke,
                              NodeOptions options, const CallSite& where) {
    return session_.ServeAny(name, types, std::move(handler), invoke, std::move(options), where);
  }

 private:
  Session& session_;
};

}  // namespace hgros
