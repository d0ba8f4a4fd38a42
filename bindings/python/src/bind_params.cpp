#include <pybind11/stl.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "hgros/params/param_server.hpp"
#include "hgros/params/param_service.hpp"
#include "hosted/context_handle.hpp"
#include "inbox.hpp"
#include "session_handle.hpp"

namespace hgros::python {
namespace {

// What a declared parameter, or each item of one, is. Others are what they look like.
enum class Declared { kOther, kFloat, kText };

template <class T>
constexpr Declared kDeclared = Declared::kOther;
template <>
inline constexpr Declared kDeclared<double> = Declared::kFloat;
template <>
inline constexpr Declared kDeclared<std::string> = Declared::kText;
template <class T>
constexpr Declared kDeclared<std::vector<T>> = kDeclared<T>;

// The parameters of a session's program, which other sessions can read and set, or of a component.
class ParamsHandle : public OfProcess {
 public:
  ParamsHandle(std::shared_ptr<Session> session, const std::optional<std::string>& file)
      : server_(std::in_place, ParamSources{.files = FilesOf(file), .overrides = ParamOverridesOfEnvironment()},
                LogOf(session)),
        session_(std::move(session)),
        service_(std::in_place, *session_, *server_) {}
  explicit ParamsHandle(std::shared_ptr<ContextHandle> context) : context_(std::move(context)) {}

  /// Errors: throws Error in a forked child, and after the end of the component.
  [[nodiscard]] std::shared_ptr<ParamServer> server() {
    RefuseInChild();
    if (!context_) return {std::shared_ptr<const void>(), &*server_};
    auto used = std::make_shared<ContextHandle::Used>(context_->Use());
    ParamServer& server = (*used)->params();
    return {std::move(used), &server};
  }
  template <class T>
  [[nodiscard]] T Declare(const std::string& path, const T& fallback, ParamInfo info) {
    return context_ ? context_->Use()->Declare<T>(path, fallback, std::move(info))
                    : server()->Declare<T>(path, fallback, std::move(info));
  }
  // With the GIL.
  void NoteDeclared(const std::string& path, Declared as) {
    if (as != Declared::kOther) declared_[ParamPath::Parse(path).ToString()] = as;
  }
  [[nodiscard]] Declared DeclaredAs(const ParamPath& path) const {
    const auto found = declared_.find(path.ToString());
    return found == declared_.end() ? Declared::kOther : found->second;
  }
  void Watch(const std::string& path, const std::shared_ptr<Inbox>& inbox) {
    auto listening = server()->OnChange(path, [inbox](const ParamEvent& event) {
      ParamsChanged changed;
      for (const auto& one : event.paths) changed.paths.push_back(one.ToString());
      inbox->Push(std::move(changed));
    });
    const std::scoped_lock lock(mutex_);
    if (session_ || context_) listening_.push_back(std::move(listening));
  }
  // The server stays: its values can still be read.
  void End() {
    if (of_parent()) return;
    std::vector<Listening> ended;  // Destroyed after the lock.
    std::shared_ptr<Session> session;
    const std::scoped_lock lock(mutex_);
    ended.swap(listening_);
    service_.reset();
    session.swap(session_);
  }

 private:
  // The server may outlive the session.
  static LogSink LogOf(const std::weak_ptr<Session>& session) {
    return [session](LogLevel level, std::string_view text) {
      if (const auto open = session.lock()) open->log().Write(level, text);
    };
  }
  static std::vector<std::filesystem::path> FilesOf(const std::optional<std::string>& file) {
    if (!file) return {};
    return {std::filesystem::path(*file)};
  }

  const std::shared_ptr<ContextHandle> context_;  // Null: the parameters of a program.
  std::optional<ParamServer> server_;
  std::shared_ptr<Session> session_;
  std::optional<ParamService> service_;
  std::map<std::string, Declared> declared_;  // By path; used with the GIL.
  std::mutex mutex_;
  std::vector<Listening> listening_;
};

template <class T>
std::optional<T> Try(const ParamView& view) {
  try {
    return view.as<T>();
  } catch (const ParamError&) {
    return {};
  }
}

// A text that was not quoted is a bool or a number if it looks like one, unless it was declared as something else.
py::object ToPython(const ParamsHandle& handle, const ParamView& view, Declared as = Declared::kOther) {
  if (!view.exists() || view.is_null()) return py::none();
  const ParamNode& node = *view.node();
  if (as == Declared::kOther) as = handle.DeclaredAs(view.path());
  switch (node.kind) {
    case ParamNode::Kind::kList: {
      py::list list;
      for (std::size_t i = 0; i < view.size(); ++i) list.append(ToPython(handle, view[i], as));
      return list;
    }
    case ParamNode::Kind::kMap: {
      py::dict map;
      for (const auto& key : view.keys()) map[py::str(key)] = ToPython(handle, view[key]);
      return map;
    }
    default: break;
  }
  if (as == Declared::kFloat) return py::float_(view.as<double>());
  if (as == Declared::kOther && !node.IsString()) {
    if (const auto flag = Try<bool>(view)) return py::bool_(*flag);
    if (const auto whole = Try<std::int64_t>(view)) return py::int_(*whole);
    if (const auto number = Try<double>(view)) return py::float_(*number);
  }
  return py::str(node.text);
}

std::int64_t WholeNumber(const py::handle& value) {
  try {
    return value.cast<std::int64_t>();
  } catch (const py::cast_error&) {
    throw py::value_error("A whole number of a parameter has at most 64 bits: it is from -2**63 to 2**63 - 1.");
  }
}

std::string Text(const py::handle& value) {
  if (!py::isinstance<py::str>(value)) throw py::type_error("The paths and keys of parameters are texts.");
  try {
    return value.cast<std::string>();
  } catch (const py::cast_error&) {
    throw py::value_error("A text of a parameter has half of a surrogate pair, so it cannot be written as UTF-8.");
  }
}

// At that depth files of parameters end, too. A list may contain itself.
constexpr int kMostNested = 64;

ParamNode ToNode(const py::handle& value, int depth = 0) {
  if (py::isinstance<py::bool_>(value)) return ParamCodec<bool>::Write(value.cast<bool>());
  if (py::isinstance<py::int_>(value)) return ParamCodec<std::int64_t>::Write(WholeNumber(value));
  if (py::isinstance<py::float_>(value)) return ParamCodec<double>::Write(value.cast<double>());
  if (py::isinstance<py::str>(value)) return ParamCodec<std::string>::Write(Text(value));
  if (depth == kMostNested) {
    throw py::value_error("The lists and dicts of a parameter are nested more than " + std::to_string(kMostNested) +
                          " deep, or one contains itself.");
  }
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    std::vector<ParamNode> items;
    for (const auto& item : value) items.push_back(ToNode(item, depth + 1));
    return ParamNode::List(std::move(items));
  }
  if (py::isinstance<py::dict>(value)) {
    std::vector<std::pair<std::string, ParamNode>> entries;
    for (const auto& [key, item] : value.cast<py::dict>()) entries.emplace_back(Text(key), ToNode(item, depth + 1));
    return ParamNode::Map(std::move(entries));
  }
  throw py::type_error("A parameter is a bool, a number, a text, a list or a dict, not " +
                       py::str(py::type::handle_of(value).attr("__name__")).cast<std::string>() + ".");
}

template <class T>
py::object Declare(ParamsHandle& handle, const std::string& path, const T& fallback, ParamInfo info) {
  const GilRelease released;
  const T value = handle.Declare<T>(path, fallback, std::move(info));
  const py::gil_scoped_acquire acquired;
  handle.NoteDeclared(path, kDeclared<T>);
  return py::cast(value);
}

[[noreturn]] void RefuseDefault() {
  throw py::type_error("The default of a parameter is a bool, a number, a text, or a list of one of these.");
}

template <class T>
bool AllAre(const py::list& list) {
  for (const auto& item : list) {
    if (!py::isinstance<T>(item)) return false;
  }
  return true;
}

template <class T>
std::vector<T> ItemsOf(const py::list& list, T (*read)(const py::handle& item)) {
  std::vector<T> items;
  for (const auto& item : list) items.push_back(read(item));
  return items;
}

std::vector<double> Numbers(const py::list& list) {
  try {
    return list.cast<std::vector<double>>();  // Whatever can be a float, such as numbers of numpy.
  } catch (const py::cast_error&) {
    RefuseDefault();
  }
}

py::object DeclareList(ParamsHandle& handle, const std::string& path, const py::list& fallback, ParamInfo info) {
  if (AllAre<py::str>(fallback)) return Declare(handle, path, ItemsOf(fallback, &Text), std::move(info));
  if (AllAre<py::bool_>(fallback)) {  // Also ints, for Python.
    return Declare(handle, path, fallback.cast<std::vector<bool>>(), std::move(info));
  }
  if (AllAre<py::int_>(fallback)) return Declare(handle, path, ItemsOf(fallback, &WholeNumber), std::move(info));
  return Declare(handle, path, Numbers(fallback), std::move(info));
}

py::object DeclareAny(ParamsHandle& handle, const std::string& path, const py::object& fallback, ParamInfo info) {
  if (py::isinstance<py::bool_>(fallback)) return Declare(handle, path, fallback.cast<bool>(), std::move(info));
  if (py::isinstance<py::int_>(fallback)) return Declare(handle, path, WholeNumber(fallback), std::move(info));
  if (py::isinstance<py::float_>(fallback)) return Declare(handle, path, fallback.cast<double>(), std::move(info));
  if (py::isinstance<py::str>(fallback)) return Declare(handle, path, Text(fallback), std::move(info));
  if (py::isinstance<py::list>(fallback)) return DeclareList(handle, path, fallback.cast<py::list>(), std::move(info));
  RefuseDefault();
}

std::string Set(ParamsHandle& handle, const py::dict& values) {
  std::vector<ParamChange> changes;
  for (const auto& [path, value] : values) {
    ParamChange change{Text(path), std::nullopt};
    if (!value.is_none()) change.value = ToNode(value);
    changes.push_back(std::move(change));
  }
  const GilRelease released;
  return handle.server()->Change(changes).refusal;
}

}  // namespace

void BindParams(py::module_& module) {
  py::class_<ParamsHandle, Owned<ParamsHandle>>(module, "Params", "The parameters of a program.")
      .def(py::init([](const SessionHandle& session, const std::optional<std::string>& file) {
             const GilRelease released;
             return MakeOwned<ParamsHandle>(session.Use(), file);
           }),
           py::arg("session"), py::arg("file"))
      .def(py::init([](const std::shared_ptr<ContextHandle>& context) { return MakeOwned<ParamsHandle>(context); }),
           py::arg("context"))
      .def("get", [](ParamsHandle& handle,
                     const std::string& path) { return ToPython(handle, handle.server()->Snapshot().At(path)); })
      .def("has",
           [](ParamsHandle& handle, const std::string& path) { return handle.server()->Snapshot().At(path).exists(); })
      .def(
          "declare",
          [](ParamsHandle& handle, const std::string& path, const py::object& fallback, const std::string& description,
             const std::string& unit, std::optional<double> least, std::optional<double> most,
             const std::vector<std::string>& choices, bool read_only) {
            return DeclareAny(handle, path, fallback, {description, unit, least, most, choices, read_only});
          },
          py::arg("path"), py::arg("fallback"), py::arg("description"), py::arg("unit"), py::arg("least"),
          py::arg("most"), py::arg("choices"), py::arg("read_only"))
      .def("set", &Set, py::arg("values"))
      .def("watch", &ParamsHandle::Watch, Released(), py::arg("path"), py::arg("inbox"))
      .def(
          "save", [](ParamsHandle& handle) { handle.server()->Save(); }, Released())
      .def("end", &ParamsHandle::End, Released());
}

}  // namespace hgros::python
