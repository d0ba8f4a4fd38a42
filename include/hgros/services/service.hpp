#pragma once

#include <concepts>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/graph/snapshot.hpp"
#include "hgros/internal/codec/call_message.hpp"

namespace hgros {

class ServiceHost;

/// What F gives is a reply: a Reply, or a unique_ptr or shared_ptr to one.
template <class R, class Reply>
concept ReplyFrom = std::convertible_to<R, Reply> || std::convertible_to<R, std::shared_ptr<const Reply>>;

/// A handler: takes const Request&, gives a reply. What it throws reaches the caller as CallFailure::kHandlerFailed.
template <class F, class Request, class Reply>
concept HandlerFor = std::invocable<F&, const Request&> && ReplyFrom<std::invoke_result_t<F&, const Request&>, Reply>;

/// A handler whose types were compared when it was wired. Null: it gave a null pointer.
using AnyHandler = std::function<AnyMessage(const AnyMessage& request)>;

template <class Request, class Reply, HandlerFor<Request, Reply> F>
[[nodiscard]] AnyHandler EraseHandler(F&& handler) {
  return [shared = std::make_shared<std::decay_t<F>>(std::forward<F>(handler))](const AnyMessage& any) -> AnyMessage {
    const Request& request = *static_cast<const Request*>(any.get());
    using Given = std::invoke_result_t<std::decay_t<F>&, const Request&>;
    if constexpr (std::convertible_to<Given, std::shared_ptr<const Reply>>) {
      return std::shared_ptr<const Reply>((*shared)(request));
    } else {
      return std::make_shared<const Reply>((*shared)(request));
    }
  };
}

/// A request as it was handed over: a pointer, or a value that is copied (or moved).
template <class Request, class M>
[[nodiscard]] AnyMessage ShareRequest(M&& request) {
  if constexpr (std::convertible_to<M&&, std::shared_ptr<const Request>>) {
    return std::shared_ptr<const Request>(std::forward<M>(request));
  } else {
    return std::make_shared<const Request>(std::forward<M>(request));
  }
}

/// Keeps a service going; move-only.
///
/// Lifetime: destroying it stops new requests at once and fails those that wait, here and at their callers. Outside
/// callbacks it waits for handlers in flight. It may outlive its session; it is then inert.
class HGROS_EXPORT Service {
 public:
  Service() = default;
  explicit Service(std::shared_ptr<ServiceHost> host) : host_(std::move(host)) {}
  Service(Service&&) noexcept = default;
  Service& operator=(Service&& other) noexcept;
  ~Service();

  /// Ends the service as the destructor does.
  void Reset();

  [[nodiscard]] bool active() const;
  /// Counts of the node that runs the handler. Its callbacks are turns: a request that a waiting thread ran instead
  /// leaves a turn without work.
  [[nodiscard]] NodeSnapshot stats() const;

 private:
  std::shared_ptr<ServiceHost> host_;
};

}  // namespace hgros
