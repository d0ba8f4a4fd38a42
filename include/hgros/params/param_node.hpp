#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"

namespace hgros {

struct ParamNode;
using ParamNodePtr = std::shared_ptr<const ParamNode>;

/// Where a value was set.
struct HGROS_EXPORT ParamOrigin {
  std::shared_ptr<const std::string> source;  ///< A file, "--param ...", an environment variable ...
  int line = 0;                               ///< In a file, starting at 1.
  int column = 0;
  bool at_run_time = false;  ///< Set by Set(): Save() writes these values.

  /// "robot.yaml:3:15", or the name of the source; empty if the value was never set.
  [[nodiscard]] std::string ToString() const;
};

/// One value in a tree of parameters. A tree never changes: changing a parameter makes a new tree that shares the
/// unchanged values with the old one. Text is kept as written; the reader decides its type.
struct HGROS_EXPORT ParamNode {
  enum class Kind : std::uint8_t { kNull, kText, kList, kMap };

  Kind kind = Kind::kNull;
  bool quoted = false;  ///< For kText: never a number or a boolean.
  std::string text;
  std::vector<ParamNodePtr> items;
  std::vector<std::pair<std::string, ParamNodePtr>> entries;  ///< In the order of the file.
  ParamOrigin origin;

  [[nodiscard]] static ParamNode Text(std::string text, bool quoted);
  [[nodiscard]] static ParamNode List(std::vector<ParamNode> items);
  [[nodiscard]] static ParamNode Map(std::vector<std::pair<std::string, ParamNode>> entries);

  /// Null if this is not a map or has no such key.
  [[nodiscard]] ParamNodePtr Find(std::string_view key) const;
  /// Text that cannot be anything else: quoted, or neither a number nor a boolean.
  [[nodiscard]] bool IsString() const;
  /// "the number 5", "a list" ...: completes "is ...".
  [[nodiscard]] std::string Description() const;
  /// Equal, ignoring where the value was set and how it was spelled in YAML.
  [[nodiscard]] bool SameValue(const ParamNode& other) const;
};

}  // namespace hgros
