#include <exception>

#include "bindings.hpp"
#include "hgros/base/error.hpp"
#include "of_process.hpp"

PYBIND11_MODULE(_hgros, module) {
  namespace python = hgros::python;
  module.doc() = "The C++ side of the package hgros. Use the package; this module may change.";
  const auto error = pybind11::register_exception<hgros::Error>(module, "Error", PyExc_RuntimeError);
  error.doc() = "What is wrong, where, and how to mend it.";
  pybind11::register_exception<hgros::TypeMismatch>(module, "TypeMismatch", error.ptr());
  pybind11::register_exception<hgros::ConfigError>(module, "ConfigError", error.ptr());
  python::CountForks();
  python::BindInbox(module);
  python::BindSchema(module);
  python::BindPublisher(module);
  python::BindServices(module);
  python::BindSession(module);
  python::BindParams(module);
  python::BindTransforms(module);
  python::BindSnapshot(module);
  python::BindComponents(module);
}
