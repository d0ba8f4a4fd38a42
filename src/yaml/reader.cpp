#include "hgros/yaml/reader.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/yaml/quoted.hpp"

namespace hgros::yaml {
namespace {

bool IsNumber(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  return !text.empty() && text.find_first_not_of("0123456789.") == std::string_view::npos &&
         std::ranges::count(text, '.') <= 1 && text.find_first_of("0123456789") != std::string_view::npos;
}

// As it may be written, with the largest unit that has no fraction.
std::string SizeText(std::uint64_t bytes) {
  constexpr std::array<std::string_view, 4> kUnits{"", "KiB", "MiB", "GiB"};
  std::size_t unit = 0;
  for (; unit + 1 < kUnits.size() && bytes >= 1024 && bytes % 1024 == 0; ++unit) bytes /= 1024;
  return std::to_string(bytes) + std::string(kUnits.at(unit));
}

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// "Did you mean ...?" and the list of known names.
std::string Suggestion(std::string_view name, std::vector<std::string> known, std::string_view what) {
  std::sort(known.begin(), known.end());
  const std::string nearest = name.size() <= 64 ? NearestName(name, known) : std::string();
  std::string text;
  if (!nearest.empty()) text = "Did you mean \"" + nearest + "\"? ";
  return text + std::string(what) + ": " + Listed(known) + ".";
}

// Digits without sign or leading zero.
std::optional<std::uint64_t> Digits(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (text.size() > 1 && text[0] == '0') return std::nullopt;
  return number;
}

bool AllDigits(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

}  // namespace

void Value::Fail(std::string_view predicate, std::string_view mend) const {
  throw ConfigError((path_.empty() ? "The file" : path_) + " " + std::string(predicate) + ".", position(), mend);
}

void Value::FailType(std::string_view wanted, std::string_view mend) const {
  Fail("must be " + std::string(wanted) + ", but " + Found(), mend);
}

std::string Value::Found() const {
  switch (node_->kind) {
    case Node::Kind::kNull: return "is empty";
    case Node::Kind::kList: return "is a list";
    case Node::Kind::kMap: return "is a map";
    case Node::Kind::kText: break;
  }
  const std::string& text = node_->text;
  if (node_->quoted) return "is the text " + Quoted(text) + (IsNumber(text) ? " in quotes" : "");
  if (IsNumber(text)) return "is the number " + (text.size() <= 40 ? text : text.substr(0, 40) + "...");
  if (text == "true" || text == "false") return "is " + text;
  return "is the text " + Quoted(text);
}

Value Value::Child(const Node& node, std::string_view key) const {
  const bool plain = !key.empty() && key.size() <= 40 && key.find_first_of(" .\"\t\n\r") == std::string_view::npos;
  return {*document_, node, path_ + (path_.empty() ? "" : ".") + (plain ? std::string(key) : Quoted(key)), faults_};
}

const std::string& Value::Text(std::string_view wanted) const {
  if (node_->kind != Node::Kind::kText) FailType(wanted);
  return node_->text;
}

std::int64_t Value::Integer(std::int64_t least, std::int64_t most) const {
  const std::string wanted = "an integer from " + std::to_string(least) + " to " + std::to_string(most);
  if (node_->kind != Node::Kind::kText) FailType(wanted);
  std::string_view text = node_->text;
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  if (!AllDigits(text)) FailType(wanted);
  if (node_->quoted) FailType(wanted, "Write it without quotes.");
  if (text.size() > 1 && text[0] == '0') FailType(wanted, "Write it without leading zeros.");
  const std::optional<std::uint64_t> size = Digits(text);
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (!size || *size > kMost) FailType(wanted);
  const auto number = negative ? -static_cast<std::int64_t>(*size) : static_cast<std::int64_t>(*size);
  if (number < least || number > most) FailType(wanted);
  return number;
}

bool Value::Boolean() const {
  const bool plain = node_->kind == Node::Kind::kText && !node_->quoted;
  if (plain && node_->text == "true") return true;
  if (plain && node_->text == "false") return false;
  const bool quoted = node_->quoted && (node_->text == "true" || node_->text == "false");
  FailType("true or false", quoted ? "Write it without quotes." : "");
}

std::uint64_t Value::SizeBytes(std::uint64_t least, std::uint64_t most) const {
  const std::string wanted = "a size from " + SizeText(least) + " to " + SizeText(most);
  constexpr std::string_view kForms = "Write an integer, or one with KiB, MiB, GiB, kB, MB or GB, as in 64MiB.";
  constexpr std::array<std::pair<std::string_view, std::uint64_t>, 7> kUnits{{{"", 1},
                                                                              {"KiB", 1U << 10U},
                                                                              {"MiB", 1U << 20U},
                                                                              {"GiB", 1U << 30U},
                                                                              {"kB", 1'000},
                                                                              {"MB", 1'000'000},
                                                                              {"GB", 1'000'000'000}}};
  if (node_->kind != Node::Kind::kText) FailType(wanted, kForms);
  const std::string_view text = node_->text;
  const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  std::string_view unit = text.substr(digits);
  if (unit.starts_with(' ')) unit.remove_prefix(1);
  const auto known = std::ranges::find(kUnits, unit, &std::pair<std::string_view, std::uint64_t>::first);
  if (known == kUnits.end() || digits == 0) FailType(wanted, kForms);
  if (node_->quoted && unit.empty()) FailType(wanted, "Write it without quotes.");
  if (digits > 1 && text[0] == '0') FailType(wanted, "Write it without leading zeros.");
  const std::optional<std::uint64_t> count = Digits(text.substr(0, digits));
  if (!count || *count > std::numeric_limits<std::uint64_t>::max() / known->second) FailType(wanted);
  const std::uint64_t bytes = *count * known->second;
  if (bytes < least || bytes > most) FailType(wanted);
  return bytes;
}

std::size_t Value::Choice(std::initializer_list<std::string_view> choices) const {
  const std::vector<std::string> names(choices.begin(), choices.end());
  const std::string wanted = "one of " + Listed(names);
  if (node_->kind != Node::Kind::kText) FailType(wanted);
  const auto match = std::find(names.begin(), names.end(), node_->text);
  if (match != names.end()) return static_cast<std::size_t>(match - names.begin());
  const std::string nearest = node_->text.size() <= 64 ? NearestName(node_->text, names) : std::string();
  FailType(wanted, nearest.empty() ? "" : "Did you mean \"" + nearest + "\"?");
}

std::vector<Value> Value::List(std::string_view wanted) const {
  if (node_->kind != Node::Kind::kList) FailType(wanted);
  std::vector<Value> items;
  items.reserve(node_->items.size());
  for (const Node* item : node_->items) {
    items.push_back({*document_, *item, path_ + "[" + std::to_string(items.size()) + "]", faults_});
  }
  return items;
}

std::vector<Field> Value::Map(std::string_view wanted) const {
  std::vector<Field> fields;
  if (node_->kind == Node::Kind::kNull) return fields;
  if (node_->kind != Node::Kind::kMap) FailType(wanted);
  fields.reserve(node_->entries.size());
  for (const Node::Entry& entry : node_->entries) {
    fields.push_back({entry.key->text, document_->PositionOf(*entry.key), Child(*entry.value, entry.key->text)});
  }
  return fields;
}

Section::Section(const Value& map, std::string_view shape, std::span<const std::string_view> known_keys) : map_(map) {
  const Node& node = *map.node_;
  if (node.kind == Node::Kind::kNull) return;
  if (node.kind != Node::Kind::kMap) {
    const bool glued = node.kind == Node::Kind::kText && !node.quoted && node.text.find(':') != std::string::npos;
    map.FailType(shape, glued ? "Put a space after the colon of each key." : "");
  }
  const Node* before = nullptr;
  for (const Node::Entry& entry : node.entries) {
    const std::string& key = entry.key->text;
    if (std::find(known_keys.begin(), known_keys.end(), key) == known_keys.end()) {
      std::string mend = Suggestion(key, {known_keys.begin(), known_keys.end()}, "Known keys");
      const std::string_view begin = std::string_view(key).substr(0, key.find(':'));
      if (begin.size() < key.size() && std::ranges::find(known_keys, begin) != known_keys.end()) {
        mend = "Put a space after the colon.";
      }
      if (before != nullptr && before->kind == Node::Kind::kList && before->column == entry.key->column) {
        mend += " If it belongs to the list item above, indent it as far as the text after the dash.";
      }
      map.faults_.Report(ConfigError(
          "Unknown key " + Quoted(key) + (map.path_.empty() ? " at the top level." : " in " + map.path_ + "."),
          map.document_->PositionOf(*entry.key), mend));
    }
    before = entry.value;
  }
}

std::optional<Value> Section::Find(std::string_view key) const {
  for (const Node::Entry& entry : map_.node_->entries) {
    if (entry.key->text == key) return map_.Child(*entry.value, key);
  }
  return std::nullopt;
}

Value Section::Require(std::string_view key) const {
  if (std::optional<Value> value = Find(key)) return *std::move(value);
  map_.Fail("has no " + Quoted(key), "Add it.");
}

}  // namespace hgros::yaml
