#include "messages/message_document.hpp"

#include <rapidjson/error/en.h>
#include <rapidjson/memorystream.h>
#include <rapidjson/reader.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "terminal/visible_text.hpp"

namespace hgros::cli {

using yaml::Node;

// Builds the tree from RapidJSON's events. A function that returns false ends the reading.
class JsonNodes : public rapidjson::BaseReaderHandler<rapidjson::UTF8<>, JsonNodes> {
 public:
  JsonNodes(MessageDocument& document, std::string_view text, const rapidjson::MemoryStream& stream)
      : document_(document), text_(text), stream_(stream) {}

  bool Null() { return Attach(Add(Node::Kind::kNull, stream_.Tell() - 4)); }
  bool Bool(bool value) {
    Node& node = Add(Node::Kind::kText, stream_.Tell() - (value ? 4 : 5));
    node.text = value ? "true" : "false";
    return Attach(node);
  }
  bool RawNumber(const char* digits, rapidjson::SizeType length, bool /*copy*/) {
    Node& node = Add(Node::Kind::kText, stream_.Tell() - length);
    node.text.assign(digits, length);
    return Attach(node);
  }
  bool String(const char* text, rapidjson::SizeType length, bool /*copy*/) {
    Node& node = Add(Node::Kind::kText, QuoteBefore(stream_.Tell() - 1));
    node.quoted = true;
    node.text.assign(text, length);
    return Attach(node) && IsUtf8(node.text);
  }
  bool StartObject() { return Open(Node::Kind::kMap); }
  bool Key(const char* text, rapidjson::SizeType length, bool /*copy*/) {
    Node& node = Add(Node::Kind::kText, QuoteBefore(stream_.Tell() - 1));
    node.quoted = true;
    node.text.assign(text, length);
    open_.back().key = &node;
    return HasRoom() && IsUtf8(node.text);
  }
  bool EndObject(rapidjson::SizeType /*count*/) { return Close(); }
  bool StartArray() { return Open(Node::Kind::kList); }
  bool EndArray(rapidjson::SizeType /*count*/) { return Close(); }

  // Why the reading was ended; empty: RapidJSON knows.
  [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

 private:
  struct Frame {
    Node* node = nullptr;
    const Node* key = nullptr;
  };

  // The quote that opens the text whose closing quote is at `end`.
  [[nodiscard]] std::size_t QuoteBefore(std::size_t end) const {
    for (std::size_t i = end; i-- > 0;) {
      if (text_[i] != '"') continue;
      std::size_t escapes = 0;
      while (escapes < i && text_[i - 1 - escapes] == '\\') ++escapes;
      if (escapes % 2 == 0) return i;
    }
    return 0;
  }
  Node& Add(Node::Kind kind, std::size_t offset) {
    Node& node = document_.nodes_.emplace_back();
    node.kind = kind;
    node.column = static_cast<int>(offset);
    return node;
  }
  bool HasRoom() {
    if (document_.nodes_.size() <= MessageDocument::kMostJsonValues) return true;
    fault_ = "There are more than " + std::to_string(MessageDocument::kMostJsonValues) + " values.";
    return false;
  }
  // RapidJSON takes the second half of a surrogate pair alone, as \uDE00; its bytes begin with ED.
  bool IsUtf8(const std::string& text) {
    if (text.find('\xED') == std::string::npos || ValidUtf8(text) == text) return true;
    fault_ = "A text has an escape that is half of a character.";
    return false;
  }
  bool Attach(const Node& node) {
    if (open_.empty()) {
      document_.root_ = &node;
    } else if (Frame& frame = open_.back(); frame.node->kind == Node::Kind::kMap) {
      frame.node->entries.push_back({frame.key, &node});
    } else {
      frame.node->items.push_back(&node);
    }
    return HasRoom();
  }
  bool Open(Node::Kind kind) {
    if (open_.size() >= yaml::kMaxDepth) {
      fault_ = "Lists and objects are nested more than " + std::to_string(yaml::kMaxDepth) + " deep.";
      return false;
    }
    open_.push_back({&Add(kind, stream_.Tell()), nullptr});  // The bracket is taken after this call.
    return true;
  }
  bool Close() {
    const Node& node = *open_.back().node;
    open_.pop_back();
    return Attach(node);
  }

  MessageDocument& document_;
  const std::string_view text_;
  const rapidjson::MemoryStream& stream_;
  std::vector<Frame> open_;
  std::string fault_;
};

MessageDocument MessageDocument::Parse(std::string_view text, std::string name) {
  MessageDocument document;
  document.name_ = std::move(name);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  std::size_t offset = 0;
  if (first != std::string_view::npos && text[first] == '{' && text.size() <= kMostJsonBytes &&
      document.ReadJson(text, offset).empty()) {
    return document;
  }
  document.nodes_.clear();
  document.yaml_ = yaml::Document::Parse(text, document.name_, yaml::Tags::kCoreAndBinary);
  document.root_ = &document.yaml_->root();
  return document;
}

MessageDocument MessageDocument::ParseJson(std::string_view text, std::string name, int line) {
  MessageDocument document;
  document.name_ = std::move(name);
  document.first_line_ = line;
  if (text.size() > kMostJsonBytes) {
    throw ConfigError("The text is longer than " + std::to_string(kMostJsonBytes >> 20U) + " MiB.",
                      {document.name_, line, 0});
  }
  std::size_t offset = 0;
  const std::string fault = document.ReadJson(text, offset);
  if (!fault.empty()) throw ConfigError("This is not JSON: " + fault, document.PlaceOf(offset));
  return document;
}

std::string MessageDocument::ReadJson(std::string_view text, std::size_t& offset) {
  constexpr unsigned kFlags =
      rapidjson::kParseIterativeFlag | rapidjson::kParseNumbersAsStringsFlag | rapidjson::kParseValidateEncodingFlag;
  text_ = text;
  rapidjson::MemoryStream stream(text.data(), text.size());
  rapidjson::Reader reader;
  JsonNodes nodes(*this, text, stream);
  const rapidjson::ParseResult result = reader.Parse<kFlags>(stream, nodes);
  if (!result.IsError()) return {};
  offset = result.Offset();
  if (!nodes.fault().empty()) return nodes.fault();
  return rapidjson::GetParseError_En(result.Code());
}

FilePosition MessageDocument::PositionOf(const Node& node) const {
  return yaml_ ? yaml_->PositionOf(node) : PlaceOf(static_cast<std::size_t>(node.column));
}

FilePosition MessageDocument::PlaceOf(std::size_t offset) const {
  const std::string_view before = text_.substr(0, offset);
  const std::size_t line_break = before.rfind('\n');
  const std::string_view in_line = line_break == std::string_view::npos ? before : before.substr(line_break + 1);
  const auto line = first_line_ + static_cast<int>(std::ranges::count(before, '\n'));
  return {name_, line, static_cast<int>(ColumnsOf(in_line)) + 1};
}

}  // namespace hgros::cli
