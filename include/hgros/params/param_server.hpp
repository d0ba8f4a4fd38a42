#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/internal/base/listeners.hpp"
#include "hgros/params/param_codec.hpp"
#include "hgros/params/param_declaration.hpp"
#include "hgros/params/param_sources.hpp"
#include "hgros/params/param_view.hpp"

namespace hgros {

/// A parameter to set, or to remove if it has no value; a declared parameter then returns to its default.
struct ParamChange {
  std::string path;
  std::optional<ParamNode> value;

  template <class T>
  [[nodiscard]] static ParamChange Of(std::string_view path, const T& value) {
    return {std::string(path), ParamCodec<T>::Write(value)};
  }
};

/// What happens to a change of a parameter that does not exist: neither declared nor in a file, never set.
enum class IfMissing {
  kRefuse,
  kCreate,
};

/// The result of changing parameters: done, or the reason why nothing was changed.
struct ParamResult {
  std::string refusal = {};
  [[nodiscard]] bool ok() const noexcept { return refusal.empty(); }
};

/// Parameters have changed or are about to.
struct ParamEvent {
  ParamView before;
  ParamView after;
  std::vector<ParamPath> paths;  ///< Changed values that are not maps, and added or removed maps.

  [[nodiscard]] bool Touches(const ParamPath& path) const;
};

/// Returns why `event.after` is not acceptable, or std::nullopt if it is.
using ParamValidator = std::function<std::optional<std::string>(const ParamEvent& event)>;
using ParamListener = std::function<void(const ParamEvent& event)>;

/// The parameters of a program: read from files, overridden, declared, changed while it runs, and saved.
///
/// Thread safety: all functions. Readers see one tree that never changes; a change replaces it as a whole.
/// Ordering:  listeners are called for one change after the other, in the order in which the changes were made; for
/// each change in the order in which the listeners were added. They run on a thread that makes a change, without a
/// lock. They may change parameters themselves; listeners are called for that after the current change. Who changes
/// parameters faster than listeners return is held up, at most for 1 s each time.
/// Errors:    errors in files, declarations and reading throw ConfigError or ParamError. A refused change is a result
/// with the reason.
class HGROS_EXPORT ParamServer {
 public:
  /// Reads all sources. Throws ConfigError or ParamError naming file, line and column.
  explicit ParamServer(ParamSources sources = {}, LogSink log = DefaultLogSink());
  ParamServer(const ParamServer&) = delete;
  ParamServer& operator=(const ParamServer&) = delete;
  ~ParamServer();

  /// All parameters at this moment, as one consistent set.
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

  /// Declares a parameter and returns its value: `fallback` if it was never set. From then on it is always a T within
  /// the bounds of `info`. Throws ParamError if its current value is not, or if it was declared differently before.
  template <class T>
  T Declare(std::string_view path, const T& fallback, ParamInfo info = {}) {
    const ParamView view = DeclareNode(path, ParamCodec<T>::Write(fallback), std::move(info),
                                       [](const ParamView& value) { (void)value.as<T>(); });
    return view.as<T>();
  }
  template <std::size_t N>
  std::string Declare(std::string_view path, const char (&fallback)[N], ParamInfo info = {}) {
    return Declare(path, std::string(fallback), std::move(info));
  }
  [[nodiscard]] std::vector<ParamDeclaration> Declarations() const;

  /// Changes all of them at once, or none. A value that stays the same is not a change. The sections of a session
  /// (`network`, `discovery`, `shared_memory`, `time`, `data_graph`, `channels`) are no parameters, even if they are in
  /// the files: they are left out there, and refused here and in Declare.
  ParamResult Change(const std::vector<ParamChange>& changes, IfMissing if_missing = IfMissing::kCreate);
  template <class T>
  ParamResult Set(std::string_view path, const T& value) {
    return Change({ParamChange::Of(path, value)});
  }
  ParamResult Set(std::string_view path, const char* value) { return Set(path, std::string(value)); }
  ParamResult Remove(std::string_view path) { return Change({{std::string(path), std::nullopt}}); }

  /// Asks `validator` before each change at, below or above `path`; an empty path means every change. It can be asked
  /// again about the same change when another change came first. It must not save or reload.
  [[nodiscard]] Listening AddValidator(std::string_view path, ParamValidator validator);
  /// Calls `listener` after each such change.
  [[nodiscard]] Listening OnChange(std::string_view path, ParamListener listener);

  /// Writes values that were set at run time into the files that define these parameters, the others into the last
  /// file. Each file is replaced atomically; comments and the order of keys are kept where possible. Overrides are not
  /// saved. Throws Error if there is no file or one cannot be written.
  void Save();
  /// Writes all current parameters into a separate file.
  void SaveAs(const std::filesystem::path& file) const;
  /// Reads the files again. Values that changed in a file since it was last read replace values set at run time. If a
  /// file cannot be read or has unacceptable values, nothing changes.
  ParamResult Reload();
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const noexcept;

 private:
  class Core;
  using TypeCheck = std::function<void(const ParamView&)>;
  ParamView DeclareNode(std::string_view path, ParamNode fallback, ParamInfo info, TypeCheck check);

  std::shared_ptr<Core> core_;
};

}  // namespace hgros
