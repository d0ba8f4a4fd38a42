#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/yaml/document.hpp"
#include "hgros/yaml/faults.hpp"

namespace hgros::yaml {

struct Field;

/// A value of a document with its path. Getters return the type they are named after or throw ConfigError with the
/// position, the path, the wanted and the actual value. Borrows the document.
class Value {
 public:
  explicit Value(const Document& document, Faults faults = {}) : Value(document, document.root(), {}, faults) {}

  /// For example "network.subscribers[0].ip"; empty for the whole file.
  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  [[nodiscard]] FilePosition position() const { return document_->PositionOf(*node_); }
  [[nodiscard]] Node::Kind kind() const noexcept { return node_->kind; }
  [[nodiscard]] const Node& node() const noexcept { return *node_; }
  /// Of the reader. Getters throw; Attempt() reads on.
  [[nodiscard]] const Faults& faults() const noexcept { return faults_; }

  /// `wanted` completes "must be ...", here and below: "a list of names".
  /// The characters as written, also if they look like a number or a boolean.
  [[nodiscard]] const std::string& Text(std::string_view wanted) const;
  /// A decimal number without quotes, from `least` to `most`, both included.
  [[nodiscard]] std::int64_t Integer(std::int64_t least, std::int64_t most) const;
  /// true or false, not quoted.
  [[nodiscard]] bool Boolean() const;
  /// A number of bytes: an integer, or one with KiB, MiB, GiB, kB, MB or GB, such as 64MiB.
  [[nodiscard]] std::uint64_t SizeBytes(std::uint64_t least, std::uint64_t most) const;
  /// The index of the text in `choices`.
  [[nodiscard]] std::size_t Choice(std::initializer_list<std::string_view> choices) const;
  [[nodiscard]] std::vector<Value> List(std::string_view wanted) const;
  /// A map with keys that the user chooses. An empty value counts as an empty map.
  [[nodiscard]] std::vector<Field> Map(std::string_view wanted) const;

  /// Throws ConfigError. "<path> <predicate>." is its first sentence: "must be ...", "is ...".
  [[noreturn]] void Fail(std::string_view predicate, std::string_view mend = {}) const;
  /// Throws ConfigError "<path> must be <wanted>, but is <actual value>."
  [[noreturn]] void FailType(std::string_view wanted, std::string_view mend = {}) const;

 private:
  friend class Section;
  Value(const Document& document, const Node& node, std::string path, Faults faults)
      : document_(&document), node_(&node), path_(std::move(path)), faults_(faults) {}
  [[nodiscard]] Value Child(const Node& node, std::string_view key) const;
  [[nodiscard]] std::string Found() const;

  const Document* document_;
  const Node* node_;
  std::string path_;
  Faults faults_;
};

/// An entry of a map with keys that the user chooses.
struct Field {
  std::string key;
  FilePosition key_position;
  Value value;
};

/// A map with fixed keys: each unknown key is a fault that names the nearest known one. An empty value counts as an
/// empty map. `shape` completes "must be ...": "a map with ip and channels".
class Section {
 public:
  Section(const Value& map, std::string_view shape, std::span<const std::string_view> known_keys);
  Section(const Value& map, std::string_view shape, std::initializer_list<std::string_view> known_keys)
      : Section(map, shape, std::span(known_keys.begin(), known_keys.size())) {}

  [[nodiscard]] std::optional<Value> Find(std::string_view key) const;
  /// Calls `read` with the value of the key, if there is one, and reports the ConfigError that it throws.
  template <typename ReadValue>
  void Read(std::string_view key, ReadValue read) const {
    if (const std::optional<Value> value = Find(key)) value->faults().Attempt([&] { read(*value); });
  }
  /// Throws ConfigError if the key is missing.
  [[nodiscard]] Value Require(std::string_view key) const;
  [[nodiscard]] const Value& value() const noexcept { return map_; }

 private:
  Value map_;
};

/// A value that was read, with its position for later errors.
template <typename T>
struct Setting {
  T value;
  FilePosition position;
};

/// Stores `value`, read from `at`, unless an earlier file has set it: an equal value is accepted, a different one
/// throws.
template <typename T>
void Settle(std::optional<Setting<T>>& setting, T value, const Value& at) {
  if (!setting) {
    setting = Setting<T>{std::move(value), at.position()};
  } else if (!(setting->value == value)) {
    at.Fail("contradicts " + setting->position.ToString(), "Keep one of the two.");
  }
}

}  // namespace hgros::yaml
