#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/export.hpp"

namespace hgros::yaml {

/// Bounds that keep a hostile or broken file from costing more than a moment.
inline constexpr std::size_t kMaxFileBytes = 1024 * 1024;
inline constexpr int kMaxDepth = 64;                  ///< Of lists and maps within each other.
inline constexpr std::uint64_t kMaxWeight = 200'000;  ///< Of all values, aliases counted as often as they are used.

/// One value as it stands in the text; its type is decided by whoever reads it.
struct Node {
  enum class Kind : std::uint8_t { kNull, kText, kList, kMap };
  struct Entry {
    const Node* key = nullptr;  ///< Always of kind kText.
    const Node* value = nullptr;
  };

  Kind kind = Kind::kNull;
  bool quoted = false;  ///< Of kText: quoted, a block or tagged !!str, so never a number or a truth value.
  int line = 0;
  int column = 0;
  std::uint64_t weight = 1;
  std::string text;
  std::vector<const Node*> items;
  std::vector<Entry> entries;  ///< In the order of the text, without repeated keys.
};

/// One parsed YAML file: a tree of nodes, in which aliased ones have several parents, but never themselves below them.
class HGROS_EXPORT Document {
 public:
  /// Throws ConfigError for what is not one YAML document of UTF-8 text within the bounds above, and for repeated keys.
  [[nodiscard]] static Document Parse(std::string_view text, std::string name);
  /// Likewise from a file.
  [[nodiscard]] static Document Load(const std::filesystem::path& file);

  [[nodiscard]] const Node& root() const noexcept { return *root_; }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] FilePosition PositionOf(const Node& node) const { return {name_, node.line, node.column}; }

 private:
  friend class DocumentBuilder;
  explicit Document(std::string name) : name_(std::move(name)) {}

  std::string name_;
  std::deque<Node> nodes_;  // a deque never moves its elements, also when it is moved itself
  const Node* root_ = nullptr;
};

}  // namespace hgros::yaml
