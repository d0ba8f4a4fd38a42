#include <pybind11/stl.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "bindings.hpp"
#include "hgros/component/raw_context.hpp"
#include "hgros/session/node_timer.hpp"
#include "hosted/context_handle.hpp"
#include "program_line.hpp"
#include "service_handle.hpp"
#include "session_handle.hpp"
#include "waits.hpp"

namespace hgros::python {
namespace {

// Keeps a call that is under way.
class TicketHandle : public OfProcess {
 public:
  explicit TicketHandle(CallTicket ticket) : ticket_(std::move(ticket)) {}
  void Cancel() const {
    RefuseInChild();
    ticket_.Cancel();
  }

 private:
  CallTicket ticket_;
};

// Keeps a timer that puts its turns into an inbox.
class TimerHandle : public OfProcess {
 public:
  TimerHandle(NodeTimer timer, std::shared_ptr<Inbox> inbox) : inbox_(std::move(inbox)), timer_(std::move(timer)) {}
  TimerHandle(const TimerHandle&) = delete;
  TimerHandle& operator=(const TimerHandle&) = delete;
  ~TimerHandle() { End(); }
  void End() {
    if (of_parent()) return;
    inbox_->Close();
    timer_.Reset();
  }

 private:
  const std::shared_ptr<Inbox> inbox_;
  NodeTimer timer_;
};

// Only hands it over, so it may run on any thread of the session.
auto EndInto(const std::shared_ptr<Inbox>& inbox) {
  return [inbox](const CallResult<RawMessage>& result) {
    if (result) {
      inbox->Push(CallEnded{*result, {}, {}});
    } else {
      const CallFailure& failure = result.failure();
      inbox->Push(CallEnded{{}, std::string(ToString(failure.kind)), failure.reason});
    }
  };
}

Owned<TicketHandle> Call(const SessionHandle& handle, const std::string& name, const MessageSchema& request_schema,
                         const std::string& request, const MessageSchema* reply, double timeout_s,
                         const std::shared_ptr<Inbox>& inbox) {
  auto ticket = handle.Use()->CallRaw(name, request_schema, Payload{AsBytes(request), nullptr},
                                      reply != nullptr ? *reply : MessageSchema{}, Nanoseconds(timeout_s),
                                      EndInto(inbox), Executor::Inline());
  return MakeOwned<TicketHandle>(std::move(ticket));
}

// Calls one service for a component.
class ClientHandle : public OfProcess {
 public:
  ClientHandle(std::shared_ptr<ContextHandle> context, const std::string& name, const MessageSchema& request,
               const MessageSchema& reply)
      : context_(std::move(context)), client_(RawContext(*context_->Use().context).Client(name, request, reply)) {}

  [[nodiscard]] const std::string& service() const noexcept { return client_.service(); }

  [[nodiscard]] Owned<TicketHandle> Call(const std::string& request, double timeout_s,
                                         const std::shared_ptr<Inbox>& inbox) const {
    RefuseInChild();
    const ContextHandle::Used used = context_->Use();
    return MakeOwned<TicketHandle>(
        client_.Call(Payload{AsBytes(request), nullptr}, Nanoseconds(timeout_s), EndInto(inbox), Executor::Inline()));
  }

 private:
  const std::shared_ptr<ContextHandle> context_;
  const RawServiceClient client_;
};

Owned<ServiceHandle> Serve(const SessionHandle& handle, const std::string& name, const MessageSchema& request,
                           const MessageSchema& reply, const std::shared_ptr<Inbox>& inbox) {
  auto desk = std::make_shared<RequestDesk>(inbox);
  NodeOptions options;
  options.executor = Executor::Dedicated();
  auto service = handle.Use()->ServeRaw(
      name, request, reply, [desk](const RawMessage& message) { return desk->Handle(message); }, Invoke::kSerial,
      options, ProgramLine());
  return MakeOwned<ServiceHandle>(std::move(service), desk);
}

Owned<TimerHandle> CreateTimer(const SessionHandle& handle, const std::string& name, std::int64_t period_ns,
                               const std::shared_ptr<Inbox>& inbox) {
  NodeTimerOptions options;
  options.executor = Executor::Inline();
  auto timer = handle.Use()->CreateTimer(
      name, Duration(period_ns), [inbox](const Tick& tick) { inbox->Push(tick); }, options);
  return MakeOwned<TimerHandle>(std::move(timer), inbox);
}

}  // namespace

void BindServices(py::module_& module) {
  py::class_<TicketHandle, Owned<TicketHandle>>(module, "CallTicket", "A call that is under way.")
      .def("cancel", &TicketHandle::Cancel, Released())
      .def("refuse_in_child", &TicketHandle::RefuseInChild);
  py::class_<ClientHandle, Owned<ClientHandle>>(module, "Client", "Calls one service for a component.")
      .def(py::init([](const std::shared_ptr<ContextHandle>& context, const std::string& name,
                       const MessageSchema& request, const MessageSchema& reply) {
             const GilRelease released;
             return MakeOwned<ClientHandle>(context, name, request, reply);
           }),
           py::arg("context"), py::arg("name"), py::arg("request"), py::arg("reply"))
      .def_property_readonly("service", &ClientHandle::service)
      .def("call", &ClientHandle::Call, Released(), py::arg("request"), py::arg("timeout"), py::arg("inbox"));
  py::class_<ServiceHandle, Owned<ServiceHandle>>(module, "Service", "Keeps a service.")
      .def("end", &ServiceHandle::End, Released());
  py::class_<TimerHandle, Owned<TimerHandle>>(module, "Timer", "Keeps a timer.")
      .def("end", &TimerHandle::End, Released());
  module.def("call", &Call, Released(), py::arg("session"), py::arg("name"), py::arg("request_schema"),
             py::arg("request"), py::arg("reply"), py::arg("timeout"), py::arg("inbox"));
  module.def("serve", &Serve, Released(), py::arg("session"), py::arg("name"), py::arg("request"), py::arg("reply"),
             py::arg("inbox"));
  module.def("create_timer", &CreateTimer, Released(), py::arg("session"), py::arg("name"), py::arg("period_ns"),
             py::arg("inbox"));
}

}  // namespace hgros::python
