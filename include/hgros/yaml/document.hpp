#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
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
  const std::string* file = nullptr;  ///< The name of its file. Lives as long as a document with this node.
  int line = 0;
  int column = 0;
  std::uint64_t weight = 1;
  std::string text;
  std::vector<const Node*> items;
  std::vector<Entry> entries;  ///< In the order of the text; keys are unique.
};

/// Returns the value of a variable, or nothing if it is not set.
using Variables = std::function<std::optional<std::string>(const std::string& name)>;

/// The variables of the environment.
[[nodiscard]] HGROS_EXPORT std::optional<std::string> EnvironmentVariable(const std::string& name);

/// A YAML text, or several that are merged: a tree of nodes. An aliased node has several parents; there are no cycles.
class HGROS_EXPORT Document {
 public:
  /// Throws ConfigError unless the text is one YAML document in UTF-8 within the limits above, without repeated keys.
  [[nodiscard]] static Document Parse(std::string_view text, std::string name, Tags tags = Tags::kCore);
  /// The same from a file.
  [[nodiscard]] static Document Load(const std::filesystem::path& file);
  /// The same from a file, in which each `${NAME}` stands for the value of a variable, `${NAME:-text}` for `text` if
  /// the variable is not set or empty, and `$${` for `${`. The key `include` at the top names files, relative to this
  /// one, on top of which this one is merged. Throws ConfigError also for a variable that is not set, and for files
  /// that include each other.
  [[nodiscard]] static Document Assemble(const std::filesystem::path& file,
                                         const Variables& variables = EnvironmentVariable);
  /// A single value that is in no file: positions have only `name`, such as "--set speed".
  [[nodiscard]] static Document ParseValue(std::string_view text, std::string name);
  /// An argument of a command line, or a variable of the environment: a value, but the argument itself as a text if it
  /// is empty, begins with `#`, has a comment behind it or is no YAML. The root keeps the argument in Node::text.
  /// Throws ConfigError for one that begins with a bracket or a quote and is no YAML.
  [[nodiscard]] static Document ParseArgument(std::string_view argument, std::string name);

  /// Merges maps. Everything else is replaced by `upper`, but an empty value leaves a map unchanged.
  [[nodiscard]] static Document Merged(const Document& lower, const Document& upper);
  /// The value at a node of this document.
  [[nodiscard]] Document At(const Node& node) const;
  /// A map with only these keys, if it has them.
  [[nodiscard]] Document Only(std::span<const std::string_view> keys) const;
  /// The value inside maps: with the keys "a" and "b", `{a: {b: value}}`.
  [[nodiscard]] Document Below(std::span<const std::string> keys) const;
  /// A text of one line, from which Parse() makes the same values.
  [[nodiscard]] std::string ToYaml() const;

  Document(const Document&) = delete;  // Nodes point at each other.
  Document& operator=(const Document&) = delete;
  Document(Document&&) noexcept = default;
  Document& operator=(Document&&) noexcept = default;
  ~Document() = default;

  [[nodiscard]] const Node& root() const noexcept { return *root_; }
  /// Of its file; of merged files, the uppermost.
  [[nodiscard]] const std::string& name() const noexcept { return own_->name; }
  [[nodiscard]] static FilePosition PositionOf(const Node& node) { return {*node.file, node.line, node.column}; }

 private:
  friend class DocumentBuilder;
  friend class DocumentMerger;
  struct Nodes {
    std::string name;
    std::deque<Node> nodes;  // A deque never moves its elements.
  };
  explicit Document(std::string name) : own_(std::make_shared<Nodes>(Nodes{std::move(name), {}})) {}
  // Without a root, with the nodes of `other` kept.
  [[nodiscard]] static Document Beside(const Document& other);

  std::shared_ptr<Nodes> own_;
  std::vector<std::shared_ptr<const Nodes>> kept_;  // To which those of own_ point.
  const Node* root_ = nullptr;
};

}  // namespace hgros::yaml
