#pragma once

#include <optional>
#include <string>
#include <type_traits>

#include <hgros/component/context.hpp>

#include "../tunables.hpp"

namespace slam2d {

/// All numbers of an options struct as parameters of a component.
///
/// Threading: one thread at a time.
template <class Options>
class Tuned {
 public:
  explicit Tuned(hgros::Context& context) : params_(context.params()) {
    const Options defaults;
    ForEachTunable("", defaults, [&context](const std::string& path, const auto& tunable, const auto& value) {
      (void)context.Declare(path, value,
                            {.description = tunable.description,
                             .unit = tunable.unit,
                             .least = tunable.least,
                             .most = tunable.most,
                             .read_only = tunable.when == When::kAtStart});
    });
  }

  /// All current values.
  [[nodiscard]] Options Now() const { return Read(params_.Snapshot()); }

  /// Likewise, if anything has changed since the last call. A change is complete or not there at all.
  [[nodiscard]] std::optional<Options> News() {
    const hgros::ParamView now = params_.Snapshot();
    if (now.node() == seen_) return std::nullopt;
    seen_ = now.node();
    return Read(now);
  }

 private:
  [[nodiscard]] static Options Read(const hgros::ParamView& params) {
    Options options;
    ForEachTunable("", options, [&params](const std::string& path, const auto&, auto& value) {
      value = params.Get<std::remove_reference_t<decltype(value)>>(path);
    });
    return options;
  }

  hgros::ParamServer& params_;
  hgros::ParamNodePtr seen_;
};

}  // namespace slam2d
