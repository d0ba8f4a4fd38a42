#include "hgros/yaml/document.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <unordered_map>

#include "hgros/base/readable_text.hpp"
#include "hgros/yaml/quoted.hpp"
#include "yaml/syntax.hpp"
#include "yaml/text_places.hpp"
#include "yaml/variables.hpp"
#include "yaml/whole_file.hpp"

namespace hgros::yaml {
namespace {

// yaml-cpp reads the escapes \N and \_ as the bytes 0x85 and 0xa0, which are not UTF-8. The file is UTF-8, so no other
// byte of a text is refused here.
std::string WithWholeCharacters(const std::string& value) {
  std::string whole;
  for (std::string_view rest = value; !rest.empty();) {
    std::size_t length = Utf8Length(rest);
    if (length == 0) {
      whole += '\xc2';
      length = 1;
    }
    whole += rest.substr(0, length);
    rest.remove_prefix(length);
  }
  return whole;
}

}  // namespace

// Builds the tree from yaml-cpp's events and not from its nodes. The nodes lose repeated keys. And only here can limits
// be checked before more of a hostile file is read.
class DocumentBuilder : public YAML::EventHandler {
 public:
  DocumentBuilder(std::string_view text, std::string name, Tags tags, const Variables* variables)
      : document_(std::move(name)), places_(text), tags_(tags), variables_(variables) {}

  Document Build() {
    RequireCleanText(places_, document_.name());
    std::istringstream stream{std::string(places_.text())};
    try {
      YAML::Parser parser(stream);
      while (parser.HandleNextDocument(*this)) {
      }
    } catch (const YAML::Exception& e) {
      FailSyntax(e);
    }
    RequireClosedQuote();
    if (document_.root_ == nullptr) {
      Node& empty = document_.own_->nodes.emplace_back();
      empty.file = &document_.name();
      empty.line = 1;
      document_.root_ = &empty;
    }
    return std::move(document_);
  }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (document_.root_ == nullptr) return;
    if (places_.Line(mark.line).starts_with("---")) {
      Fail("A second document begins here, but a configuration file is one document.", mark,
           "Put it in a file of its own.");
    }
    Fail("The text should have ended above this.", mark,
         "Check the indentation: a file is one map, and all its sections begin in the same column.");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    if (AtKey()) Fail("There is no key before the colon.", mark, "Write one.");
    Complete(Add(Node::Kind::kNull, mark), anchor, mark);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Node& node = Add(Node::Kind::kText, mark);
    node.text = WithWholeCharacters(value);
    const bool binary = tags_ == Tags::kCoreAndBinary && tag == "tag:yaml.org,2002:binary";
    if (variables_ != nullptr) ReplaceVariables(node, tag == "?");
    node.weight += node.text.size() / 64;
    node.quoted = tag == "!" || tag == "tag:yaml.org,2002:str" || binary;
    if (!binary) RequireKnownTag(tag, mark);
    last_quoted_.reset();
    if (tag != "?") last_quoted_ = mark;
    Complete(node, anchor, mark);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto target = anchors_.find(anchor);
    if (target == anchors_.end()) {
      Fail("The alias is inside the value that it repeats.", mark, "Write out what is meant.");
    }
    if (AtKey() && target->second->kind != Node::Kind::kText) FailKey(mark);
    Attach(*target->second, mark);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value style) override {
    Open(Node::Kind::kList, mark, tag, anchor, style);
  }
  void OnSequenceEnd() override {
    closed_list_ = frames_.back().mark;
    Close();
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value style) override {
    Open(Node::Kind::kMap, mark, tag, anchor, style);
  }
  void OnMapEnd() override {
    RequireDistinctKeys(*frames_.back().node);
    Close();
  }

 private:
  struct Frame {
    Node* node = nullptr;
    YAML::anchor_t anchor = 0;
    YAML::Mark mark;
    bool flow = false;          // written with brackets
    const Node* key = nullptr;  // in a map: the key whose value comes next
  };

  [[noreturn]] void Fail(std::string_view what, const YAML::Mark& mark, std::string_view mend) {
    throw ConfigError(what, places_.At(document_.name(), mark.line, mark.column), mend);
  }
  // yaml-cpp also reports a bracket at the top level that is never closed as such a key.
  [[noreturn]] void FailKey(const YAML::Mark& mark) {
    Fail("A bracket is not closed here, or a list or map is used as a key.", mark,
         "Close every bracket; a key must be a text.");
  }

  [[noreturn]] void FailSyntax(const YAML::Exception& error) {
    const std::string& message = error.msg;
    if ((message == YAML::ErrorMsg::END_OF_SEQ_FLOW || message == YAML::ErrorMsg::END_OF_MAP_FLOW) &&
        !frames_.empty() && frames_.back().flow) {
      const bool list = frames_.back().node->kind == Node::Kind::kList;
      Fail(std::string("The ") + (list ? "list" : "map") +
               " that begins here is not closed, or a comma is missing in it.",
           frames_.back().mark, list ? "Close it with \"]\"." : "Close it with \"}\".");
    }
    if (message == YAML::ErrorMsg::END_OF_MAP && closed_list_ && closed_list_->line < error.mark.line &&
        closed_list_->column == error.mark.column) {
      Fail("This line begins in the column of a list's dashes, but has no dash.", error.mark,
           "If it belongs to the item above, indent it as far as the text after the dash. A new item begins with a "
           "dash.");
    }
    const SyntaxFault fault = ExplainSyntaxError(message, places_.Line(error.mark.line));
    const int column = fault.byte_column.value_or(error.mark.column);
    throw ConfigError(fault.what, places_.At(document_.name(), error.mark.line, column), fault.mend);
  }

  // yaml-cpp accepts the end of the file as the end of a quoted text.
  void RequireClosedQuote() {
    if (!last_quoted_) return;
    std::string_view rest = places_.text().substr(places_.Offset(last_quoted_->line, last_quoted_->column));
    while (!rest.empty() && (rest[0] == '&' || rest[0] == '!' || rest[0] == '#' || rest[0] <= ' ')) {
      const std::size_t end = rest[0] <= ' ' ? 1 : rest.find_first_of(rest[0] == '#' ? "\n" : " \t\r\n");
      rest.remove_prefix(std::min(end, rest.size()));
    }
    if (rest.empty() || (rest[0] != '"' && rest[0] != '\'')) return;
    const char quote = rest[0];
    for (std::size_t i = 1; i < rest.size(); ++i) {
      if (quote == '"' && rest[i] == '\\') {
        ++i;
      } else if (rest[i] == quote && quote == '\'' && i + 1 < rest.size() && rest[i + 1] == quote) {
        ++i;
      } else if (rest[i] == quote) {
        return;
      }
    }
    Fail("The quoted text that begins here is never closed.", *last_quoted_, "Close the quote.");
  }

  void RequireKnownTag(const std::string& tag, const YAML::Mark& mark) {
    constexpr std::string_view kCore = "tag:yaml.org,2002:";
    if (tag.empty() || tag == "?" || tag == "!") return;
    if (tag.starts_with(kCore)) {
      const std::string_view name = std::string_view(tag).substr(kCore.size());
      for (const std::string_view known : {"str", "int", "float", "bool", "null", "seq", "map"}) {
        if (name == known) return;
      }
    }
    Fail("The tag " + Quoted(tag) + " is not known.", mark, "Remove it, or put text that begins with \"!\" in quotes.");
  }

  void RequireDistinctKeys(const Node& map) {
    std::unordered_map<std::string_view, const Node*> seen;
    for (const Node::Entry& entry : map.entries) {
      const auto [first, fresh] = seen.emplace(entry.key->text, entry.key);
      if (fresh) continue;
      throw ConfigError("The key " + Quoted(entry.key->text) + " appears twice in one map; first at " +
                            document_.PositionOf(*first->second).ToString() + ".",
                        document_.PositionOf(*entry.key), "Keep one of them.");
    }
  }

  void ReplaceVariables(Node& node, bool plain) {
    node.text = WithBraces(node.text);
    std::string replaced = WithVariables(node.text, *variables_, Document::PositionOf(node));
    // Outside quotes, the value of a variable may be empty or null.
    if (plain && replaced != node.text && (replaced.empty() || replaced == "null" || replaced == "~") && !AtKey()) {
      node.kind = Node::Kind::kNull;
    }
    node.text = std::move(replaced);
  }

  bool AtKey() const {
    return !frames_.empty() && frames_.back().node->kind == Node::Kind::kMap && frames_.back().key == nullptr;
  }

  Node& Add(Node::Kind kind, const YAML::Mark& mark) {
    const FilePosition position = places_.At(document_.name(), mark.line, mark.column);
    Node& node = document_.own_->nodes.emplace_back();
    node.file = &document_.name();
    node.kind = kind;
    node.line = position.line;
    node.column = position.column;
    return node;
  }

  void Open(Node::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
            YAML::EmitterStyle::value style) {
    RequireKnownTag(tag, mark);
    if (AtKey()) FailKey(mark);
    if (frames_.size() >= kMaxDepth) {
      Fail("Lists and maps are nested more than " + std::to_string(kMaxDepth) + " deep.", mark,
           "No section needs more than 8.");
    }
    last_quoted_.reset();
    frames_.push_back({&Add(kind, mark), anchor, mark, style == YAML::EmitterStyle::Flow, nullptr});
  }

  void Close() {
    const Frame frame = frames_.back();
    frames_.pop_back();
    Complete(*frame.node, frame.anchor, frame.mark);
  }

  void Complete(const Node& node, YAML::anchor_t anchor, const YAML::Mark& mark) {
    if (anchor != 0) anchors_[anchor] = &node;
    Attach(node, mark);
  }

  void Attach(const Node& node, const YAML::Mark& mark) {
    if (frames_.empty()) {
      document_.root_ = &node;
      return;
    }
    Frame& frame = frames_.back();
    if (AtKey()) {
      frame.key = &node;
    } else if (frame.node->kind == Node::Kind::kMap) {
      frame.node->entries.push_back({frame.key, &node});
      frame.key = nullptr;
    } else {
      frame.node->items.push_back(&node);
    }
    frame.node->weight += node.weight;
    if (frame.node->weight > kMaxWeight) {
      Fail("There are too many values, each alias counted as what it repeats.", mark, "Write fewer, and repeat less.");
    }
  }

  Document document_;
  TextPlaces places_;
  const Tags tags_;
  const Variables* const variables_;  // Null: they are not replaced.
  std::vector<Frame> frames_;
  std::unordered_map<YAML::anchor_t, const Node*> anchors_;
  std::optional<YAML::Mark> last_quoted_;  // the newest value, if it may be quoted
  std::optional<YAML::Mark> closed_list_;
};

namespace {

Document ParseWith(std::string_view text, std::string name, Tags tags, const Variables* variables) {
  if (text.size() > kMaxFileBytes) {
    throw ConfigError("The configuration has more than 1 MiB.", {name, 0, 0},
                      "Split it, or check that it is the right file.");
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const std::string without = variables == nullptr ? std::string() : WithoutBraces(text);
  return DocumentBuilder(variables == nullptr ? text : without, std::move(name), tags, variables).Build();
}

}  // namespace

Document Document::Parse(std::string_view text, std::string name, Tags tags) {
  return ParseWith(text, std::move(name), tags, nullptr);
}

Document Document::Load(const std::filesystem::path& file) { return Parse(ReadFile(file), file.string()); }

Document LoadWithVariables(const std::filesystem::path& file, const Variables& variables) {
  return ParseWith(ReadFile(file), file.string(), Tags::kCore, &variables);
}

}  // namespace hgros::yaml
