// Documents that are put together from several.
#include <algorithm>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/yaml/document.hpp"
#include "hgros/yaml/quoted.hpp"
#include "hgros/yaml/reader.hpp"
#include "yaml/variables.hpp"

namespace hgros::yaml {
namespace {

constexpr std::size_t kMostFiles = 32;
constexpr std::string_view kInclude = "include";

const Node* FindValue(const Node& map, std::string_view key) {
  const auto found =
      std::ranges::find(map.entries, key, [](const Node::Entry& one) -> const std::string& { return one.key->text; });
  return found == map.entries.end() ? nullptr : found->value;
}

std::vector<std::string_view> KeysOf(const Document& document) {
  std::vector<std::string_view> keys;
  for (const Node::Entry& entry : document.root().entries) keys.push_back(entry.key->text);
  return keys;
}

// The files of one Assemble().
class Assembly {
 public:
  explicit Assembly(const Variables& variables) : variables_(variables) {}

  // `said` is where the file is named; line 0: by the caller.
  Document Read(const std::filesystem::path& file, const FilePosition& said) {
    if (++read_ > kMostFiles) {
      throw ConfigError("More than " + std::to_string(kMostFiles) + " files are included.", said, "Include fewer.");
    }
    std::error_code error;
    std::filesystem::path whole = std::filesystem::weakly_canonical(file, error);
    if (error) whole = file;  // Such as a deleted file that is still open. Reading it tells what is wrong.
    if (std::ranges::find(open_, whole) != open_.end()) {
      throw ConfigError("The files include each other: " + file.string() + " is read already.", said,
                        "Remove one of the includes.");
    }
    Document document = LoadWithVariables(file, variables_);
    open_.push_back(whole);
    if (FindValue(document.root(), kInclude) != nullptr) document = WithIncluded(document);
    open_.pop_back();
    return document;
  }

 private:
  Document WithIncluded(const Document& document) {
    const Section top(Value(document), "a map", KeysOf(document));
    const Value include = *top.Find(kInclude);
    const bool several = include.kind() == Node::Kind::kList;
    const std::vector<Value> names = several ? include.List({}) : std::vector<Value>{include};
    std::optional<Document> lower;
    for (const Value& name : names) {
      const std::string& text = name.Text("the name of a file");
      if (text.empty()) name.Fail("is empty", "Name a file.");
      const std::filesystem::path file = std::filesystem::path(name.position().file).parent_path() / text;
      std::error_code error;
      if (!std::filesystem::exists(file, error)) {
        name.Fail("names " + Quoted(text) + ", which is no file beside this one", "Check the path.");
      }
      if (std::filesystem::is_directory(file, error)) {
        name.Fail("names " + Quoted(text) + ", which is a folder", "Include a file.");
      }
      if (!std::filesystem::is_regular_file(file, error)) {
        name.Fail("names " + Quoted(text) + ", which is a pipe or a device", "Include a file.");
      }
      Document included = Read(file, name.position());
      lower = lower ? Document::Merged(*lower, included) : std::move(included);
    }
    std::vector<std::string_view> others = KeysOf(document);
    std::erase(others, kInclude);
    Document own = document.Only(others);
    return lower ? Document::Merged(*lower, own) : std::move(own);
  }

  const Variables& variables_;
  std::vector<std::filesystem::path> open_;  // A file, and those that include it.
  std::size_t read_ = 0;
};

std::string InSingleQuotes(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) quoted.append(c == '\'' ? 2 : 1, c);
  return quoted + "'";
}

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kSpaces);
  return begin == std::string_view::npos ? "" : text.substr(begin, text.find_last_not_of(kSpaces) + 1 - begin);
}

}  // namespace

class DocumentMerger {
 public:
  explicit DocumentMerger(Document& into) : into_(into) {}

  Node& Add(const Node& like) {
    Node& node = into_.own_->nodes.emplace_back();
    node.kind = Node::Kind::kMap;
    node.file = like.file;
    node.line = like.line;
    node.column = like.column;
    return node;
  }

  const Node& Merge(const Node& lower, const Node& upper) {
    if (lower.kind != Node::Kind::kMap) return upper;
    if (upper.kind == Node::Kind::kNull) return lower;
    if (upper.kind != Node::Kind::kMap) return upper;
    Node& merged = Add(upper);
    std::map<std::string_view, const Node::Entry*> added;  // Of `upper`, without those that are in `lower`.
    for (const Node::Entry& entry : upper.entries) added.emplace(entry.key->text, &entry);
    for (const Node::Entry& entry : lower.entries) {
      const auto same = added.find(entry.key->text);
      if (same == added.end()) {
        Append(merged, entry);
        continue;
      }
      Append(merged, {same->second->key, &Merge(*entry.value, *same->second->value)});
      added.erase(same);
    }
    for (const Node::Entry& entry : upper.entries) {
      if (added.contains(entry.key->text)) Append(merged, entry);
    }
    return merged;
  }

  static void Append(Node& map, const Node::Entry& entry) {
    map.entries.push_back(entry);
    map.weight += entry.key->weight + entry.value->weight;
  }

 private:
  Document& into_;
};

Document Document::Beside(const Document& other) {
  Document document(other.name());
  document.kept_ = other.kept_;
  document.kept_.push_back(other.own_);
  return document;
}

Document Document::Merged(const Document& lower, const Document& upper) {
  Document document = Beside(upper);
  document.kept_.insert(document.kept_.end(), lower.kept_.begin(), lower.kept_.end());
  document.kept_.push_back(lower.own_);
  document.root_ = &DocumentMerger(document).Merge(lower.root(), upper.root());
  return document;
}

Document Document::At(const Node& node) const {
  Document document = Beside(*this);
  document.root_ = &node;
  return document;
}

Document Document::Only(std::span<const std::string_view> keys) const {
  Document document = Beside(*this);
  Node& map = DocumentMerger(document).Add(*root_);
  for (const Node::Entry& entry : root_->entries) {
    if (std::ranges::find(keys, entry.key->text) != keys.end()) DocumentMerger::Append(map, entry);
  }
  document.root_ = &map;
  return document;
}

Document Document::Below(std::span<const std::string> keys) const {
  Document document = Beside(*this);
  DocumentMerger merger(document);
  document.root_ = root_;
  for (auto key = keys.rbegin(); key != keys.rend(); ++key) {
    Node& name = merger.Add(*root_);
    name.kind = Node::Kind::kText;
    name.quoted = true;
    name.text = *key;
    Node& map = merger.Add(*root_);
    DocumentMerger::Append(map, {&name, document.root_});
    document.root_ = &map;
  }
  return document;
}

Document Document::Assemble(const std::filesystem::path& file, const Variables& variables) {
  return Assembly(variables).Read(file, {file.string(), 0, 0});
}

Document Document::ParseValue(std::string_view text, std::string name) {
  Document document = [&] {
    try {
      return Parse(text, name);
    } catch (const ConfigError& fault) {
      throw ConfigError(fault.sentence(), {name, 0, 0}, fault.mend());
    }
  }();
  for (Node& node : document.own_->nodes) node.line = node.column = 0;
  return document;
}

Document Document::ParseArgument(std::string_view argument, std::string name) {
  const auto as_text = [&] {
    // In quotes: characters that no YAML may have are still refused.
    Document document = ParseValue(InSingleQuotes(argument), name);
    document.own_->nodes.front().text = argument;
    return document;
  };
  const std::string_view trimmed = Trimmed(argument);
  if (trimmed.empty() || trimmed.starts_with('#')) return as_text();
  try {
    Document document = ParseValue(argument, name);
    const auto root = std::ranges::find(document.own_->nodes, document.root_, [](const Node& node) { return &node; });
    if (root->kind != Node::Kind::kText) {
      root->text = argument;
    } else if (!root->quoted && root->text != trimmed) {
      return as_text();
    }
    return document;
  } catch (const ConfigError&) {
    if (std::string_view("[{\"'").find(trimmed.front()) != std::string_view::npos) throw;  // It is meant as YAML.
    return as_text();
  }
}

}  // namespace hgros::yaml
