#pragma once

#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/yaml/document.hpp"

namespace hgros::cli {

/// The text of one message as a tree of values: YAML, or JSON. JSON has a reader of its own, because recordings of
/// large messages exceed the limits of YAML, and because JSON may write one character as two escapes.
class MessageDocument {
 public:
  static constexpr std::size_t kMostJsonBytes = std::size_t{64} << 20;
  static constexpr std::size_t kMostJsonValues = 1'000'000;

  /// YAML, or JSON if it is valid JSON. `name` begins the positions of errors. Throws ConfigError.
  [[nodiscard]] static MessageDocument Parse(std::string_view text, std::string name);
  /// One JSON value that begins in this line of the file `name`. `text` must outlive the document. Throws ConfigError.
  [[nodiscard]] static MessageDocument ParseJson(std::string_view text, std::string name, int line);

  [[nodiscard]] const yaml::Node& root() const noexcept { return *root_; }
  [[nodiscard]] FilePosition PositionOf(const yaml::Node& node) const;
  [[nodiscard]] bool json() const noexcept { return !yaml_; }

 private:
  friend class JsonNodes;
  MessageDocument() = default;
  // The fault of the text, if it is not JSON.
  [[nodiscard]] std::string ReadJson(std::string_view text, std::size_t& offset);
  [[nodiscard]] FilePosition PlaceOf(std::size_t offset) const;

  std::string name_;
  std::optional<yaml::Document> yaml_;
  std::string_view text_;         // Of JSON.
  int first_line_ = 1;            // Of JSON.
  std::deque<yaml::Node> nodes_;  // Of JSON; `column` is the offset in text_, and `line` is 0.
  const yaml::Node* root_ = nullptr;
};

}  // namespace hgros::cli
