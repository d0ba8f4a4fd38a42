#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "bindings.hpp"
#include "hgros/base/error.hpp"
#include "hgros/tf/transforms.hpp"
#include "hosted/context_handle.hpp"
#include "ready_list.hpp"
#include "session_handle.hpp"
#include "waits.hpp"

namespace hgros::python {
namespace {

using Clock = std::chrono::steady_clock;
using Matrix = std::array<double, 16>;  // Row by row.

// The transforms of a session, which must end before it, or of a component.
class TransformsHandle : public OfProcess {
 public:
  // Whoever uses the transforms keeps their session, too. The transforms are destroyed first.
  struct Kept {
    explicit Kept(std::shared_ptr<Session> of) : session(std::move(of)), transforms(*session) {}
    std::shared_ptr<Session> session;
    Transforms transforms;
  };

  explicit TransformsHandle(std::shared_ptr<Session> session) : kept_(std::make_shared<Kept>(std::move(session))) {}
  // In a constructor this declares that the component uses transforms. Errors: as used(). Without the GIL.
  explicit TransformsHandle(std::shared_ptr<ContextHandle> context) : context_(std::move(context)) { (void)used(); }
  /// Release it without the GIL: it may be the last one. Errors: throws Error after End(), and in a
  /// forked child.
  [[nodiscard]] std::shared_ptr<Transforms> used() const {
    RefuseInChild();
    if (context_) {
      auto used = std::make_shared<ContextHandle::Used>(context_->Use());
      Transforms& transforms = (*used)->transforms();
      return {std::move(used), &transforms};
    }
    const std::scoped_lock lock(mutex_);
    if (!kept_) throw Error("The session of the transforms is closed.");
    return {kept_, &kept_->transforms};
  }
  void End() {
    if (of_parent()) return;
    std::shared_ptr<Kept> last;  // Released after the lock.
    const std::scoped_lock lock(mutex_);
    last.swap(kept_);
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<Kept> kept_;
  const std::shared_ptr<ContextHandle> context_;
};

RigidTransform FromMatrix(const Matrix& rows) {
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      isometry.matrix()(row, column) = rows[static_cast<std::size_t>(4 * row + column)];
    }
  }
  return RigidTransform(isometry);
}

Matrix ToMatrix(const RigidTransform& transform) {
  const Eigen::Matrix4d matrix = transform.Isometry().matrix();
  Matrix rows{};
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) rows[static_cast<std::size_t>(4 * row + column)] = matrix(row, column);
  }
  return rows;
}

// In the order of TransformFault.
constexpr std::array<const char*, 7> kFaults{"",        "unknown frame", "not connected", "too old",
                                             "too new", "timeout",       "stopped"};

py::tuple ToPython(const TransformResult& result) {
  if (!result)
    return py::make_tuple(py::none(), 0, kFaults.at(static_cast<std::size_t>(result.fault())), result.text());
  return py::make_tuple(ToMatrix(result->T_target_source), result->stamp.nanoseconds, "", "");
}

using Used = std::shared_ptr<Transforms>;

TransformResult Find(const TransformsHandle& handle, const std::string& target, const std::string& source,
                     std::optional<std::int64_t> stamp_ns) {
  const GilRelease released;
  const Used used = handle.used();
  return stamp_ns ? used->FromTF(target, source, Time{*stamp_ns}) : used->FromTF(target, source);
}

TransformQuery QueryOf(TransformTree& tree, const std::string& target, const std::string& source,
                       std::optional<std::int64_t> stamp_ns) {
  TransformQuery query(tree.Frame(target), tree.Frame(source));
  if (stamp_ns) query.source_time = Time{*stamp_ns};
  return query;
}

// Keeps a wait for a transform.
struct PendingHandle : public OfProcess {
  explicit PendingHandle(PendingTransform wait) : pending(std::move(wait)) {}
  PendingTransform pending;
};

// `ready` gets a key when the transform is there, or can no longer come.
Owned<PendingHandle> WhenAvailable(const TransformsHandle& handle, const std::string& target, const std::string& source,
                                   std::optional<std::int64_t> stamp_ns, const std::shared_ptr<ReadyList>& ready) {
  const Used used = handle.used();
  TransformTree& tree = used->tree();
  return MakeOwned<PendingHandle>(
      tree.WhenAvailable(QueryOf(tree, target, source, stamp_ns), [ready](const TransformResult&) { ready->Add(0); }));
}

// Between two parts of a wait nothing is kept, so the session can close.
TransformResult WaitPart(const TransformsHandle& handle, const std::string& target, const std::string& source,
                         std::optional<std::int64_t> stamp_ns, Clock::time_point deadline) {
  const GilRelease released;
  const Used used = handle.used();
  TransformTree& tree = used->tree();
  const TransformQuery query = QueryOf(tree, target, source, stamp_ns);
  const auto left = std::chrono::duration_cast<Duration>(deadline - Clock::now());
  return tree.Wait(query, std::clamp<Duration>(left, Duration(0), kSignalsEvery));
}

py::tuple Lookup(const TransformsHandle& handle, const std::string& target, const std::string& source,
                 std::optional<std::int64_t> stamp_ns, double timeout_s) {
  TransformResult result = Find(handle, target, source, stamp_ns);
  const auto deadline = Clock::now() + Nanoseconds(timeout_s);
  while (!result && Clock::now() < deadline) {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (WaitPart(handle, target, source, stamp_ns, deadline)) break;
  }
  // Once more, for the reason why there is none.
  return ToPython(result ? result : Find(handle, target, source, stamp_ns));
}

std::string Send(const TransformsHandle& handle, const std::string& parent, const std::string& child,
                 const Matrix& pose, std::optional<std::int64_t> stamp_ns) {
  const RigidTransform T_parent_child = FromMatrix(pose);
  const Used used = handle.used();
  return stamp_ns ? used->ToTF(Time{*stamp_ns}, parent, child, T_parent_child).text()
                  : used->ToStaticTF(parent, child, T_parent_child).text();
}

}  // namespace

void BindTransforms(py::module_& module) {
  const py::class_<PendingHandle, Owned<PendingHandle>> pending(module, "PendingTransform",
                                                                "Keeps a wait for a transform.");
  py::class_<TransformsHandle, Owned<TransformsHandle>>(module, "Transforms", "The transforms of a session.")
      .def(py::init([](const SessionHandle& session) {
             const GilRelease released;
             return MakeOwned<TransformsHandle>(session.Use());
           }),
           py::arg("session"))
      .def(py::init([](const std::shared_ptr<ContextHandle>& context) {
             const GilRelease released;
             return MakeOwned<TransformsHandle>(context);
           }),
           py::arg("context"))
      .def("lookup", &Lookup, py::arg("target"), py::arg("source"), py::arg("stamp_ns"), py::arg("timeout"))
      .def("when_available", &WhenAvailable, Released(), py::arg("target"), py::arg("source"), py::arg("stamp_ns"),
           py::arg("ready"))
      .def("end", &TransformsHandle::End, Released())
      .def("send", &Send, Released(), py::arg("parent"), py::arg("child"), py::arg("pose"), py::arg("stamp_ns"))
      .def(
          "restart_edge",
          [](const TransformsHandle& handle, const std::string& child, std::int64_t latest_ns) {
            return handle.used()->tree().RestartEdge(child, Time{latest_ns});
          },
          Released(), py::arg("child"), py::arg("latest_ns"))
      .def(
          "flush", [](const TransformsHandle& handle) { handle.used()->Flush(); }, Released());
}

}  // namespace hgros::python
