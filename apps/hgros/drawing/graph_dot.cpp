#include <cstddef>
#include <string>

#include "drawing/graph_drawing.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

std::string InDotQuotes(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : Visible(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string ProcessId(std::size_t process) { return "p" + std::to_string(process); }
std::string NodeId(std::size_t process, std::size_t node) { return ProcessId(process) + "n" + std::to_string(node); }

}  // namespace

std::string DrawDot(const Hypergraph& graph, const OutputStyle& style) {
  std::string dot =
      "digraph hypergraph {\n  rankdir=LR;\n  compound=true;\n  node [fontname=\"sans-serif\", fontsize=11];\n";
  std::size_t host = 0;
  for (std::size_t p = 0; p < graph.processes.size(); ++p) {
    const Hypergraph::Process& process = graph.processes[p];
    if (p == 0 || process.host != graph.processes[p - 1].host) {
      if (p > 0) dot += "  }\n";
      dot += "  subgraph cluster_h" + std::to_string(host++) + " {\n    label=" + InDotQuotes(process.host) + ";\n";
    }
    dot += "    subgraph cluster_" + ProcessId(p) + " {\n      label=" + InDotQuotes(process.name) + ";\n";
    // What the process publishes comes from this point, because it is not known which of its nodes publishes.
    dot += "      " + ProcessId(p) + " [shape=point];\n";
    for (std::size_t n = 0; n < process.nodes.size(); ++n) {
      dot += "      " + NodeId(p, n) + " [shape=box, label=" + InDotQuotes(process.nodes[n].name) + "];\n";
    }
    dot += "    }\n";
  }
  if (!graph.processes.empty()) dot += "  }\n";
  for (std::size_t c = 0; c < graph.channels.size(); ++c) {
    const Hypergraph::Channel& channel = graph.channels[c];
    const std::string id = "c" + std::to_string(c);
    const std::string rate = channel.rate_hz > 0 ? "\\n" + RateText(channel.rate_hz, style.exact) + "\"" : "\"";
    std::string label = InDotQuotes(channel.name);
    label.replace(label.size() - 1, 1, rate);
    dot += "  " + id + " [shape=ellipse, label=" + label + "];\n";
    for (const Hypergraph::Publisher& publisher : channel.publishers)
      dot += "  " + ProcessId(publisher.process) + " -> " + id + ";\n";
    for (const Hypergraph::Subscriber& subscriber : channel.subscribers) {
      dot += "  " + id + " -> " +
             (subscriber.node ? NodeId(subscriber.process, *subscriber.node) : ProcessId(subscriber.process));
      std::string how;
      for (const std::string& transport : subscriber.transports) how += (how.empty() ? "" : ", ") + transport;
      dot += how.empty() || how == "process" ? ";\n" : " [label=" + InDotQuotes(how) + ", fontsize=9];\n";
    }
  }
  return dot + "}\n";
}

}  // namespace hgros::cli
