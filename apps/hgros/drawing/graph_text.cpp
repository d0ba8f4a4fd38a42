#include <algorithm>
#include <vector>

#include "drawing/graph_drawing.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

std::string Padded(std::string text, std::size_t columns) {
  const std::size_t taken = ColumnsOf(text);
  if (taken < columns) text.append(columns - taken, ' ');
  return text;
}

std::string Joined(const std::vector<std::string>& texts) {
  std::string joined;
  for (const std::string& text : texts) joined += (joined.empty() ? "" : ", ") + Visible(text);
  return joined;
}

// One arrow: the text of its head, and what stands behind it.
struct Arrow {
  std::string to;
  std::string how;
  bool drops = false;
};

class TextDrawing {
 public:
  TextDrawing(const Hypergraph& graph, const Console& console, const OutputStyle& style)
      : graph_(graph), console_(console), style_(style) {
    for (const Hypergraph::Channel& channel : graph.channels) {
      channel_columns_ = std::max(channel_columns_, std::min<std::size_t>(ColumnsOf(Visible(channel.name)), 40));
      for (const Hypergraph::Subscriber& subscriber : channel.subscribers) {
        to_columns_ = std::max(to_columns_, ColumnsOf(ArrowTo(subscriber).to));
      }
    }
  }

  std::string Draw() {
    std::string host;
    for (std::size_t i = 0; i < graph_.processes.size(); ++i) {
      const Hypergraph::Process& process = graph_.processes[i];
      if (i == 0 || process.host != host)
        text_ += (i == 0 ? "" : "\n") + console_.Styled(Style::kBold, Visible(process.host)) + "\n";
      host = process.host;
      DrawProcess(i);
    }
    DrawUnpublished();
    return text_;
  }

 private:
  [[nodiscard]] Arrow ArrowTo(const Hypergraph::Subscriber& subscriber) const {
    const Hypergraph::Node* node = graph_.NodeOf(subscriber);
    Arrow arrow{Visible(graph_.processes[subscriber.process].name), Joined(subscriber.transports)};
    if (node == nullptr) return arrow;
    arrow.to += " " + Visible(node->name);
    arrow.drops = node->dropped > 0;
    if (arrow.drops) arrow.how += (arrow.how.empty() ? "" : ", ") + std::to_string(node->dropped) + " dropped";
    return arrow;
  }

  void DrawProcess(std::size_t place) {
    text_ += "  " + console_.Styled(Style::kCyan, Visible(graph_.processes[place].name)) + "\n";
    for (const Hypergraph::Channel& channel : graph_.channels) {
      for (const Hypergraph::Publisher& publisher : channel.publishers) {
        if (publisher.process == place) DrawChannel(channel, publisher.rate_hz);
      }
    }
  }

  void DrawChannel(const Hypergraph::Channel& channel, double rate_hz) {
    constexpr std::size_t kRateColumns = 9;
    std::string rate = rate_hz > 0 ? RateText(rate_hz, style_.exact) : "-";
    if (rate.size() < kRateColumns) rate.insert(0, kRateColumns - rate.size(), ' ');
    std::string before = "    " + Padded(Visible(channel.name), channel_columns_) + rate + " ";
    const std::string blank(ColumnsOf(before), ' ');
    if (channel.subscribers.empty()) text_ += before + console_.Styled(Style::kDim, "nobody") + "\n";
    for (const Hypergraph::Subscriber& subscriber : channel.subscribers) {
      const Arrow arrow = ArrowTo(subscriber);
      text_ += before + "\xE2\x94\x80\xE2\x96\xB6 ";  // An arrow to the right.
      text_ += arrow.how.empty() ? arrow.to
                                 : Padded(arrow.to, to_columns_) + "  " +
                                       console_.Styled(arrow.drops ? Style::kYellow : Style::kDim, arrow.how);
      text_ += "\n";
      before = blank;
    }
  }

  // Channels that somebody waits for.
  void DrawUnpublished() {
    bool first = true;
    for (const Hypergraph::Channel& channel : graph_.channels) {
      if (!channel.publishers.empty()) continue;
      if (first) text_ += "\n" + console_.Styled(Style::kBold, "Published by nobody") + "\n";
      first = false;
      DrawChannel(channel, 0);
    }
  }

  const Hypergraph& graph_;
  const Console& console_;
  const OutputStyle style_;
  std::size_t channel_columns_ = 0;
  std::size_t to_columns_ = 0;
  std::string text_;
};

}  // namespace

std::string DrawText(const Hypergraph& graph, const Console& console, const OutputStyle& style) {
  return TextDrawing(graph, console, style).Draw();
}

}  // namespace hgros::cli
