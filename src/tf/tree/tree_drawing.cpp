#include "hgros/tf/tree_drawing.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
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

// Text of an XML element. Control characters, which XML does not have, become "?".
std::string Escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '<': escaped += "&lt;"; break;
      case '>': escaped += "&gt;"; break;
      case '&': escaped += "&amp;"; break;
      default: escaped += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
    }
  }
  return escaped;
}

std::size_t Characters(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

// A frame in an image. Sizes in pixels.
struct Box {
  std::vector<std::string> lines;
  std::vector<std::size_t> children;
  bool is_static = false;
  double x = 0;  // The left edge.
  double y = 0;
  double width = 0;
};
constexpr double kLine = 16;
constexpr double kBoxHeight = 4 * kLine + 10;
constexpr double kGapX = 16;
constexpr double kGapY = 36;

// The frames with their places: children side by side, parents in the middle above them. Sets the size of the image.
std::vector<Box> Placed(std::span<const EdgeSnapshot> edges, Time now, double& width, double& height) {
  std::vector<Box> boxes;
  std::vector<std::size_t> roots;
  std::map<std::string_view, std::size_t> places;
  const auto add = [&](const std::string& frame, std::vector<std::string> lines) {
    constexpr double kLetter = 7.5;
    std::size_t longest = 8;
    lines.insert(lines.begin(), frame);
    for (const std::string& line : lines) longest = std::max(longest, Characters(line));
    boxes.push_back({std::move(lines), {}, false, 0, kGapX, static_cast<double>(longest) * kLetter + 16});
    return places[frame] = boxes.size() - 1;
  };
  for (const EdgeSnapshot& edge : edges) {
    const auto known = places.find(edge.parent);
    if (known == places.end()) roots.push_back(add(edge.parent, {}));
    const std::size_t parent = places[edge.parent];
    std::vector<std::string> lines;
    std::istringstream about(About(edge, now, "\n"));
    for (std::string line; std::getline(about, line);) lines.push_back(line);
    const std::size_t child = add(edge.child, std::move(lines));
    boxes[child].is_static = edge.is_static;
    boxes[child].y = boxes[parent].y + kBoxHeight + kGapY;
    boxes[parent].children.push_back(child);
    height = std::max(height, boxes[child].y + kBoxHeight + kGapX);
  }
  // The places from the left of the leaves under each root, then of their parents. A child comes after its parent in
  // `boxes`, so an explicit stack replaces a recursion as deep as the tree.
  double next = kGapX;
  std::vector<std::size_t> stack(roots.rbegin(), roots.rend());
  while (!stack.empty()) {
    Box& box = boxes[stack.back()];
    stack.pop_back();
    if (box.children.empty()) {
      box.x = next;
      next += box.width + kGapX;
    }
    stack.insert(stack.end(), box.children.rbegin(), box.children.rend());
  }
  width = next;
  for (std::size_t i = boxes.size(); i-- > 0;) {
    Box& box = boxes[i];
    if (box.children.empty()) continue;
    const Box& last = boxes[box.children.back()];
    box.x = std::max(kGapX, (boxes[box.children.front()].x + last.x + last.width - box.width) / 2);
    width = std::max(width, box.x + box.width + kGapX);
  }
  return boxes;
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

std::string DrawSvg(std::span<const EdgeSnapshot> edges, Time now) {
  double width = 2 * kGapX;
  double height = 2 * kGapX;
  const std::vector<Box> boxes = Placed(edges, now, width, height);
  const auto number = [](double value) { return Formatted("%.0f", value); };
  const auto attribute = [&number](const char* name, double value) {
    return std::string(" ") + name + "=\"" + number(value) + "\"";
  };
  std::string text = "<svg xmlns=\"http://www.w3.org/2000/svg\"" + attribute("width", width) +
                     attribute("height", height) + " font-family=\"sans-serif\" font-size=\"12\">\n" +
                     "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  for (const Box& box : boxes) {
    const double middle = box.x + box.width / 2;
    for (const std::size_t i : box.children) {
      const Box& child = boxes[i];
      text += "<path d=\"M" + number(middle) + " " + number(box.y + kBoxHeight) + " C" + number(middle) + " " +
              number(child.y - kGapY / 3) + " " + number(child.x + child.width / 2) + " " +
              number(box.y + kBoxHeight + kGapY / 3) + " " + number(child.x + child.width / 2) + " " + number(child.y) +
              "\" fill=\"none\" stroke=\"#607080\"" + (child.is_static ? " stroke-dasharray=\"5 3\"" : "") + "/>\n";
    }
    text += "<rect" + attribute("x", box.x) + attribute("y", box.y) + attribute("width", box.width) +
            attribute("height", kBoxHeight) + " rx=\"6\" fill=\"" + (box.is_static ? "#f2f2f2" : "#e8f1fb") +
            "\" stroke=\"#607080\"/>\n";
    for (std::size_t line = 0; line < box.lines.size(); ++line) {
      text += "<text" + attribute("x", middle) + attribute("y", box.y + kLine + 4 + static_cast<double>(line) * kLine) +
              " text-anchor=\"middle\"" + (line == 0 ? " font-weight=\"bold\"" : "") + ">" + Escaped(box.lines[line]) +
              "</text>\n";
    }
  }
  return text + "</svg>\n";
}

}  // namespace hgros
