#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/session/yaml_document.hpp"

namespace hgros::yaml {

struct Field;

/// One value of a document with the way that leads to it. Its getters take the type they ask for or throw ConfigError
/// with position, path, what was wanted and what was found. A borrow: the document outlives it.
class Value {
 public:
  explicit Value(const Document& document) : Value(document, document.root(), {}) {}

  /// As in "network.subscribers[0].ip"; empty for the whole file.
  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  [[nodiscard]] FilePosition position() const { return document_->PositionOf(*node_); }
  [[nodiscard]] Node::Kind kind() const noexcept { return node_->kind; }

  /// `wanted` completes "must be ...", here and below: "a list of names".
  /// Text is the characters as written, also where they look like a number or a truth value.
  [[nodiscard]] const std::string& Text(std::string_view wanted) const;
  /// Decimal, not quoted, from `least` to `most`, both included.
  [[nodiscard]] std::int64_t Integer(std::int64_t least, std::int64_t most) const;
  /// true or false, not quoted.
  [[nodiscard]] bool Boolean() const;
  /// Bytes: an integer, or one with KiB, MiB or GiB, as in 64MiB.
  [[nodiscard]] std::uint64_t SizeBytes(std::uint64_t least, std::uint64_t most) const;
  /// Which of `choices` the text is.
  [[nodiscard]] std::size_t Choice(std::initializer_list<std::string_view> choices) const;
  [[nodiscard]] std::vector<Value> List(std::string_view wanted) const;
  /// A map whose keys the user chooses. Nothing at all counts as an empty map.
  [[nodiscard]] std::vector<Field> Map(std::string_view wanted) const;

  /// Throws ConfigError. "<path> <predicate>." is its first sentence: "must be ...", "is ...".
  [[noreturn]] void Fail(std::string_view predicate, std::string_view mend = {}) const;
  /// Likewise "<path> must be <wanted>, but is <what it is>."
  [[noreturn]] void FailType(std::string_view wanted, std::string_view mend = {}) const;

 private:
  friend class Section;
  Value(const Document& document, const Node& node, std::string path)
      : document_(&document), node_(&node), path_(std::move(path)) {}
  [[nodiscard]] Value Child(const Node& node, std::string_view key) const;
  [[nodiscard]] std::string Found() const;

  const Document* document_;
  const Node* node_;
  std::string path_;
};

/// One entry of a map whose keys the user chooses.
struct Field {
  std::string key;
  FilePosition key_position;
  Value value;
};

/// A map with fixed keys: any other key is an error that names the nearest known one. Nothing at all counts as an
/// empty map. `shape` completes "must be ...": "a map with ip and channels".
class Section {
 public:
  Section(const Value& map, std::string_view shape, std::span<const std::string_view> known_keys);
  Section(const Value& map, std::string_view shape, std::initializer_list<std::string_view> known_keys)
      : Section(map, shape, std::span(known_keys.begin(), known_keys.size())) {}

  [[nodiscard]] std::optional<Value> Find(std::string_view key) const;
  /// Throws ConfigError if the key is not there.
  [[nodiscard]] Value Require(std::string_view key) const;
  [[nodiscard]] const Value& value() const noexcept { return map_; }

 private:
  Value map_;
};

/// A value that was read, with its place for later errors.
template <typename T>
struct Setting {
  T value;
  FilePosition position;
};

/// Keeps `value`, read from `at`, unless an earlier file has set it: to say the same twice is fine, to differ throws.
template <typename T>
void Settle(std::optional<Setting<T>>& setting, T value, const Value& at) {
  if (!setting) {
    setting = Setting<T>{std::move(value), at.position()};
  } else if (!(setting->value == value)) {
    at.Fail("contradicts " + setting->position.ToString(), "Keep one of the two.");
  }
}

}  // namespace hgros::yaml
