#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <utility>

#include "hgros/component/context.hpp"
#include "hosted/work_desk.hpp"
#include "session_handle.hpp"

namespace hgros::python {

/// The context of a component in Python. Everything of the component runs on one thread of Python.
///
/// Its nodes have threads of their own, which wait until Python has handled a message. So the library knows when a
/// callback begins and ends, as with components of C++.
///
/// Thread safety: all functions. Those that say so are called without the GIL.
class ContextHandle : public OfProcess, public std::enable_shared_from_this<ContextHandle> {
 public:
  explicit ContextHandle(Context& context) : context_(&context), name_(context.name()) {}

  /// The context, which does not end meanwhile.
  struct Used {
    std::shared_lock<std::shared_mutex> lock;
    Context* context;
    [[nodiscard]] Context* operator->() const noexcept { return context; }
  };
  /// Errors: throws Error after End(), and in a forked child.
  [[nodiscard]] Used Use() const;
  /// Without the GIL: waits for those that use the context.
  void End();

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] WorkDesk& desk() noexcept { return desk_; }
  /// Sets the function that gets each message, request and tick, as the number of a target and arguments. The caller
  /// has the GIL. Pass an empty object before the end.
  void SetReceiver(pybind11::object receiver) { receiver_ = std::move(receiver); }

  // Without the GIL.
  /// Without a schema, messages of all types.
  void Subscribe(const std::string& channel, const MessageSchema* schema, int target, NodeOptions options);
  [[nodiscard]] std::string Serve(const std::string& service, const MessageSchema& request, const MessageSchema& reply,
                                  int target);
  void CreateTimer(const std::string& timer, std::int64_t period_ns, int target);
  [[nodiscard]] Owned<PublisherHandle> Advertise(const std::string& channel, const MessageSchema& schema,
                                                 std::size_t latched);

 private:
  // Without the GIL. `arguments` are made with it.
  [[nodiscard]] std::string Receive(int target, const std::function<pybind11::tuple()>& arguments);

  mutable std::shared_mutex mutex_;
  Context* context_;  // Null after End().
  const std::string name_;
  WorkDesk desk_;
  pybind11::object receiver_;
};

}  // namespace hgros::python
