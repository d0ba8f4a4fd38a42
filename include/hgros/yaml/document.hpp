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

/// Limits that keep a hostile or broken file from costing more than a moment.
inline constexpr std::size_t kMaxFileBytes = 1024 * 1024;
inline constexpr int kMaxDepth = 64;                  ///< Lists and maps nested within each other.
inline constexpr std::uint64_t kMaxWeight = 200'000;  ///< Number of values; an alias counts each time it is used.

/// The tags that a text may have.
enum class Tags : std::uint8_t {
  kCore,           ///< Those of YAML's core schema.
  kCoreAndBinary,  ///< Also !!binary: a text that is base64.
};

/// A value as written in the text; the reader decides its type.
struct Node {
  enum class Kind : std::uint8_t { kNull, kText, kList, kMap };
  struct Entry {
    const Node* key = nullptr;  ///< Always of kind kText.
    const Node* value = nullptr;
  };

  Kind kind = Kind::kNull;
  bool quoted = false;  ///< For kText: quoted, a block or tagged !!str or !!binary, so never a number or a boolean.
  int line = 0;
  int column = 0;
  std::uint64_t weight = 1;
  std::string text;
  std::vector<const Node*> items;
  std::vector<Entry> entries;  ///< In the order of the text; keys are unique.
};

/// A parsed YAML file: a tree of nodes. An aliased node has several parents; there are no cycles.
class HGROS_EXPORT Document {
 public:
  /// Throws ConfigError unless the text is one YAML document in UTF-8 within the limits above, without repeated keys.
  [[nodiscard]] static Document Parse(std::string_view text, std::string name, Tags tags = Tags::kCore);
  /// The same from a file.
  [[nodiscard]] static Document Load(const std::filesystem::path& file);

  Document(const Document&) = delete;  // Nodes point at each other.
  Document& operator=(const Document&) = delete;
  Document(Document&&) noexcept = default;
  Document& operator=(Document&&) noexcept = default;
  ~Document() = default;

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
