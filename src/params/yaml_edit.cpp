#include "params/yaml_edit.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string_view>

#include "hgros/params/param_error.hpp"
#include "hgros/yaml/document.hpp"
#include "params/param_tree.hpp"
#include "params/yaml_writing.hpp"

namespace hgros {
namespace {

constexpr std::size_t kNone = std::string_view::npos;

struct Range {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// A value and its key.
struct Place {
  const yaml::Node* key = nullptr;  // null: the root
  const yaml::Node* value = nullptr;
  std::size_t depth = 0;  // of the path to it
};

// A YAML text and its parsed document.
class Editor {
 public:
  Editor(const std::string& text, const std::string& name) : text_(text), document_(yaml::Document::Parse(text, name)) {
    if (text.starts_with("\xEF\xBB\xBF")) skipped_ = 3;
    lines_.push_back(skipped_);
    for (std::size_t i = skipped_; i < text.size(); ++i) {
      if (text[i] == '\n') lines_.push_back(i + 1);
    }
  }

  // The edited text; empty if the whole file must be rewritten.
  std::optional<std::string> Put(const YamlEdit& edit) {
    const Place place = Deepest(edit.path);
    if (place.depth == edit.path.steps().size()) return Replace(place, *edit.value);
    // Missing keys are added below the deepest map that exists.
    std::vector<ParamPath::Step> missing(edit.path.steps().begin() + static_cast<std::ptrdiff_t>(place.depth + 1),
                                         edit.path.steps().end());
    ParamNodePtr value = edit.value;
    for (auto step = missing.rbegin(); step != missing.rend(); ++step) {
      value = std::make_shared<const ParamNode>(ParamNode::Map({{std::get<std::string>(*step), *value}}));
    }
    return Add(place, std::get<std::string>(edit.path.steps()[place.depth]), *value);
  }

 private:
  [[nodiscard]] Place Deepest(const ParamPath& path) const {
    Place place{nullptr, &document_.root(), 0};
    for (const ParamPath::Step& step : path.steps()) {
      const auto& entries = place.value->entries;
      const auto found = std::find_if(entries.begin(), entries.end(), [&](const yaml::Node::Entry& entry) {
        return entry.key->text == std::get<std::string>(step);
      });
      if (found == entries.end()) break;
      place = {found->key, found->value, place.depth + 1};
    }
    return place;
  }

  [[nodiscard]] std::size_t Offset(const yaml::Node& node) const {
    std::size_t at = lines_[static_cast<std::size_t>(std::max(node.line, 1) - 1)];
    for (int column = 1; column < node.column && at < text_.size(); ++column) {
      do ++at;
      while (at < text_.size() && (static_cast<unsigned char>(text_[at]) & 0xC0U) == 0x80U);
    }
    return at;
  }
  [[nodiscard]] std::size_t LineOf(std::size_t offset) const {
    return static_cast<std::size_t>(std::upper_bound(lines_.begin(), lines_.end(), offset) - lines_.begin()) - 1;
  }
  [[nodiscard]] std::string_view Line(std::size_t line) const {
    const std::size_t end = line + 1 < lines_.size() ? lines_[line + 1] : text_.size();
    return std::string_view(text_).substr(lines_[line], end - lines_[line]);
  }
  [[nodiscard]] bool InBrackets(const yaml::Node& map) const {
    const std::size_t at = Offset(map);
    return at < text_.size() && text_[at] == '{';
  }

  // The first character after the value's anchor and tag.
  [[nodiscard]] std::size_t BeginOf(const yaml::Node& node) const {
    std::size_t at = Offset(node);
    while (at < text_.size() && (text_[at] == '&' || text_[at] == '!')) {
      at = std::min(text_.find_first_of(" \t\n", at), text_.size());
      at = std::min(text_.find_first_not_of(" \t", at), text_.size());
    }
    return at;
  }

  // The end of a value in quotes or brackets.
  [[nodiscard]] std::size_t EndOfEnclosed(std::size_t begin) const {
    int depth = 0;
    for (std::size_t i = begin; i < text_.size(); ++i) {
      const char c = text_[i];
      if (c == '"' || (c == '\'' && (i == begin || std::string_view(" [{,:\n").find(text_[i - 1]) != kNone))) {
        i = EndOfQuote(i);
        if (depth == 0) return i;
        --i;
      } else if (c == '#' && (text_[i - 1] == ' ' || text_[i - 1] == '\n')) {
        i = text_.find('\n', i);
        if (i == kNone) return text_.size();
      } else if (c == '[' || c == '{') {
        ++depth;
      } else if ((c == ']' || c == '}') && --depth == 0) {
        return i + 1;
      }
    }
    return text_.size();
  }
  [[nodiscard]] std::size_t EndOfQuote(std::size_t begin) const {
    const char quote = text_[begin];
    for (std::size_t i = begin + 1; i < text_.size(); ++i) {
      if (text_[i] == '\\' && quote == '"') {
        ++i;
      } else if (text_[i] == quote && quote == '\'' && i + 1 < text_.size() && text_[i + 1] == quote) {
        ++i;
      } else if (text_[i] == quote) {
        return i + 1;
      }
    }
    return text_.size();
  }

  // The end of a scalar without quotes on one line. Inside brackets, a comma or a closing bracket ends it, too.
  [[nodiscard]] std::size_t EndOfPlain(std::size_t begin, bool in_brackets) const {
    std::size_t end = std::min(text_.find('\n', begin), text_.size());
    for (std::size_t i = begin; i < end; ++i) {
      const bool comment = text_[i] == '#' && i > begin && (text_[i - 1] == ' ' || text_[i - 1] == '\t');
      if (comment || (in_brackets && std::string_view(",]}").find(text_[i]) != kNone)) end = i;
    }
    while (end > begin && std::string_view(" \t\r").find(text_[end - 1]) != kNone) --end;
    return end;
  }

  // The end of the block below a key: of its last line that is neither empty nor a comment. The block's lines are
  // indented deeper than the key, or are list items at its indentation.
  [[nodiscard]] std::size_t EndOfBlock(std::size_t line, std::size_t indent, bool items) const {
    std::size_t last = line;
    for (std::size_t next = line + 1; next < lines_.size(); ++next) {
      const std::string_view text = Line(next);
      const std::size_t column = text.find_first_not_of(" \t\r\n");
      if (column == kNone || text[column] == '#') continue;
      if (column < indent || (column == indent && !(items && text[column] == '-'))) break;
      last = next;
    }
    return last + 1 < lines_.size() ? lines_[last + 1] : text_.size();
  }

  std::optional<std::string> Replace(const Place& place, const ParamNode& value) const {
    if (place.key == nullptr) return std::nullopt;
    const std::size_t key = Offset(*place.key);
    const std::size_t line = LineOf(key);
    const std::size_t indent = key - lines_[line];
    const bool in_brackets = Line(line).find_first_not_of(' ') != indent;
    const std::size_t begin = BeginOf(*place.value);
    const bool nothing = place.value->kind == yaml::Node::Kind::kNull;
    const char first = begin < text_.size() && !nothing ? text_[begin] : ' ';
    if (first == '"' || first == '\'' || first == '[' || first == '{') {
      return Spliced({begin, EndOfEnclosed(begin)}, yaml_writing::Inline(value));
    }
    const bool block = place.value->kind == yaml::Node::Kind::kList || place.value->kind == yaml::Node::Kind::kMap ||
                       first == '|' || first == '>';
    if (block || (nothing && !in_brackets)) {
      if (in_brackets) return std::nullopt;
      const bool list = place.value->kind == yaml::Node::Kind::kList;
      return Spliced({lines_[line], nothing ? EndOfLine(line) : EndOfBlock(line, indent, list)},
                     yaml_writing::Entry(place.key->text, value, static_cast<int>(indent)));
    }
    return Spliced({begin, EndOfPlain(begin, in_brackets)}, yaml_writing::Inline(value));
  }
  [[nodiscard]] std::size_t EndOfLine(std::size_t line) const { return lines_[line] + Line(line).size(); }

  std::optional<std::string> Add(const Place& place, const std::string& key, const ParamNode& value) const {
    const yaml::Node& map = *place.value;
    if (map.kind != yaml::Node::Kind::kMap || map.entries.empty() || InBrackets(map)) {
      if (place.key != nullptr && map.kind != yaml::Node::Kind::kText && map.kind != yaml::Node::Kind::kList) {
        return AddToSmallMap(place, key, value);
      }
      if (map.kind != yaml::Node::Kind::kNull) return std::nullopt;
      return EndedWithLine(text_) + yaml_writing::Entry(key, value, 0);
    }
    const std::size_t first = Offset(*map.entries.front().key);
    const std::size_t indent = first - lines_[LineOf(first)];
    const std::size_t last = Offset(*map.entries.back().key);
    const bool list = map.entries.back().value->kind == yaml::Node::Kind::kList;
    const std::size_t at = EndOfBlock(LineOf(last), indent, list);
    std::string before = text_.substr(0, at);
    return EndedWithLine(before) + yaml_writing::Entry(key, value, static_cast<int>(indent)) + text_.substr(at);
  }
  // For a map that is empty or is written in brackets.
  std::optional<std::string> AddToSmallMap(const Place& place, const std::string& key, const ParamNode& value) const {
    ParamNode whole = *param_tree::FromNode(*place.value);
    whole.kind = ParamNode::Kind::kMap;
    whole.entries.emplace_back(key, std::make_shared<const ParamNode>(value));
    return Replace(place, whole);
  }

  [[nodiscard]] static std::string EndedWithLine(std::string text) {
    if (!text.empty() && !text.ends_with('\n')) text += '\n';
    return text;
  }
  [[nodiscard]] std::string Spliced(Range range, const std::string& value) const {
    return text_.substr(0, range.begin) + value + text_.substr(range.end);
  }

  const std::string& text_;
  yaml::Document document_;
  std::size_t skipped_ = 0;
  std::vector<std::size_t> lines_;  // where each begins
};

}  // namespace

std::string WrittenYaml(const ParamNodePtr& root, const std::string& name) {
  std::string text = yaml_writing::Entries(*root, 0);
  if (param_tree::FromDocument(yaml::Document::Parse(text, name))->SameValue(*root)) return text;
  throw ParamError("The parameters cannot be written as YAML.", name, "Check them for texts that are not UTF-8.");
}

EditedYaml EditYaml(const std::string& text, const std::string& name, const std::vector<YamlEdit>& edits) {
  ParamNodePtr wanted = param_tree::FromDocument(yaml::Document::Parse(text, name));
  EditedYaml edited{text, true};
  for (const YamlEdit& edit : edits) {
    wanted = param_tree::With(wanted, edit.path, edit.value);
    if (!edited.comments_kept) continue;
    const std::string before = edited.text;
    try {
      const std::optional<std::string> after = Editor(before, name).Put(edit);
      edited.comments_kept = after && param_tree::FromDocument(yaml::Document::Parse(*after, name))->SameValue(*wanted);
      if (edited.comments_kept) edited.text = *after;
    } catch (const ConfigError&) {
      edited.comments_kept = false;
    }
  }
  if (!edited.comments_kept) edited.text = WrittenYaml(wanted, name);
  return edited;
}

}  // namespace hgros
