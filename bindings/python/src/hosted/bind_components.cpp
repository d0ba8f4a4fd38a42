// Components in Python: the classes that the library constructs, and what their contexts offer.
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>

#include "bindings.hpp"
#include "hgros/base/error.hpp"
#include "hgros/component/raw_context.hpp"
#include "hosted/component_host.hpp"
#include "hosted/context_handle.hpp"

namespace hgros::python {
namespace {

py::module_ HostModule() { return py::module_::import("hgros.component_host"); }

// On the thread that has started the interpreter. Never destroyed: that thread waits there until the process ends.
WorkDesk& HostDesk() {
  static auto& desk = *new WorkDesk();
  return desk;
}

// A component whose class is one of Python.
class PythonComponent final : public AnyComponent {
 public:
  explicit PythonComponent(Context& context) : context_(MakeShared<ContextHandle>(context)) {
    (void)HostDesk().Run([&] {
      hosted_ = HostModule().attr("Hosted")(RawContext(context).type(), context_);
      context_->SetReceiver(hosted_.attr("receive"));
      return std::string();
    });
    try {
      Call("construct");
    } catch (...) {
      End();
      throw;
    }
  }
  PythonComponent(const PythonComponent&) = delete;
  PythonComponent& operator=(const PythonComponent&) = delete;
  ~PythonComponent() override { End(); }

  void Activate() override { Call("activate"); }
  void Deactivate() override { Call("deactivate"); }
  [[nodiscard]] AnyMessage Save() override {
    auto data = std::make_shared<const std::string>(
        context_->desk().Run([&] { return hosted_.attr("save")().cast<std::string>(); }));
    const Bytes bytes = AsBytes(*data);
    return std::make_shared<const RawMessage>(RawMessage{nullptr, Payload{bytes, std::move(data)}});
  }
  void Restore(const AnyMessage& state) override {
    const Bytes bytes = static_cast<const RawMessage*>(state.get())->data.bytes;
    (void)context_->desk().Run([&] {
      hosted_.attr("restore")(py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
      return std::string();
    });
  }
  [[nodiscard]] void* object() noexcept override { return this; }
  [[nodiscard]] const std::type_info& type() const noexcept override { return typeid(PythonComponent); }

 private:
  void Call(const char* function) {
    (void)context_->desk().Run([&] {
      hosted_.attr(function)();
      return std::string();
    });
  }
  void End() noexcept {
    try {
      (void)context_->desk().Run([&] {
        const py::object last = std::exchange(hosted_, {});
        context_->SetReceiver({});
        last.attr("end")();
        return std::string();
      });
    } catch (const std::exception& fault) {
      context_->Use()->log().Write(LogLevel::kError, std::string("Its end raised an exception: ") + fault.what());
    }
    context_->End();
  }

  const std::shared_ptr<ContextHandle> context_;
  py::object hosted_;  // Used with the GIL.
};

std::unique_ptr<AnyComponent> ConstructInPython(Context& context) { return std::make_unique<PythonComponent>(context); }

ComponentType FindType(std::string_view name) {
  ComponentType type{std::string(name), false, nullptr, &ConstructInPython};
  try {
    (void)HostDesk().Run([&] {
      const py::tuple found = HostModule().attr("find")(type.name);
      type.activates = found[0].cast<bool>();
      if (!found[1].is_none()) type.state = &RawStateType(found[1].cast<const MessageSchema&>());
      return std::string();
    });
  } catch (const std::runtime_error& fault) {
    throw Error(fault.what());
  }
  return type;
}

void ServeWork() { HostModule().attr("serve")(HostDesk().ready(), HostDesk().inbox()); }

void DoWork(const Work& work) {
  try {
    work.answer->Reply(work.run());
  } catch (const py::error_already_set& fault) {
    std::string text = "It raised an exception that cannot be described.";
    try {
      text = HostModule().attr("describe")(fault.value()).cast<std::string>();
    } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): somebody waits for the answer.
    }
    work.answer->Fail(text);
  } catch (const std::exception& fault) {
    work.answer->Fail(fault.what());
  }
}

NodeOptions OptionsOf(bool lossless, std::size_t depth, std::size_t limit_bytes, const std::string& name) {
  NodeOptions options;
  options.name = name;
  options.queue = QueueOf(lossless, depth, limit_bytes);
  return options;
}

void BindContext(py::module_& module) {
  py::class_<ContextHandle, std::shared_ptr<ContextHandle>>(module, "Context", "The context of a component of C++.")
      .def_property_readonly("name", &ContextHandle::name)
      .def_property_readonly("ready", [](ContextHandle& one) { return one.desk().ready(); })
      .def_property_readonly("inbox", [](ContextHandle& one) { return one.desk().inbox(); })
      .def("settle", [](ContextHandle& one) { one.desk().Settle(); })
      .def(
          "subscribe",
          [](ContextHandle& one, const std::string& channel, const MessageSchema* schema, int target, bool lossless,
             std::size_t depth, std::size_t limit_bytes, const std::string& name) {
            one.Subscribe(channel, schema, target, OptionsOf(lossless, depth, limit_bytes, name));
          },
          Released(), py::arg("channel"), py::arg("schema"), py::arg("target"), py::arg("lossless"), py::arg("depth"),
          py::arg("limit_bytes"), py::arg("name"))
      .def("serve", &ContextHandle::Serve, Released(), py::arg("service"), py::arg("request"), py::arg("reply"),
           py::arg("target"))
      .def("create_timer", &ContextHandle::CreateTimer, Released(), py::arg("timer"), py::arg("period_ns"),
           py::arg("target"))
      .def("advertise", &ContextHandle::Advertise, Released(), py::arg("channel"), py::arg("schema"),
           py::arg("latched"))
      .def(
          "now_ns", [](const ContextHandle& one) { return one.Use()->clock()->Now().nanoseconds; }, Released())
      .def(
          "log",
          [](const ContextHandle& one, int level, const std::string& text) {
            one.Use()->log().Write(static_cast<LogLevel>(level), text);
          },
          Released(), py::arg("level"), py::arg("text"))
      .def(
          "finish", [](const ContextHandle& one, const std::string& result) { one.Use()->Finish(result); }, Released(),
          py::arg("result"))
      .def(
          "fail", [](const ContextHandle& one, const std::string& sentence) { one.Use()->Fail(sentence); }, Released(),
          py::arg("sentence"));
}

}  // namespace

void BindComponents(py::module_& module) {
  py::class_<Work>(module, "Work", "What a thread of the library waits for.").def("__call__", &DoWork);
  BindContext(module);
  static const ComponentHost host{&FindType, &ServeWork};
  module.add_object("component_host", py::capsule(&host, kComponentHost));
}

}  // namespace hgros::python
