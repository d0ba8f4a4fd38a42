#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/listeners.hpp"
#include "hgros/base/log.hpp"
#include "hgros/params/param_codec.hpp"
#include "hgros/params/param_sources.hpp"
#include "hgros/params/param_view.hpp"

namespace hgros {

/// What is said of a parameter when it is declared.
struct ParamInfo {
  std::string description = {};
  std::string unit = {};                  ///< Of durations the range is in seconds.
  std::optional<double> least = {};       ///< Of a number, a duration, or each item of a list.
  std::optional<double> most = {};        ///< Both are included.
  std::vector<std::string> choices = {};  ///< Of a text, or each item of a list.
  bool read_only = false;                 ///< Stays as it was when the program began.
  bool operator==(const ParamInfo&) const = default;
};

struct ParamDeclaration {
  std::string path;
  ParamInfo info;
};

/// One parameter to be set, or, without a value, to be removed; one that is declared goes back to its default.
struct ParamChange {
  std::string path;
  std::optional<ParamNode> value;

  template <class T>
  [[nodiscard]] static ParamChange Of(std::string_view path, const T& value) {
    return {std::string(path), ParamCodec<T>::Write(value)};
  }
};

/// What came of a wish to change parameters: done, or why nothing of it was.
struct ParamResult {
  std::string refusal = {};
  [[nodiscard]] bool ok() const noexcept { return refusal.empty(); }
};

/// Parameters have changed, or are about to.
struct ParamEvent {
  ParamView before;
  ParamView after;
  std::vector<ParamPath> paths;  ///< What differs: values that are no maps, and whole maps that come or go.

  [[nodiscard]] bool Touches(const ParamPath& path) const;
};

/// Returns why `event.after` cannot be, or nothing.
using ParamValidator = std::function<std::optional<std::string>(const ParamEvent& event)>;
using ParamListener = std::function<void(const ParamEvent& event)>;

/// The parameters of a program: read from files, overridden, declared, changed while it runs, and saved.
///
/// Thread safety: all of it. What is read is one tree that never changes; a change puts another one in its place,
/// whole. Ordering: listeners hear of changes one after the other, in the order in which these were made, each in the
/// order in
///   which the listeners came. They run on a thread that makes a change, without any lock, and may change parameters
///   themselves: that is heard of after the present change.
/// Errors: what is wrong with files, declarations and reading throws ConfigError or ParamError; a change that cannot be
/// is a
///   result with the reason.
class HGROS_EXPORT ParamServer {
 public:
  /// Reads all sources. Throws ConfigError or ParamError naming file, line and column.
  explicit ParamServer(ParamSources sources = {}, LogSink log = DefaultLogSink());
  ParamServer(const ParamServer&) = delete;
  ParamServer& operator=(const ParamServer&) = delete;
  ~ParamServer();

  /// All parameters as they are at this moment; what one snapshot shows belongs together.
  [[nodiscard]] ParamView Snapshot() const;
  [[nodiscard]] ParamView operator[](std::string_view key) const { return Snapshot()[key]; }
  template <class T>
  [[nodiscard]] T Get(std::string_view path) const {
    return Snapshot().Get<T>(path);
  }
  template <class T>
  [[nodiscard]] T Get(std::string_view path, T fallback) const {
    return Snapshot().Get<T>(path, std::move(fallback));
  }

  /// Says that there is such a parameter, and gives its value: `fallback` if nobody has said one. From then on it is
  /// always a T within the bounds of `info`. Throws ParamError if it is not now, or is declared otherwise already.
  template <class T>
  T Declare(std::string_view path, const T& fallback, ParamInfo info = {}) {
    const ParamView view = DeclareNode(path, ParamCodec<T>::Write(fallback), std::move(info),
                                       [](const ParamView& value) { (void)value.as<T>(); });
    return view.as<T>();
  }
  [[nodiscard]] std::vector<ParamDeclaration> Declarations() const;

  /// Changes all of them at once, or none. Values that are the same already are no change.
  ParamResult Change(const std::vector<ParamChange>& changes);
  template <class T>
  ParamResult Set(std::string_view path, const T& value) {
    return Change({ParamChange::Of(path, value)});
  }
  ParamResult Set(std::string_view path, const char* value) { return Set(path, std::string(value)); }
  ParamResult Remove(std::string_view path) { return Change({{std::string(path), std::nullopt}}); }

  /// Asks before each change at, below or above `path`; an empty one asks always. May be asked again about one change,
  /// when another one came first. It neither saves nor reloads.
  [[nodiscard]] Listening AddValidator(std::string_view path, ParamValidator validator);
  /// Tells of each such change.
  [[nodiscard]] Listening OnChange(std::string_view path, ParamListener listener);

  /// Writes what was set while running into the files that say these parameters, the rest into the last file. Each file
  /// is replaced in one go; its comments and the order of its keys stay wherever that is possible. Overrides are not
  /// saved. Throws Error if there is no file or one cannot be written.
  void Save();
  /// Writes all parameters as they are into a file of its own.
  void SaveAs(const std::filesystem::path& file) const;
  /// Reads the files again. What has changed in them since they were read wins over what was set while running. If they
  /// cannot be read or say what cannot be, everything stays as it is.
  ParamResult Reload();
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const noexcept;

 private:
  class Core;
  using TypeCheck = std::function<void(const ParamView&)>;
  ParamView DeclareNode(std::string_view path, ParamNode fallback, ParamInfo info, TypeCheck check);

  std::shared_ptr<Core> core_;
};

}  // namespace hgros
