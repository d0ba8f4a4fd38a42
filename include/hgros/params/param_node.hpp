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

/// Where a value was said.
struct HGROS_EXPORT ParamOrigin {
  std::shared_ptr<const std::string> source;  ///< A file, "--param ...", a variable of the environment ...
  int line = 0;                               ///< In a file, from 1.
  int column = 0;
  bool at_run_time = false;  ///< By Set(): what Save() writes.

  /// "robot.yaml:3:15", or what the source is; empty if nobody said it.
  [[nodiscard]] std::string ToString() const;
};

/// One value of a tree of parameters, which never changes: who changes a parameter makes a new tree that shares with
/// the old one whatever stays. Text is kept as written; its type is decided by whoever reads it.
struct HGROS_EXPORT ParamNode {
  enum class Kind : std::uint8_t { kNull, kText, kList, kMap };

  Kind kind = Kind::kNull;
  bool quoted = false;  ///< Of kText: never a number or a truth value.
  std::string text;
  std::vector<ParamNodePtr> items;
  std::vector<std::pair<std::string, ParamNodePtr>> entries;  ///< In the order of the file.
  ParamOrigin origin;

  [[nodiscard]] static ParamNode Text(std::string text, bool quoted);
  [[nodiscard]] static ParamNode List(std::vector<ParamNode> items);
  [[nodiscard]] static ParamNode Map(std::vector<std::pair<std::string, ParamNode>> entries);

  /// Null if this is no map or has no such key.
  [[nodiscard]] ParamNodePtr Find(std::string_view key) const;
  /// A text that can be nothing else: in quotes, or neither a number nor a truth value.
  [[nodiscard]] bool IsString() const;
  /// "the number 5", "a list" ...: completes "is ...".
  [[nodiscard]] std::string Description() const;
  /// Equal but for where it was said and how it was spelled as YAML.
  [[nodiscard]] bool SameValue(const ParamNode& other) const;
};

}  // namespace hgros
