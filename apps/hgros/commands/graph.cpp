#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "drawing/graph_drawing.hpp"
#include "hgros/base/names.hpp"
#include "robot/domains.hpp"
#include "robot/hypergraph.hpp"
#include "robot/robot.hpp"
#include "terminal/json.hpp"
#include "terminal/output_file.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

class Graph final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Flag("--svg", svg_, "A picture");
    arguments.Flag("--dot", dot_, "A description for Graphviz");
    arguments.Option("-o,--output", "FILE", file_, "Write to this file instead of standard output", ValueKind::kFile);
    arguments.Option("--around", "NAME", around_, "Only what is near this process, node or channel");
    arguments.Option("--depth", "N", depth_, "With --around: how many channels away at most; without it 1");
    arguments.Flag("-a,--all", all_, "Also the channels of the library itself: hgros/ and params/");
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Draws the running hypergraph: hosts, processes and their nodes, and the channels between them with rate, "
           "transport and dropped messages. Sources come first.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros graph", "Draws all in the terminal."},
            {"hgros graph --around mapper --depth 2 --svg -o mapper.svg",
             "Draws the surroundings of one process as a picture."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  [[nodiscard]] Hypergraph Look(Robot& robot) const;
  [[nodiscard]] static std::string JsonOf(const Hypergraph& graph);

  bool svg_ = false;
  bool dot_ = false;
  bool all_ = false;
  std::string file_;
  std::string around_;
  std::optional<std::uint64_t> depth_;
  RobotOptions options_;
};

Hypergraph Graph::Look(Robot& robot) const {
  const AllCounters counters = robot.Counters();
  Hypergraph graph = Hypergraph::Of(robot.Channels(all_), counters);
  if (around_.empty()) return graph;
  if (std::optional<Hypergraph> part = graph.Around(around_, depth_.value_or(1))) return *std::move(part);
  const std::string nearest = NearestName(around_, graph.Names());
  throw Error("No process, node or channel has the name \"" + around_ + "\"." +
              (nearest.empty() ? "" : " Did you mean " + nearest + "?"));
}

std::string Graph::JsonOf(const Hypergraph& graph) {
  std::string lines;
  for (const Hypergraph::Process& process : graph.processes) {
    Json json;
    json.BeginObject().Member("kind", "process").Member("session", process.session.ToString());
    json.Member("process", process.program).Member("pid", process.pid).Member("host", process.host);
    json.Key("nodes").BeginList();
    for (const Hypergraph::Node& node : process.nodes) {
      json.BeginObject().Member("node", node.name).Member("channel", node.channel).Member("lossless", node.lossless);
      json.Member("dropped", node.dropped).EndObject();
    }
    json.EndList().EndObject();
    lines += std::string(json.text()) + "\n";
  }
  for (const Hypergraph::Channel& channel : graph.channels) {
    Json json;
    json.BeginObject().Member("kind", "channel").Member("channel", channel.name).Member("type", channel.type);
    json.Member("rate_hz", channel.rate_hz).Member("latched", channel.latched);
    json.Key("publishers").BeginList();
    for (const Hypergraph::Publisher& publisher : channel.publishers) {
      json.Value(graph.processes[publisher.process].session.ToString());
    }
    json.EndList().Key("subscribers").BeginList();
    for (const Hypergraph::Subscriber& subscriber : channel.subscribers) {
      json.BeginObject().Member("session", graph.processes[subscriber.process].session.ToString());
      const Hypergraph::Node* node = graph.NodeOf(subscriber);
      json.Key("node");
      if (node == nullptr) {
        json.Null();
      } else {
        json.Value(node->name);
      }
      json.Key("transports").BeginList();
      for (const std::string& transport : subscriber.transports) json.Value(transport);
      json.EndList().EndObject();
    }
    json.EndList().EndObject();
    lines += std::string(json.text()) + "\n";
  }
  return lines;
}

int Graph::Run(Surroundings& surroundings) {
  if (svg_ + dot_ + options_.style.json > 1) throw UsageError("--svg, --dot and --json exclude each other.");
  if (depth_ && around_.empty()) throw UsageError("--depth needs --around.");
  Robot robot(options_, surroundings);
  const Hypergraph graph = Look(robot);
  Console& console = surroundings.console;
  const std::string drawing = svg_                  ? DrawSvg(graph, options_.style)
                              : dot_                ? DrawDot(graph, options_.style)
                              : options_.style.json ? JsonOf(graph)
                                                    : DrawText(graph, console, options_.style);
  if (file_.empty()) {
    console.Write(drawing);  // With the colors of the terminal.
  } else {
    WriteTo(console, file_, drawing);
  }
  if (graph.processes.empty()) SayNone(robot, "sessions");
  return kDone;
}

}  // namespace

std::unique_ptr<Command> MakeGraph() { return std::make_unique<Graph>(); }

}  // namespace hgros::cli
