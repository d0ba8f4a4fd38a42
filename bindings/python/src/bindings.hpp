#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>

#include "hgros/base/bytes.hpp"
#include "hgros/graph/message_info.hpp"
#include "hgros/graph/queue.hpp"
#include "waits.hpp"

namespace hgros::python {

namespace py = pybind11;
using Released = py::call_guard<GilRelease>;

/// The bytes of a message as Python gets them: small ones as a copy, others where they arrived.
[[nodiscard]] py::object WireOf(Payload data);
[[nodiscard]] py::object InfoOf(const MessageInfo& info);
/// Of an object that InfoOf() has made, and that nobody else has.
void SetInfo(py::handle object, const MessageInfo& info);
/// The object in `object`, whose type must be that of T itself. A cast looks types up, which takes microseconds after a
/// pause.
template <class T>
[[nodiscard]] T& Held(py::handle object) {
  return *reinterpret_cast<py::detail::instance*>(object.ptr())->get_value_and_holder().value_ptr<T>();
}
[[nodiscard]] Queue QueueOf(bool lossless, std::size_t depth, std::size_t limit_bytes);

// Each function adds the classes of one subject to the module.
void BindInbox(py::module_& module);
void BindSchema(py::module_& module);
void BindPublisher(py::module_& module);
void BindServices(py::module_& module);  // Services, calls and timers of a session.
void BindParams(py::module_& module);
void BindTransforms(py::module_& module);
void BindSnapshot(py::module_& module);
void BindSession(py::module_& module);
void BindComponents(py::module_& module);  // What components in Python are made of.

}  // namespace hgros::python
