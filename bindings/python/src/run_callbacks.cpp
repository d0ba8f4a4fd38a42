#include "run_callbacks.hpp"

#include <pybind11/stl.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "session_handle.hpp"

namespace hgros::python {
namespace {

constexpr int kAtOnce = 32;  // Of one subscription, before others have their turn.

enum class Left { kNone, kMore, kOther };

// How messages are read: a tuple (decode, class or None, list). The list has what Prepare() has made: nothing, or the
// next MessageInfo, and for a class the next message and its MergeFromString.
struct KnownType {
  explicit KnownType(const py::tuple& parts) : decode(parts[0]), made(parts[1]), spare(parts[2]) {}

  py::object decode;
  py::object made;
  py::list spare;
};

// Ends a callback, also one that has raised an exception.
class RunningCallback {
 public:
  explicit RunningCallback(Inbox& inbox) : inbox_(inbox) { inbox_.CountCallback(); }
  RunningCallback(const RunningCallback&) = delete;
  RunningCallback& operator=(const RunningCallback&) = delete;
  ~RunningCallback() {
    current_cause = {};
    inbox_.Finish(failed_);
  }
  void Succeed() noexcept { failed_ = false; }

 private:
  Inbox& inbox_;
  bool failed_ = true;
};

void Clear(const py::list& list) { (void)PyList_SetSlice(list.ptr(), 0, PY_SSIZE_T_MAX, nullptr); }

struct Spare {
  py::object info;
  py::object message;
  py::object read;
};

Spare TakeSpare(KnownType& type) {
  Spare spare;
  if (type.spare.size() > 0) spare.info = type.spare[0];
  if (type.spare.size() > 2) {
    spare.message = type.spare[1];
    spare.read = type.spare[2];
  }
  Clear(type.spare);
  return spare;
}

// After a pause, making these takes longer than reading a message. So they are made before the pause.
void Prepare(KnownType& type) {
  if (!type.spare.empty()) return;
  try {
    type.spare.append(InfoOf({}));
    if (type.made.is_none()) return;
    py::object message = type.made();
    py::object read = message.attr("MergeFromString");
    type.spare.append(std::move(message));
    type.spare.append(std::move(read));
  } catch (py::error_already_set& fault) {
    if (!fault.matches(PyExc_MemoryError)) throw;  // The next message says that.
    Clear(type.spare);
  } catch (const std::bad_alloc&) {
    Clear(type.spare);
  }
}

py::object Decoded(Inbox& inbox, KnownType& type, Spare& spare, Heard& heard) {
  try {
    const py::object wire = WireOf(std::move(heard.message.data));
    if (!spare.message) return type.decode(wire);
    (void)spare.read(wire);
    return std::move(spare.message);
  } catch (...) {
    inbox.NoteUndecoded(heard.info.id.publisher);
    inbox.Skip();
    current_cause = {};
    throw;
  }
}

py::object InfoIn(Spare& spare, const MessageInfo& info) {
  if (!spare.info) return InfoOf(info);
  SetInfo(spare.info, info);
  return std::move(spare.info);
}

void Call(py::handle callback, const py::object& message, const py::object& info) {
  const std::array<PyObject*, 2> arguments{message.ptr(), info.ptr()};
  if (!py::reinterpret_steal<py::object>(
          PyObject_Vectorcall(callback.ptr(), arguments.data(), arguments.size(), nullptr))) {
    throw py::error_already_set();
  }
}

Left RunKnown(Inbox& inbox, KnownType& type, py::handle callback, int most) {
  bool more = true;
  for (int i = 0; more && i < most && !inbox.of_parent(); ++i) {  // A callback may fork.
    bool other = false;
    auto taken = inbox.TakeKnown(more, other);
    if (!taken) return other ? Left::kOther : Left::kNone;
    Heard& heard = std::get<Heard>(*taken);
    current_cause = heard.cause;
    inbox.Begin(heard.info);
    Spare spare = TakeSpare(type);
    py::object message = Decoded(inbox, type, spare, heard);
    spare.read = {};  // It keeps the message.
    RunningCallback running(inbox);
    Call(callback, std::exchange(message, {}), InfoIn(spare, heard.info));
    running.Succeed();
  }
  if (more) return Left::kMore;
  Prepare(type);
  return Left::kNone;
}

}  // namespace

int RunKnownOf(Inbox& inbox, const py::tuple& type, const py::object& callback, int most) {
  KnownType known(type);
  return static_cast<int>(RunKnown(inbox, known, callback, most));
}

py::tuple RunCallbacks(ReadyList& ready, const py::dict& known, double timeout_s, bool once) {
  const auto deadline = ReadyList::DeadlineIn(timeout_s);
  std::size_t ran = 0;
  while (true) {
    std::vector<int> keys;
    bool goes_on = ready.WaitUntil(deadline, keys);
    std::size_t at = 0;
    for (; goes_on && at < keys.size(); ++at) {
      const auto entry = py::reinterpret_borrow<py::tuple>(PyDict_GetItem(known.ptr(), py::int_(keys[at]).ptr()));
      if (!entry) break;
      auto& inbox = Held<Inbox>(entry[0]);
      KnownType type(entry[1]);
      const std::uint64_t before = inbox.ran();
      Left left = Left::kNone;
      try {
        left = RunKnown(inbox, type, entry[2], kAtOnce);
      } catch (py::error_already_set& fault) {
        if (fault.trace()) PyException_SetTraceback(fault.value().ptr(), fault.trace().ptr());
        keys.erase(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(at));
        return py::make_tuple(ran + inbox.ran() - before, keys, entry[3], fault.value());
      }
      ran += inbox.ran() - before;
      if (left == Left::kOther) break;
      if (left == Left::kMore) ready.Add(keys[at]);
      goes_on = !ready.woken() && !ready.of_parent();
    }
    keys.erase(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(at));
    if (!goes_on || !keys.empty() || (once && ran > 0)) return py::make_tuple(ran, keys, py::none(), py::none());
  }
}

}  // namespace hgros::python
