#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "drawing/graph_drawing.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr int kRow = 24;        // Height of a line of text with its space, in pixels.
constexpr int kLetter = 7;      // Width of a letter.
constexpr int kBoxGap = 14;     // Between two processes above each other.
constexpr int kColumnGap = 90;  // For arrows.
constexpr int kMargin = 20;
constexpr int kBack = 50;  // For arrows that lead back.

std::string Xml(std::string_view text) {
  std::string escaped;
  for (const char c : Visible(text)) {
    switch (c) {
      case '<': escaped += "&lt;"; break;
      case '>': escaped += "&gt;"; break;
      case '&': escaped += "&amp;"; break;
      case '"': escaped += "&quot;"; break;
      default: escaped += c;
    }
  }
  return escaped;
}

int WidthOf(std::string_view text) { return static_cast<int>(ColumnsOf(Visible(text))) * kLetter; }

// A process: on the left the nodes that hear, on the right the channels that it publishes.
struct Box {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  std::vector<std::string> outputs;    // What is written.
  std::vector<std::size_t> output_of;  // Channels, in the same order.
};

class SvgDrawing {
 public:
  SvgDrawing(const Hypergraph& graph, const OutputStyle& style)
      : graph_(graph), style_(style), boxes_(graph.processes.size()) {}

  std::string Draw() {
    Measure();
    Place();
    std::string body;
    for (std::size_t c = 0; c < graph_.channels.size(); ++c) DrawArrows(body, c);
    for (std::size_t p = 0; p < boxes_.size(); ++p) DrawBox(body, p);
    return fmt::format(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
               "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" "
               "fill=\"#ffffff\"/>\n",
               width_, height_) +
           "<defs><marker id=\"head\" markerWidth=\"8\" markerHeight=\"8\" refX=\"7\" refY=\"4\" orient=\"auto\">"
           "<path d=\"M0,0 L8,4 L0,8 z\" fill=\"#5b6770\"/></marker></defs>\n" +
           body + "</svg>\n";
  }

 private:
  void Measure() {
    for (std::size_t c = 0; c < graph_.channels.size(); ++c) {
      const Hypergraph::Channel& channel = graph_.channels[c];
      for (const Hypergraph::Publisher& publisher : channel.publishers) {
        Box& box = boxes_[publisher.process];
        box.outputs.push_back(channel.name +
                              (publisher.rate_hz > 0 ? "  " + RateText(publisher.rate_hz, style_.exact) : ""));
        box.output_of.push_back(c);
      }
    }
    for (std::size_t p = 0; p < boxes_.size(); ++p) {
      const Hypergraph::Process& process = graph_.processes[p];
      Box& box = boxes_[p];
      int left = 0;
      int right = 0;
      for (const Hypergraph::Node& node : process.nodes) left = std::max(left, WidthOf(node.name));
      for (const std::string& output : box.outputs) right = std::max(right, WidthOf(output));
      box.width = std::max(left + right + 4 * kLetter, WidthOf(TitleOf(process)) * 8 / kLetter) + 2 * kLetter;  // Bold.
      box.height = kRow * (1 + static_cast<int>(std::max<std::size_t>({process.nodes.size(), box.outputs.size(), 1})));
    }
  }

  [[nodiscard]] static std::string TitleOf(const Hypergraph::Process& process) {
    return process.name + (process.host.empty() ? "" : "  on " + process.host);
  }

  // Columns are the ranks.
  void Place() {
    std::size_t ranks = 0;
    for (const Hypergraph::Process& process : graph_.processes) ranks = std::max(ranks, process.rank + 1);
    int x = kMargin + kBack;
    for (std::size_t rank = 0; rank < ranks; ++rank) {
      int y = kMargin;
      int widest = 0;
      for (std::size_t p = 0; p < boxes_.size(); ++p) {
        if (graph_.processes[p].rank != rank) continue;
        boxes_[p].x = x;
        boxes_[p].y = y;
        y += boxes_[p].height + kBoxGap;
        widest = std::max(widest, boxes_[p].width);
      }
      if (widest > 0) x += widest + kColumnGap;
      height_ = std::max(height_, y - kBoxGap + kMargin + kBoxGap);
    }
    width_ = std::max(x - kColumnGap + kMargin + kBack, 2 * kMargin);
    height_ = std::max(height_, 2 * kMargin);
  }

  void DrawBox(std::string& body, std::size_t p) const {
    const Box& box = boxes_[p];
    const Hypergraph::Process& process = graph_.processes[p];
    body += fmt::format(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"6\" fill=\"#f2f5f7\" stroke=\"#5b6770\"/>\n", box.x,
        box.y, box.width, box.height);
    body += fmt::format("<text x=\"{}\" y=\"{}\" font-weight=\"bold\">{}</text>\n", box.x + kLetter, box.y + 16,
                        Xml(TitleOf(process)));
    for (std::size_t n = 0; n < process.nodes.size(); ++n) {
      body += fmt::format("<text x=\"{}\" y=\"{}\" fill=\"{}\">{}</text>\n", box.x + kLetter, MiddleOf(box, n) + 4,
                          process.nodes[n].dropped > 0 ? "#b35900" : "#1f2a33", Xml(process.nodes[n].name));
    }
    for (std::size_t i = 0; i < box.outputs.size(); ++i) {
      body += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"#005b9f\">{}</text>\n",
                          box.x + box.width - kLetter, MiddleOf(box, i) + 4, Xml(box.outputs[i]));
    }
  }

  [[nodiscard]] static int MiddleOf(const Box& box, std::size_t row) {
    return box.y + kRow * (static_cast<int>(row) + 1) + kRow / 2;
  }

  void DrawArrows(std::string& body, std::size_t c) const {
    const Hypergraph::Channel& channel = graph_.channels[c];
    for (const Hypergraph::Publisher& publisher : channel.publishers) {
      const Box& from = boxes_[publisher.process];
      const auto output = std::ranges::find(from.output_of, c) - from.output_of.begin();
      for (const Hypergraph::Subscriber& subscriber : channel.subscribers) {
        const Box& to = boxes_[subscriber.process];
        const int x1 = from.x + from.width;
        const int y1 = MiddleOf(from, static_cast<std::size_t>(output));
        const int x2 = to.x;
        const int y2 = MiddleOf(to, subscriber.node.value_or(0));
        std::string how;
        for (const std::string& transport : subscriber.transports) how += (how.empty() ? "" : ", ") + transport;
        body += fmt::format(
            "<path d=\"{}\" fill=\"none\" stroke=\"#5b6770\"{} marker-end=\"url(#head)\">"
            "<title>{} over {}</title></path>\n",
            x2 > x1 ? Forward(x1, y1, x2, y2) : Back(x1, y1, x2, y2, BottomOf(from, to)),
            how == "ZeroMQ" ? " stroke-dasharray=\"6 3\"" : "", Xml(channel.name),
            Xml(how.empty() ? "an unknown transport" : how));
      }
    }
  }

  [[nodiscard]] static std::string Forward(int x1, int y1, int x2, int y2) {
    const int bend = std::max((x2 - x1) / 2, kColumnGap / 2);
    return fmt::format("M{},{} C{},{} {},{} {},{}", x1, y1, x1 + bend, y1, x2 - bend, y2, x2, y2);
  }
  // Below both boxes.
  [[nodiscard]] static std::string Back(int x1, int y1, int x2, int y2, int below) {
    return fmt::format("M{},{} C{},{} {},{} {},{} L{},{} C{},{} {},{} {},{}", x1, y1, x1 + kBack, y1, x1 + kBack, below,
                       x1, below, x2, below, x2 - kBack, below, x2 - kBack, y2, x2, y2);
  }
  [[nodiscard]] static int BottomOf(const Box& from, const Box& to) {
    return std::max(from.y + from.height, to.y + to.height) + kBoxGap / 2;
  }

  const Hypergraph& graph_;
  const OutputStyle style_;
  std::vector<Box> boxes_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace

std::string DrawSvg(const Hypergraph& graph, const OutputStyle& style) { return SvgDrawing(graph, style).Draw(); }

}  // namespace hgros::cli
