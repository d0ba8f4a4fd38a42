#pragma once

#include <pybind11/pybind11.h>

namespace hgros::python {

namespace py = pybind11;
using Released = py::call_guard<py::gil_scoped_release>;

// Each function adds the classes of one subject to the module.
void BindInbox(py::module_& module);
void BindSchema(py::module_& module);
void BindPublisher(py::module_& module);
void BindServices(py::module_& module);  // Services, calls and timers of a session.
void BindParams(py::module_& module);
void BindTransforms(py::module_& module);
void BindSnapshot(py::module_& module);
void BindSession(py::module_& module);

}  // namespace hgros::python
