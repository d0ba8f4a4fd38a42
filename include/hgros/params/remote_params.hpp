#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/params/param_server.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

/// What another session has answered: a value, or in one sentence why there is none.
template <class T>
struct RemoteParam {
  std::optional<T> value = {};
  std::string refusal = {};

  [[nodiscard]] bool ok() const noexcept { return value.has_value(); }
  [[nodiscard]] const T& operator*() const& { return *value; }
  [[nodiscard]] T operator*() && { return *std::move(value); }  ///< So that a loop may go over `*params.List()`.
  [[nodiscard]] const T* operator->() const { return &*value; }
};

/// The parameters that another session, or this one, offers with a ParamService, by its name. What is read is as new as
/// the question: it holds whatever was set before, by anybody.
///
/// Threading: thread-safe. Each call waits for its answer, until the time-out at most: not in inline callbacks, and not
/// in the offering server's validators and listeners.
/// Lifetime: ends before its session.
/// Errors: the constructor throws Error if the name cannot be part of a channel's name. All else is in the results:
/// nobody offers such parameters, no answer in time, or why a change was refused.
class HGROS_EXPORT RemoteParams {
 public:
  RemoteParams(Session& session, std::string_view name, std::chrono::nanoseconds timeout = std::chrono::seconds(2));
  RemoteParams(const RemoteParams&) = delete;
  RemoteParams& operator=(const RemoteParams&) = delete;
  ~RemoteParams();

  /// All parameters, as one set that belongs together.
  [[nodiscard]] RemoteParam<ParamView> Snapshot();
  /// The paths of all values at and below `path` that are no maps, in the order of the files.
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
  /// What was declared at and below `path`.
  [[nodiscard]] RemoteParam<std::vector<ParamDeclaration>> Describe(std::string_view path = {});

  /// Changes all of them at once, or none: then the result says why.
  ParamResult Change(const std::vector<ParamChange>& changes);
  template <class T>
  ParamResult Set(std::string_view path, const T& value) {
    return Change({ParamChange::Of(path, value)});
  }
  ParamResult Set(std::string_view path, const char* value) { return Set(path, std::string(value)); }
  ParamResult Remove(std::string_view path) { return Change({{std::string(path), std::nullopt}}); }

  /// Calls `listener` after each change at, below or above `path`; first of all with what is there when the parameters
  /// are reached, as if all had come just then. Changes that follow each other faster than the listener returns may
  /// come as one. A serial node of the session's graph; the other calls of this class may be made in it.
  [[nodiscard("the listener is called only while the Subscription lives")]] Subscription Watch(std::string_view path,
                                                                                               ParamListener listener);

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros
