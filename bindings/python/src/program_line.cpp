#include "program_line.hpp"

#include <pybind11/pybind11.h>

#include <set>
#include <string>

namespace hgros::python {
namespace py = pybind11;
namespace {

bool OfPackage(const py::object& frame) {
  const auto globals =
      py::reinterpret_steal<py::dict>(PyFrame_GetGlobals(reinterpret_cast<PyFrameObject*>(frame.ptr())));
  const py::object package = globals.attr("get")("__package__");
  return package.equal(py::str("hgros"));
}

}  // namespace

CallSite ProgramLine() {
  const py::gil_scoped_acquire acquired;
  auto frame =
      py::reinterpret_steal<py::object>(reinterpret_cast<PyObject*>(PyThreadState_GetFrame(PyThreadState_Get())));
  while (frame && OfPackage(frame)) {
    frame = py::reinterpret_steal<py::object>(
        reinterpret_cast<PyObject*>(PyFrame_GetBack(reinterpret_cast<PyFrameObject*>(frame.ptr()))));
  }
  if (!frame) return {};
  auto* of_frame = reinterpret_cast<PyFrameObject*>(frame.ptr());
  const auto code = py::reinterpret_steal<py::object>(reinterpret_cast<PyObject*>(PyFrame_GetCode(of_frame)));
  // Kept until the process ends, as the names of files in C++ are; a program has few. The GIL guards it.
  static auto& files = *new std::set<std::string>();
  const std::string& file = *files.insert(py::str(code.attr("co_filename"))).first;
  return {file.c_str(), PyFrame_GetLineNumber(of_frame)};
}

}  // namespace hgros::python
