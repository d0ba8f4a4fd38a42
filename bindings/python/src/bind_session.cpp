#include <pybind11/stl.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "program_line.hpp"
#include "session_handle.hpp"
#include "waits.hpp"

namespace hgros::python {
namespace {

Config ConfigOf(const std::optional<std::string>& file, const std::optional<std::string>& text,
                const std::vector<std::string>& sections) {
  if (file) {
    const std::filesystem::path path(*file);
    return Config::Load({&path, 1}, sections);
  }
  return text ? Config::Parse(*text, "text") : Config::OfEnvironment();
}

void BindSubscription(py::module_& module) {
  py::class_<SubscriptionHandle, Owned<SubscriptionHandle>>(module, "Subscription", "Keeps a subscription.")
      .def("end", &SubscriptionHandle::End, Released())
      .def_property_readonly("of_parent", [](const SubscriptionHandle& one) { return one.of_parent(); })
      .def_property_readonly("name", [](const SubscriptionHandle& one) { return one.subscription().name(); })
      .def_property_readonly("received",
                             [](const SubscriptionHandle& one) { return one.subscription().stats().received; })
      .def_property_readonly("dropped", [](SubscriptionHandle& one) { return one.subscription().stats().dropped; })
      .def_property_readonly(
          "queued", [](SubscriptionHandle& one) { return one.subscription().stats().queued + one.inbox().queued(); });
}

}  // namespace

Queue QueueOf(bool lossless, std::size_t depth, std::size_t limit_bytes) {
  if (!lossless) return Queue::KeepLast(depth);
  return Queue::KeepAll(depth, limit_bytes > 0 ? limit_bytes : Queue::kUnlimitedBytes);
}

void BindSession(py::module_& module) {
  BindSubscription(module);
  py::class_<SessionHandle, std::shared_ptr<SessionHandle>>(module, "Session", "A session of C++.")
      .def(py::init([](const std::optional<std::string>& file, const std::optional<std::string>& text,
                       const std::vector<std::string>& sections, const std::string& name,
                       const std::shared_ptr<Inbox>& log) {
             const GilRelease released;
             return MakeShared<SessionHandle>(ConfigOf(file, text, sections), name, log);
           }),
           py::arg("file"), py::arg("text"), py::arg("sections"), py::arg("name"), py::arg("log"))
      .def("close", &SessionHandle::Close, Released())
      .def_property_readonly("closed", &SessionHandle::closed)
      .def("refuse_in_child", &SessionHandle::RefuseInChild)
      .def_property_readonly("of_parent", [](const SessionHandle& one) { return one.of_parent(); })
      .def_property_readonly("id", [](const SessionHandle& one) { return one.Use()->id().ToString(); })
      .def_property_readonly("name", [](const SessionHandle& one) { return one.Use()->name(); })
      .def(
          "name_of",
          [](const SessionHandle& one, std::uint64_t session) { return one.Use()->NameOf(SessionId{session}); },
          Released(), py::arg("session"))
      .def(
          "now_ns", [](const SessionHandle& one) { return one.Use()->clock()->Now().nanoseconds; }, Released())
      .def(
          "subscribe",
          [](SessionHandle& one, const std::string& channel, const std::shared_ptr<Inbox>& inbox, bool lossless,
             std::size_t depth, std::size_t limit_bytes, const std::string& name, const MessageSchema* type) {
            NodeOptions options;
            options.name = name;
            options.queue = QueueOf(lossless, depth, limit_bytes);
            return one.Subscribe(channel, inbox, options, type);
          },
          Released(), py::arg("channel"), py::arg("inbox"), py::arg("lossless"), py::arg("depth"),
          py::arg("limit_bytes"), py::arg("name"), py::arg("schema").none(true))
      .def(
          "advertise",
          [](SessionHandle& one, const std::string& channel, const MessageSchema& schema, std::size_t latched) {
            const auto session = one.Use();
            auto lend = [weak = std::weak_ptr(session), channel](std::size_t size_bytes) {
              const auto open = weak.lock();
              return open ? open->Loan<Block>(channel, size_bytes) : nullptr;
            };
            return MakeOwned<PublisherHandle>(
                std::move(lend),
                session->AdvertiseRaw(channel, schema, PublishOptions{.latched = latched}, ProgramLine()));
          },
          Released(), py::arg("channel"), py::arg("schema"), py::arg("latched"))
      .def(
          "wait_for_subscribers",
          [](SessionHandle& one, const std::string& channel, std::size_t count, double timeout) {
            return one.Use()->WaitForSubscribers(channel, count, Nanoseconds(timeout));
          },
          Released(), py::arg("channel"), py::arg("count"), py::arg("timeout"))
      .def(
          "wait_for_publishers",
          [](SessionHandle& one, const std::string& channel, std::size_t count, double timeout) {
            return one.Use()->WaitForPublishers(channel, count, Nanoseconds(timeout));
          },
          Released(), py::arg("channel"), py::arg("count"), py::arg("timeout"))
      .def(
          "wait_for_service",
          [](SessionHandle& one, const std::string& name, double timeout) {
            return one.Use()->WaitForService(name, Nanoseconds(timeout));
          },
          Released(), py::arg("name"), py::arg("timeout"));
}

}  // namespace hgros::python
