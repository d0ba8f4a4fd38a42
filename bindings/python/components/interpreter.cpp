// The component library of Python: starts the interpreter when a class of Python is first asked for. All else is in the
// module `hgros._hgros`, which the interpreter loads.
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <dlfcn.h>

#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>

#include "hgros/base/error.hpp"
#include "hosted/component_host.hpp"

namespace hgros::python {
namespace {

using std::filesystem::path;

// The folder of the virtual environment; empty without one.
std::string Environment() {
  const char* folder = std::getenv("VIRTUAL_ENV");
  return folder != nullptr ? folder : "";
}

path ThisLibrary() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<void*>(&ThisLibrary), &info) == 0 || info.dli_fname == nullptr) return {};
  return info.dli_fname;
}

// The folder with the package `hgros`, in which this library is.
path PackageFolder() {
  std::error_code error;
  return std::filesystem::canonical(ThisLibrary(), error).parent_path().parent_path();
}

// The one of the virtual environment, or else the one for which the package was built.
std::string Program() {
  const std::string environment = Environment();
  return environment.empty() ? HGROS_PYTHON_PROGRAM : environment + "/bin/python3";
}

// What mends a Python that cannot be used.
std::string Remedy() {
  const std::string environment = Environment();
  if (environment.empty()) return "Install python3-protobuf, and use the Python for which hgros was built.";
  return "Make the virtual environment by " HGROS_PYTHON_PROGRAM " -m venv --system-site-packages " + environment +
         ", or start the robot without VIRTUAL_ENV.";
}

void Require(const PyStatus& status) {
  if (PyStatus_Exception(status) == 0) return;
  throw Error("Python cannot be started: " +
              std::string(status.err_msg != nullptr ? status.err_msg : "its configuration cannot be used") + ".");
}

// Throws Error if the virtual environment is one of another version: this library belongs to one version of Python.
void RequireVersionOfEnvironment() {
  const std::string ours = std::to_string(PY_MAJOR_VERSION) + '.' + std::to_string(PY_MINOR_VERSION);
  std::ifstream file(path(Environment()) / "pyvenv.cfg");
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string key;
    std::string equals;
    std::string version;
    words >> key >> equals >> version;
    if (version.empty() || (key != "version" && key != "version_info")) continue;
    if (version == ours || version.starts_with(ours + '.')) return;
    throw Error("The virtual environment " + Environment() + " has Python " + version +
                    ", and components run in Python " + ours + ".",
                {}, Remedy());
  }
}

[[noreturn]] void ThrowRaised() {
  PyObject* type = nullptr;
  PyObject* value = nullptr;
  PyObject* trace = nullptr;
  PyErr_Fetch(&type, &value, &trace);
  PyObject* text = value != nullptr ? PyObject_Str(value) : nullptr;
  const char* letters = text != nullptr ? PyUnicode_AsUTF8(text) : nullptr;
  std::string reason = letters != nullptr ? letters : "";
  if (reason.empty())
    reason = type != nullptr && PyExceptionClass_Check(type) ? PyExceptionClass_Name(type) : "unknown";
  if (!reason.ends_with('.')) reason += '.';
  throw Error("The package hgros of Python cannot be used: " + reason, {},
              PyErr_GivenExceptionMatches(type, PyExc_ImportError) != 0 ? Remedy() : std::string());
}

// Where Python looks for modules.
void AddFolder(const path& folder, bool first) {
  PyObject* folders = PySys_GetObject("path");
  PyObject* text = PyUnicode_DecodeFSDefault(folder.c_str());
  const bool added = folders != nullptr && text != nullptr &&
                     (first ? PyList_Insert(folders, 0, text) : PyList_Append(folders, text)) == 0;
  if (!added) ThrowRaised();
  Py_DECREF(text);
}

void Initialize() {
  if (Py_IsInitialized() != 0) {
    throw Error("This program runs Python already, and components in Python need an interpreter of their own.", {},
                "Start them in a process of their own, by hgros run.");
  }
  if (!Environment().empty()) RequireVersionOfEnvironment();
  // Modules in C find the interpreter's functions only if they are visible to all, and so is what this library needs.
  if (dlopen(ThisLibrary().c_str(), RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD) == nullptr) {
    throw Error("The library " + ThisLibrary().string() + " cannot be loaded again: " + dlerror() + ".");
  }
  PyConfig config;
  PyConfig_InitPythonConfig(&config);
  const std::unique_ptr<PyConfig, decltype(&PyConfig_Clear)> cleared(&config, &PyConfig_Clear);
  config.install_signal_handlers = 0;  // The process has its own.
  config.parse_argv = 0;
  config.buffered_stdio = 0;  // What a component prints is in the log at once.
  Require(PyConfig_SetBytesString(&config, &config.program_name, Program().c_str()));
  Require(Py_InitializeFromConfig(&config));
}

// The thread that Python takes for its main one. It stays until the process ends, so the interpreter is never
// finalized.
void RunInterpreter(const std::shared_ptr<std::promise<const ComponentHost*>>& started) {
  const ComponentHost* host = nullptr;
  try {
    Initialize();
    AddFolder(PackageFolder(), false);                                 // The package beside this library.
    PyObject* module = PyImport_ImportModule("hgros.component_host");  // It stays.
    if (module == nullptr) ThrowRaised();
    host = static_cast<const ComponentHost*>(PyCapsule_Import(kComponentHost, 0));
    if (host == nullptr) ThrowRaised();
    // As `python3 -m` has it, but not before: a module there must not stand for one of Python's own.
    const char* safe = std::getenv("PYTHONSAFEPATH");
    if (safe == nullptr || *safe == '\0') AddFolder(std::filesystem::current_path(), true);
  } catch (...) {
    if (PyGILState_GetThisThreadState() != nullptr) PyEval_SaveThread();
    return started->set_exception(std::current_exception());
  }
  started->set_value(host);
  host->serve();
}

ComponentType Find(std::string_view name) {
  static const std::shared_future<const ComponentHost*> host = [] {
    auto started = std::make_shared<std::promise<const ComponentHost*>>();
    try {
      std::thread([started] { RunInterpreter(started); }).detach();
    } catch (const std::system_error&) {
      throw Error("Cannot start the thread of Python: the system gives this process no more threads or memory.", {},
                  "Raise the limit of threads (ulimit -u, or pids.max of the control group) or of memory (ulimit -v).");
    }
    return started->get_future().share();
  }();
  return host.get()->find(name);
}

[[maybe_unused]] const bool kRegistered = RegisterComponentFinder(&Find);

}  // namespace
}  // namespace hgros::python
