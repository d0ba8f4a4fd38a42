#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "bindings.hpp"
#include "bulk_wire.hpp"
#include "inbox.hpp"
#include "run_callbacks.hpp"
#include "session_handle.hpp"
#include "wire.hpp"

namespace hgros::python {
namespace {

// Up to here a copy costs less than keeping the memory in which the message arrived.
constexpr std::size_t kCopiedBytes = 4096;

// What Python gets beside a message.
struct Envelope {
  MessageInfo info;
};

py::bytes AsPyBytes(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

py::object ToPython(LogLine& line) { return py::make_tuple(static_cast<int>(line.level), py::str(line.text)); }

py::object ToPython(const Tick& tick) {
  return py::make_tuple(tick.planned.nanoseconds, tick.now.nanoseconds, tick.missed);
}

py::object ToPython(CallEnded& ended) {
  if (!ended.kind.empty()) return py::make_tuple(py::none(), py::none(), ended.kind, ended.reason);
  py::object wire = WireOf(std::move(ended.reply.data));
  return py::make_tuple(std::move(wire), std::const_pointer_cast<MessageSchema>(std::move(ended.reply.schema)), "", "");
}

py::object ToPython(Request& request) {
  py::object wire = WireOf(std::move(request.message.data));
  return py::make_tuple(std::move(wire), std::const_pointer_cast<MessageSchema>(std::move(request.message.schema)),
                        std::move(request.answer));
}

py::object ToPython(const ParamsChanged& changed) { return py::cast(changed.paths); }

py::object ToPython(Work& work) { return py::cast(std::move(work)); }

py::list TakeFrom(Inbox& inbox, std::size_t most) {
  std::vector<Arrival> taken = inbox.Take(most);
  py::list list(taken.size());
  for (std::size_t i = 0; i < taken.size(); ++i) {
    list[i] = std::visit(
        [](auto& one) -> py::object {
          if constexpr (std::is_same_v<std::decay_t<decltype(one)>, Heard>) {
            return py::none();  // Taken by NextOf().
          } else {
            return ToPython(one);
          }
        },
        taken[i]);
  }
  return list;
}

// The next message: wire, its schema (none if that of the one before), info and whether more wait; or none. What this
// thread publishes from now on was caused by it.
py::object NextOf(Inbox& inbox) {
  inbox.Finish(false);
  bool more = false;
  auto taken = inbox.TakeOne(more);
  auto* heard = taken ? std::get_if<Heard>(&*taken) : nullptr;
  if (heard == nullptr) return py::none();
  current_cause = heard->cause;
  inbox.Begin(heard->info);
  auto schema = std::const_pointer_cast<MessageSchema>(std::move(heard->message.schema));
  py::object told = inbox.IsNew(schema) ? py::cast(std::move(schema)) : py::none();
  return py::make_tuple(WireOf(std::move(heard->message.data)), std::move(told), Envelope{heard->info}, more);
}

void BindInfo(py::module_& module) {
  py::class_<Envelope>(module, "MessageInfo", "What is known about a message beside its content.")
      .def_property_readonly(
          "publisher", [](const Envelope& one) { return one.info.id.publisher; }, "The id of the publishing session.")
      .def_property_readonly(
          "sequence", [](const Envelope& one) { return one.info.id.sequence; },
          "Counts the publisher's messages on the channel from 1.")
      .def_property_readonly(
          "number", [](const Envelope& one) { return one.info.number; },
          "Counts the channel's messages in the publishing process; 0: unknown.")
      .def_property_readonly(
          "key", [](const Envelope& one) { return one.info.key; }, "Identifies the message in all processes.")
      .def_property_readonly(
          "cause", [](const Envelope& one) { return one.info.cause.message; },
          "The key of the message that led to this one; 0: none.")
      .def_property_readonly(
          "publish_time_ns", [](const Envelope& one) { return one.info.publish_time_ns; },
          "The sender's wall clock in ns since 1970; 0: unknown, as for messages of this session.")
      .def_property_readonly(
          "publish_monotonic_ns", [](const Envelope& one) { return one.info.publish_monotonic_ns; },
          "time.monotonic_ns() when it was published, or received from another host.")
      .def_property_readonly(
          "remote", [](const Envelope& one) { return one.info.remote; }, "Whether it came from another session.")
      .def("__repr__", [](const Envelope& one) {
        return "MessageInfo(publisher=" + SessionId{one.info.id.publisher}.ToString() +
               ", sequence=" + std::to_string(one.info.id.sequence) + ")";
      });
  module.def("leave_callback", [] { current_cause = {}; });
}

}  // namespace

py::object WireOf(Payload data) {
  if (data.bytes.size() <= kCopiedBytes) return AsPyBytes(data.bytes);
  return py::cast(MakeOwned<Wire>(std::move(data)));
}

py::object InfoOf(const MessageInfo& info) { return py::cast(Envelope{info}); }

void SetInfo(py::handle object, const MessageInfo& info) { Held<Envelope>(object).info = info; }

void BindInbox(py::module_& module) {
  BindInfo(module);
  py::class_<Wire, Owned<Wire>>(module, "Wire", py::buffer_protocol(), "The bytes of a message where they arrived.")
      .def_buffer([](const Wire& wire) {
        const Bytes bytes = wire.data().bytes;
        return py::buffer_info(const_cast<std::byte*>(bytes.data()), 1, "B", 1,
                               {static_cast<py::ssize_t>(bytes.size())}, {1}, /*readonly=*/true);
      })
      .def("__len__", [](const Wire& wire) { return wire.data().bytes.size(); });
  module.def(
      "leases", [] { return py::make_tuple(leases.count.load(), leases.bytes.load()); },
      "How many messages Python keeps in the memory where they arrived, and their bytes.");
  module.def(
      "split_bulk",
      [](const py::buffer& wire, int number) -> py::object {
        const py::buffer_info info = wire.request();
        const auto split =
            SplitBulk({static_cast<const std::byte*>(info.ptr), static_cast<std::size_t>(info.size)}, number);
        if (!split) return py::none();
        return py::make_tuple(py::bytes(split->head), split->at, split->size);
      },
      "The wire form without a `bytes` field, and where that field is; None if it is not a protobuf message.");

  py::class_<Answer, std::shared_ptr<Answer>>(module, "Answer", "What a waiting handler returns.")
      .def("reply", [](Answer& answer, const std::string& data) { answer.Reply(data); })
      .def("fail", &Answer::Fail);

  py::class_<ReadyList, std::shared_ptr<ReadyList>>(module, "ReadyList", "Which inboxes have something.")
      .def(py::init([](const std::shared_ptr<SessionHandle>& session) { return MakeShared<ReadyList>(session); }),
           py::arg("session") = py::none())
      .def("wait", &ReadyList::Wait, py::arg("timeout"))
      .def("run", &RunCallbacks, py::arg("known"), py::arg("timeout"), py::arg("once"),
           "As wait(), and calls the callbacks in `known`: how many ran, the keys that are left for Python, and the "
           "handler whose callback has raised an exception with that, or None twice.")
      .def("take", &ReadyList::Take)
      .def("add", &ReadyList::Add, py::arg("key"))
      .def("wake", &ReadyList::Wake)
      .def("end", &ReadyList::End)
      .def_static("prepare", &ReadyList::Prepare)
      .def_static("relax", &ReadyList::Relax)
      .def("fileno", &ReadyList::HandOutDescriptor);
  py::class_<Inbox, std::shared_ptr<Inbox>>(module, "Inbox", "A bounded queue from the library to Python.")
      .def(py::init([](const std::shared_ptr<ReadyList>& ready, int key) { return MakeShared<Inbox>(ready, key); }),
           py::arg("ready"), py::arg("key"))
      .def("keep_last", [](Inbox& inbox, std::size_t depth) { inbox.SetQueue(Queue::KeepLast(depth)); })
      .def("take", &TakeFrom, py::arg("most"))
      .def("next", &NextOf)
      .def("run_known", &RunKnownOf, py::arg("type"), py::arg("callback"), py::arg("most"),
           "How it ended: 0: no more wait, 1: more wait, 2: the next one has another schema.")
      .def_property_readonly("ran", &Inbox::ran)
      .def("take_undecoded", &Inbox::TakeUndecoded)
      .def("finish", &Inbox::Finish, py::arg("failed"))
      .def("skip", &Inbox::Skip)
      .def("end", &Inbox::Close, Released())
      .def_property_readonly("dropped", &Inbox::dropped)
      .def_property_readonly("queued", &Inbox::queued);
}

}  // namespace hgros::python
