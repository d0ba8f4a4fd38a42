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

/// How values of T are read and written; ParamCodec<T>::Read(view) throws ParamError, ::Write(value) gives a ParamNode.
/// param_codec.hpp has what is known; specialize it for types of your own.
template <class T>
struct ParamCodec;

/// One place in a tree of parameters that never changes, whether something stands there or not; it keeps its tree.
/// `params["slam"]["matcher"]["max_distance"].as<double>()`, or `params.Get<double>("slam.matcher.max_distance")`.
///
/// Thread safety: const.
/// Errors: throws ParamError naming path, wanted type, what stands there and where it was said.
class HGROS_EXPORT ParamView {
 public:
  /// The root of a tree.
  explicit ParamView(ParamNodePtr root) : ParamView(std::move(root), {}) {}
  ParamView(ParamNodePtr node, ParamPath path) : node_(std::move(node)), path_(std::move(path)) {}

  /// What is not there has nothing below it; no error before it is read.
  [[nodiscard]] ParamView operator[](std::string_view key) const;
  [[nodiscard]] ParamView operator[](std::size_t index) const;
  [[nodiscard]] ParamView At(const ParamPath& path) const;
  [[nodiscard]] ParamView At(std::string_view path) const { return At(ParamPath::Parse(path)); }

  [[nodiscard]] bool exists() const noexcept { return node_ != nullptr; }
  [[nodiscard]] bool is_null() const noexcept { return node_ != nullptr && node_->kind == ParamNode::Kind::kNull; }
  [[nodiscard]] std::size_t size() const noexcept;  ///< Of a list or map; 0 of anything else.
  [[nodiscard]] std::vector<std::string> keys() const;
  [[nodiscard]] const ParamNodePtr& node() const noexcept { return node_; }
  [[nodiscard]] const ParamPath& path() const noexcept { return path_; }

  template <class T>
  [[nodiscard]] T as() const {
    return ParamCodec<T>::Read(*this);
  }
  /// `fallback` if there is nothing; what is there has to be a T all the same.
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
  /// Throws unless this is a list, or a map. Nothing at all, but for an empty value, is neither.
  void RequireList(std::string_view wanted) const;
  void RequireMap(std::string_view wanted) const;
  /// Throws if the map has a key that is not among these, naming the nearest one.
  void RequireKeys(const std::vector<std::string>& known) const;

 private:
  ParamNodePtr node_;  // null: nothing is there
  ParamPath path_;
};

}  // namespace hgros
