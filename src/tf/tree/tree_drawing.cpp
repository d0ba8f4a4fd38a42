#include "hgros/tf/tree_drawing.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <string_view>
#include <vector>

namespace hgros {
namespace {

std::string Formatted(const char* format, double value) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string About(const EdgeSnapshot& edge, Time now, const char* separator) {
  std::string text;
  if (edge.is_static) {
    text = "static";
  } else {
    text = edge.transforms < 2 ? std::string("once") : Formatted("%.1f Hz", edge.RateHz());
    text += separator + Formatted("%.3f s old", static_cast<double>((now - edge.newest).count()) / 1e9);
  }
  if (!edge.publisher.empty()) text += separator + ("by " + edge.publisher);
  return text;
}

std::string Quoted(std::string_view name) {
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + '"';
}

}  // namespace

std::string DrawText(std::span<const EdgeSnapshot> edges, Time now) {
  struct Line {
    std::string frame;
    std::string about;
  };
  std::vector<Line> lines;
  std::map<std::string_view, std::size_t> depths;
  for (const EdgeSnapshot& edge : edges) {
    // Parents come before their children, so one that has no depth yet is a root.
    const auto [parent, is_root] = depths.try_emplace(edge.parent, 0);
    if (is_root) lines.push_back({edge.parent, {}});
    const std::size_t depth = parent->second + 1;
    depths[edge.child] = depth;
    lines.push_back({std::string(2 * depth, ' ') + edge.child, About(edge, now, ", ")});
  }
  std::size_t width = 0;
  for (const Line& line : lines) width = std::max(width, line.frame.size());
  std::string text;
  for (const Line& line : lines) {
    text += line.frame;
    if (!line.about.empty()) text += std::string(width - line.frame.size() + 2, ' ') + line.about;
    text += '\n';
  }
  return text;
}

std::string DrawGraphviz(std::span<const EdgeSnapshot> edges, Time now) {
  std::string text = "digraph transforms {\n  node [shape=box];\n";
  for (const EdgeSnapshot& edge : edges) {
    std::string about = Quoted(About(edge, now, "\n"));
    for (std::size_t at = 0; (at = about.find('\n', at)) != std::string::npos;) about.replace(at, 1, "\\n");
    text += "  " + Quoted(edge.parent) + " -> " + Quoted(edge.child) + " [label=" + about +
            (edge.is_static ? ", style=dashed" : "") + "];\n";
  }
  return text + "}\n";
}

}  // namespace hgros
