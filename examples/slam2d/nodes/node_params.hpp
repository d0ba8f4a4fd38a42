#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <hgros/params/param_file_watch.hpp>
#include <hgros/params/param_server.hpp>

#include "../app/console.hpp"
#include "../tunable.hpp"

namespace slam2d {

/// The parameters of one node: those below `prefix`. Changes while running are printed on the console. Undeclared
/// parameters are refused. Files may contain others, for other nodes.
///
/// Thread safety: all functions, once the parameters are declared.
class DeclaredParams {
 public:
  DeclaredParams(std::string_view prefix, const hgros::ParamSources& sources, Console& console);
  DeclaredParams(const DeclaredParams&) = delete;
  DeclaredParams& operator=(const DeclaredParams&) = delete;

  [[nodiscard]] hgros::ParamServer& server() { return server_; }

 private:
  [[nodiscard]] std::optional<std::string> Fault(const hgros::ParamEvent& event) const;

  const hgros::ParamPath prefix_;
  hgros::ParamServer server_;
  hgros::Listening validating_;
  hgros::Listening telling_;
};

/// "There is no parameter slam.matcher.max_rang_m. Did you mean slam.matcher.max_range_m?"
[[nodiscard]] std::string UnknownParam(const std::string& path, const std::vector<std::string>& known);

/// All numbers of an options struct as parameters below `prefix`. When one of their files is edited, it is read again.
///
/// Threading: thread-safe except for News().
/// Errors: the constructor throws ParamError naming the parameter and its origin.
template <class Options>
class NodeParams {
 public:
  NodeParams(std::string prefix, const hgros::ParamSources& sources, Console& console)
      : prefix_(std::move(prefix)), params_(prefix_, sources, console) {
    Options defaults;
    ForEachTunable(prefix_, defaults, [this](const std::string& path, const auto& tunable, const auto& value) {
      (void)params_.server().Declare(path, value,
                                     {.description = tunable.description,
                                      .unit = tunable.unit,
                                      .least = tunable.least,
                                      .most = tunable.most,
                                      .read_only = tunable.when == When::kAtStart});
    });
    if (!sources.files.empty()) edited_.emplace(server(), nullptr, console.log());
  }

  [[nodiscard]] hgros::ParamServer& server() { return params_.server(); }

  /// All current values.
  [[nodiscard]] Options Now() { return Read(server().Snapshot()); }

  /// Likewise, if anything has changed since the last call. A change is complete or not there at all.
  [[nodiscard]] std::optional<Options> News() {
    const hgros::ParamView now = server().Snapshot();
    if (now.node() == seen_) return std::nullopt;
    seen_ = now.node();
    return Read(now);
  }

 private:
  [[nodiscard]] Options Read(const hgros::ParamView& params) const {
    Options options;
    ForEachTunable(prefix_, options, [&params](const std::string& path, const auto&, auto& value) {
      value = params.Get<std::remove_reference_t<decltype(value)>>(path);
    });
    return options;
  }

  const std::string prefix_;
  DeclaredParams params_;
  hgros::ParamNodePtr seen_;
  std::optional<hgros::ParamFileWatch> edited_;
};

}  // namespace slam2d
