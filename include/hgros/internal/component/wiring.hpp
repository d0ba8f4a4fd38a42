#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/internal/base/call_site.hpp"
#include "hgros/internal/graph/callback.hpp"

namespace hgros {

/// A subscription that a component asks for.
struct ComponentInput {
  std::string_view channel;
  const TypeInfo& type;
  Invoke invoke;
  const CallSite& where;
};

/// A service that a component offers.
struct ServedByComponent {
  std::string_view service;
  // The types of the two channels, then the types of the messages.
  const TypeInfo& request;
  const TypeInfo& reply;
  const TypeInfo& request_body;
  const TypeInfo& reply_body;
  Invoke invoke;
  const CallSite& where;
};

/// Hears of exceptions in the callbacks of one component, before the graph logs and counts them. Thread-safe.
class HGROS_EXPORT ComponentFaults {
 public:
  using Listener = std::function<void(const std::string& what)>;
  explicit ComponentFaults(Listener listener) : listener_(std::move(listener)) {}
  void Note(const char* what) noexcept;
  static constexpr const char* kUnknown = "an exception that is no std::exception";

 private:
  const Listener listener_;
};

/// As EraseCallback; `faults` hears of exceptions.
template <class T, CallbackFor<T> F>
[[nodiscard]] AnyCallback Guarded(std::shared_ptr<ComponentFaults> faults, F&& callback) {
  return [faults = std::move(faults), call = std::make_shared<std::decay_t<F>>(std::forward<F>(callback))](
             const AnyMessage& message, const MessageInfo& info) {
    try {
      CallWith<T>(*call, message, info);
    } catch (const std::exception& error) {
      faults->Note(error.what());
      throw;
    } catch (...) {
      faults->Note(ComponentFaults::kUnknown);
      throw;
    }
  };
}

}  // namespace hgros
