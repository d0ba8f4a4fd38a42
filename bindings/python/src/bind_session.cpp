#include <pybind11/stl.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "hgros/session/stamp_matcher.hpp"
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

// All of it runs under the GIL, which the items need.
using Matcher = StampMatcher<py::object>;

std::unique_ptr<Matcher> MakeMatcher(std::size_t channels, double tolerance_s, std::size_t depth) {
  const Duration tolerance = tolerance_s < 0 ? Duration(-1) : Nanoseconds(tolerance_s);
  return std::make_unique<Matcher>(channels, MatchOptions{tolerance, depth});
}

py::object Push(Matcher& matcher, std::size_t channel, std::int64_t stamp_ns, py::object item) {
  auto set = matcher.Push(channel, Time{stamp_ns}, std::move(item));
  if (!set) return py::none();
  py::tuple items(set->size());
  for (std::size_t i = 0; i < set->size(); ++i) items[i] = (*set)[i].item;
  return items;
}

void BindMatcher(py::module_& module) {
  py::class_<MatchCounts>(module, "MatchCounts", "What has become of the messages of one channel. The rest waits.")
      .def_readonly("matched", &MatchCounts::matched)
      .def_readonly("unmatched", &MatchCounts::unmatched)
      .def_readonly("overflowed", &MatchCounts::overflowed)
      .def_readonly("late", &MatchCounts::late);
  py::class_<Matcher>(module, "StampMatcher", "Matches items of two to nine channels by their stamps.")
      .def(py::init(&MakeMatcher), py::arg("channels"), py::arg("tolerance") = 0.0, py::arg("depth") = 16)
      .def("push", &Push, py::arg("channel"), py::arg("stamp_ns"), py::arg("item"),
           "Adds an item of a channel, which counts from 0. Returns the items of the set that is complete with it.")
      .def(
          "counts", [](const Matcher& matcher, std::size_t channel) { return matcher.counts(channel); },
          py::arg("channel"));
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
  BindMatcher(module);
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
