#include "robot/param_text.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdint>

#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

std::string InQuotes(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return Visible(quoted + "\"");
}

template <class T>
bool Reads(const std::string& text, T& value) {
  const char* end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stopped == end;
}

}  // namespace

std::string FlowText(const ParamNode& node) {
  std::string text;
  switch (node.kind) {
    case ParamNode::Kind::kNull: return "null";
    case ParamNode::Kind::kText: return node.quoted ? InQuotes(node.text) : Visible(node.text);
    case ParamNode::Kind::kList:
      for (const ParamNodePtr& item : node.items) text += (text.empty() ? "" : ", ") + FlowText(*item);
      return "[" + text + "]";
    case ParamNode::Kind::kMap:
      for (const auto& [key, value] : node.entries) {
        text += (text.empty() ? "" : ", ") + Visible(key) + ": " + FlowText(*value);
      }
      return "{" + text + "}";
  }
  return text;
}

void WriteJson(Json& json, const ParamNode& node) {
  std::int64_t whole = 0;
  double number = 0;
  switch (node.kind) {
    case ParamNode::Kind::kNull: json.Null(); return;
    case ParamNode::Kind::kText:
      if (node.quoted) {
        json.Value(node.text);
      } else if (node.text == "true" || node.text == "false") {
        json.Value(node.text == "true");
      } else if (Reads(node.text, whole)) {
        json.Value(whole);
      } else if (Reads(node.text, number) && std::isfinite(number)) {
        json.Value(number);
      } else {
        json.Value(node.text);
      }
      return;
    case ParamNode::Kind::kList:
      json.BeginList();
      for (const ParamNodePtr& item : node.items) WriteJson(json, *item);
      json.EndList();
      return;
    case ParamNode::Kind::kMap:
      json.BeginObject();
      for (const auto& [key, value] : node.entries) WriteJson(json.Key(key), *value);
      json.EndObject();
      return;
  }
}

std::string RangeText(const ParamInfo& info) {
  std::string range;
  if (info.least && info.most) {
    range = fmt::format("{} to {}", *info.least, *info.most);
  } else if (info.least) {
    range = fmt::format("from {}", *info.least);
  } else if (info.most) {
    range = fmt::format("up to {}", *info.most);
  }
  for (const std::string& choice : info.choices) range += (range.empty() ? "" : ", ") + Visible(choice);
  if (info.read_only) range += range.empty() ? "read only" : "; read only";
  return range;
}

}  // namespace hgros::cli
