#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/params/param_server.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

/// An answer of another session: a value, or one sentence that says why there is none.
template <class T>
struct RemoteParam {
  std::optional<T> value = {};
  std::string refusal = {};

  [[nodiscard]] bool ok() const noexcept { return value.has_value(); }
  [[nodiscard]] const T& operator*() const& { return *value; }
  [[nodiscard]] T operator*() && { return *std::move(value); }  ///< Lets a loop iterate over `*params.List()`.
  [[nodiscard]] const T* operator->() const { return &*value; }
};

/// The parameters that another session, or this one, offers with a ParamService, found by its name. A read value is at
/// least as new as the call: it includes every change made before.
///
/// Threading: thread-safe. Each call waits for its answer, at most until the timeout; do not call it in inline
/// callbacks or in the offering server's validators and listeners.
/// Lifetime:  ends before its session.
/// Errors:    the constructor throws Error if the name cannot be part of a channel name. Everything else is in the
/// results: no session offers these parameters, no answer in time, or why a change was refused.
class HGROS_EXPORT RemoteParams {
 public:
  RemoteParams(Session& session, std::string_view name, std::chrono::nanoseconds timeout = std::chrono::seconds(2),
               LogSink log = DefaultLogSink());
  RemoteParams(const RemoteParams&) = delete;
  RemoteParams& operator=(const RemoteParams&) = delete;
  ~RemoteParams();

  /// All parameters as one consistent set.
  [[nodiscard]] RemoteParam<ParamView> Snapshot();
  /// The paths of all values at and below `path` that are not maps, in the order of the files.
  [[nodiscard]] RemoteParam<std::vector<std::string>> List(std::string_view path = {});
  template <class T>
  [[nodiscard]] RemoteParam<T> Get(std::string_view path) {
    RemoteParam<ParamView> all = Snapshot();
    if (!all.ok()) return {{}, std::move(all.refusal)};
    try {
      return {all->Get<T>(path), {}};
    } catch (const ParamError& e) {
      return {{}, e.what()};
    }
  }
  /// The declarations at and below `path`.
  [[nodiscard]] RemoteParam<std::vector<ParamDeclaration>> Describe(std::string_view path = {});

  /// Changes all of them at once, or none: then the result has the reason. A parameter that does not exist is a reason
  /// to refuse, unless `if_missing` says otherwise.
  ParamResult Change(const std::vector<ParamChange>& changes, IfMissing if_missing = IfMissing::kRefuse);
  template <class T>
  ParamResult Set(std::string_view path, const T& value, IfMissing if_missing = IfMissing::kRefuse) {
    return Change({ParamChange::Of(path, value)}, if_missing);
  }
  ParamResult Set(std::string_view path, const char* value, IfMissing if_missing = IfMissing::kRefuse) {
    return Set(path, std::string(value), if_missing);
  }
  ParamResult Remove(std::string_view path) { return Change({{std::string(path), std::nullopt}}); }

  /// Calls `listener` after each change at, below or above `path`. The first call, once the parameters are reached, has
  /// all current values, as if they had just been added. Changes that come faster than the listener returns may be
  /// merged. If nothing is at `path` when the parameters are reached, the log says so. Runs as a serial node of the
  /// session's graph and may make the other calls of this class.
  [[nodiscard("the listener is called only while the Subscription lives")]] Subscription Watch(std::string_view path,
                                                                                               ParamListener listener);

  /// Ends the calls that wait for an answer, and all later ones, with a refusal.
  void EndWaits() noexcept;

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros
