#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/params/param_error.hpp"
#include "hgros/params/param_node.hpp"
#include "hgros/params/param_path.hpp"

namespace hgros {

/// Reads and writes values of T: ParamCodec<T>::Read(view) throws ParamError, ::Write(value) returns a ParamNode.
/// param_codec.hpp has the known types; specialize this for types of your own.
template <class T>
struct ParamCodec;

/// A position in a tree of parameters, whether it has a value or not. The tree never changes; the view keeps it alive.
/// `params["slam"]["matcher"]["max_distance"].as<double>()`, or `params.Get<double>("slam.matcher.max_distance")`.
///
/// Thread safety: const.
/// Errors: throws ParamError naming the path, the wanted type, the actual value and where it was set.
class HGROS_EXPORT ParamView {
 public:
  /// The root of a tree.
  explicit ParamView(ParamNodePtr root) : ParamView(std::move(root), {}) {}
  ParamView(ParamNodePtr node, ParamPath path) : node_(std::move(node)), path_(std::move(path)) {}

  /// Below a missing value everything is missing; that is an error only when it is read.
  [[nodiscard]] ParamView operator[](std::string_view key) const;
  [[nodiscard]] ParamView operator[](std::size_t index) const;
  [[nodiscard]] ParamView At(const ParamPath& path) const;
  [[nodiscard]] ParamView At(std::string_view path) const { return At(ParamPath::Parse(path)); }

  [[nodiscard]] bool exists() const noexcept { return node_ != nullptr; }
  [[nodiscard]] bool is_null() const noexcept { return node_ != nullptr && node_->kind == ParamNode::Kind::kNull; }
  [[nodiscard]] std::size_t size() const noexcept;  ///< Number of values in a list or map; 0 for anything else.
  [[nodiscard]] std::vector<std::string> keys() const;
  [[nodiscard]] const ParamNodePtr& node() const noexcept { return node_; }
  [[nodiscard]] const ParamPath& path() const noexcept { return path_; }

  /// A map as the text of a file, anything else on one line. Throws ParamError or ConfigError if a text is not UTF-8.
  [[nodiscard]] std::string ToYaml() const;

  template <class T>
  [[nodiscard]] T as() const {
    return ParamCodec<T>::Read(*this);
  }
  /// `fallback` if the value is missing; an existing value must still be a T.
  template <class T>
  [[nodiscard]] T as(T fallback) const {
    return exists() ? ParamCodec<T>::Read(*this) : std::move(fallback);
  }
  template <class T>
  [[nodiscard]] T Get(std::string_view path) const {
    return At(path).template as<T>();
  }
  template <class T>
  [[nodiscard]] T Get(std::string_view path, T fallback) const {
    return At(path).template as<T>(std::move(fallback));
  }

  /// For codecs. Throws ParamError: "<path> must be <wanted>, but is <what it is>." or "... is not set."
  [[noreturn]] void FailType(std::string_view wanted, std::string_view mend = {}) const;
  /// Throws unless this is a list, or a map. An empty value counts as both, a missing one as neither.
  void RequireList(std::string_view wanted) const;
  void RequireMap(std::string_view wanted) const;
  /// Throws if the map has another key, and names the nearest of these.
  void RequireKeys(const std::vector<std::string>& known) const;

 private:
  ParamNodePtr node_;  // null: nothing is there
  ParamPath path_;
};

}  // namespace hgros
