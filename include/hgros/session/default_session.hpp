#pragma once

#include <chrono>
#include <concepts>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

/// The paper's interface: free functions over one default session of the process. For small programs; larger ones own
/// a Session.
///
/// Threading: Init and Shutdown from one thread; the rest thread-safe in between.
/// Errors: throws Error if used before Init or after Shutdown, or if Init is called twice.

HGROS_EXPORT void Init(Config config = Config::OfEnvironment(), SessionOptions options = {});
/// Reads the configuration from files; without files as Init().
HGROS_EXPORT void Init(const std::vector<std::filesystem::path>& files, SessionOptions options = {});
/// Ends all subscriptions and the session.
HGROS_EXPORT void Shutdown();
[[nodiscard]] HGROS_EXPORT Session& DefaultSession();
/// Keeps a subscription until Shutdown.
HGROS_EXPORT void KeepUntilShutdown(Subscription subscription);
/// Keeps an object that uses the session until Shutdown; it ends after the subscriptions.
HGROS_EXPORT void KeepUntilShutdown(std::shared_ptr<const void> user);

/// As Session::ToAny and Session::ToGraph: a unique_ptr, a shared_ptr, or (ToAny) a small message by value.
template <class M>
PublishStatus ToAny(std::string_view channel, M&& message) {
  return DefaultSession().ToAny(channel, std::forward<M>(message));
}
template <class M>
PublishStatus ToGraph(std::string_view channel, M&& message) {
  return DefaultSession().ToGraph(channel, std::forward<M>(message));
}

/// As Session::FromAny and Session::FromGraph; the subscription lasts until Shutdown.
template <class T, CallbackFor<T> F>
void FromAny(std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {}) {
  KeepUntilShutdown(DefaultSession().FromAny<T>(channel, invoke, std::forward<F>(callback), std::move(options)));
}
template <class T, CallbackFor<T> F>
void FromGraph(std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {}) {
  KeepUntilShutdown(DefaultSession().FromGraph<T>(channel, invoke, std::forward<F>(callback), std::move(options)));
}

/// As Session::Serve; the service lasts until Shutdown.
template <class Request, class Reply, HandlerFor<Request, Reply> F>
void Serve(std::string_view name, F&& handler, Invoke invoke = Invoke::kSerial, NodeOptions options = {}) {
  KeepUntilShutdown(std::make_shared<const Service>(
      DefaultSession().Serve<Request, Reply>(name, std::forward<F>(handler), invoke, std::move(options))));
}

/// As Session::Call.
template <class Request, class Reply, class M>
[[nodiscard]] CallFuture<Reply> Call(std::string_view name, M&& request, std::chrono::nanoseconds timeout) {
  return DefaultSession().Call<Request, Reply>(name, std::forward<M>(request), timeout);
}
template <class Request, class Reply, class M, std::invocable<const CallResult<Reply>&> F>
CallTicket Call(std::string_view name, M&& request, std::chrono::nanoseconds timeout, F&& callback) {
  return DefaultSession().Call<Request, Reply>(name, std::forward<M>(request), timeout, std::forward<F>(callback));
}

}  // namespace hgros
