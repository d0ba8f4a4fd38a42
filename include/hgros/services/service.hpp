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

/// R can be the result of a handler: a Reply, or a unique_ptr or shared_ptr to one.
template <class R, class Reply>
concept ReplyFrom = std::convertible_to<R, Reply> || std::convertible_to<R, std::shared_ptr<const Reply>>;

/// A handler takes const Request& and returns a reply. If it throws, the caller gets CallFailure::kHandlerFailed.
template <class F, class Request, class Reply>
concept HandlerFor = std::invocable<F&, const Request&> && ReplyFrom<std::invoke_result_t<F&, const Request&>, Reply>;

/// A handler whose types were compared when it was wired. Returns null if the handler returned a null pointer.
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

/// Makes a request from a pointer, which is shared, or from a value, which is copied or moved.
template <class Request, class M>
[[nodiscard]] AnyMessage ShareRequest(M&& request) {
  if constexpr (std::convertible_to<M&&, std::shared_ptr<const Request>>) {
    return std::shared_ptr<const Request>(std::forward<M>(request));
  } else {
    return std::make_shared<const Request>(std::forward<M>(request));
  }
}

/// Keeps a service running; move-only.
///
/// Lifetime: destroying it stops new requests at once, and waiting requests fail. Outside callbacks it waits for
/// running handlers, and the handler's captures are destroyed then. It may outlive its session and then does nothing.
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
  /// Counts of the node that runs the handler. Each request causes one callback of the node. If a waiting thread has
  /// run the request instead, that callback does nothing.
  [[nodiscard]] NodeSnapshot stats() const;

 private:
  std::shared_ptr<ServiceHost> host_;
};

}  // namespace hgros
