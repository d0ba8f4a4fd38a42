#pragma once

#include <pybind11/pybind11.h>

namespace hgros::python {

// Each function adds the classes of one subject to the module.
void BindInbox(pybind11::module_& module);
void BindSchema(pybind11::module_& module);
void BindPublisher(pybind11::module_& module);
void BindServices(pybind11::module_& module);  // Services, calls and timers of a session.
void BindParams(pybind11::module_& module);
void BindTransforms(pybind11::module_& module);
void BindSnapshot(pybind11::module_& module);
void BindSession(pybind11::module_& module);

}  // namespace hgros::python
