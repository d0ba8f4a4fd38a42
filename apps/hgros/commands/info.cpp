#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "hgros/base/names.hpp"
#include "robot/descriptions.hpp"
#include "robot/robot.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

class Info final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"THING",
                          "",
                          "Names of channels, sessions (NAME, NAME:PID or id), nodes or services",
                          ValueKind::kChannel,
                          {},
                          true},
                         things_);
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows everything that is known about a channel, a session, a node or a service. If several have the name, "
           "all are shown.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros info scan", "Shows type, publishers, subscribers, nodes and transports of a channel."},
            {"hgros info talker --json", "Writes all about a session as one JSON object."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  std::vector<std::string> things_;
  RobotOptions options_;
};

std::vector<Sheet> Find(const KnownRobot& robot, const std::string& name) {
  std::vector<Sheet> found;
  for (const KnownChannel& channel : robot.channels) {
    if (channel.name == name) found.push_back(DescribeChannel(robot, channel));
  }
  for (const auto& [id, user] : SessionsOf(robot.channels)) {
    if (name == user.process || name == ShortName(user, false) || name == ShortName(user, true) ||
        name == id.ToString()) {
      found.push_back(DescribeSession(robot, user));
    }
  }
  for (const auto& [id, snapshot] : robot.counters) {
    for (const Snapshot::Channel& channel : snapshot->channels()) {
      for (const Snapshot::Node& node : channel.nodes()) {
        if (node.name() == name) found.push_back(DescribeNode(robot, id, channel, node));
      }
    }
  }
  for (const KnownChannel& channel : robot.channels) {
    const std::string_view service = ServiceOf(channel.name);
    if (!service.empty() && service == name) found.push_back(DescribeService(robot, channel));
  }
  return found;
}

// "Nothing is called tcik. Did you mean tick?"
std::string NothingCalled(const KnownRobot& robot, const std::string& name) {
  std::vector<std::string> channels;
  std::vector<std::string> sessions;
  std::vector<std::string> nodes;
  std::vector<std::string> services;
  for (const KnownChannel& channel : robot.channels) {
    const std::string_view service = ServiceOf(channel.name);
    if (service.empty()) {
      channels.push_back(channel.name);
    } else {
      services.emplace_back(service);
    }
  }
  for (const auto& [id, user] : SessionsOf(robot.channels)) sessions.push_back(user.process);
  for (const auto& [id, snapshot] : robot.counters) {
    for (const Snapshot::Channel& channel : snapshot->channels()) {
      for (const Snapshot::Node& node : channel.nodes()) nodes.push_back(node.name());
    }
  }
  std::vector<std::string> nearest;
  for (const std::vector<std::string>* names : {&channels, &sessions, &nodes, &services}) {
    const std::string one = NearestName(name, *names);
    if (!one.empty() && std::ranges::find(nearest, one) == nearest.end()) nearest.push_back(one);
  }
  std::string sentence = "No channel, session, node or service is called " + Visible(name) + ".";
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    sentence += (i == 0 ? " Did you mean " : i + 1 == nearest.size() ? " or " : ", ") + Visible(nearest[i]);
  }
  return sentence + (nearest.empty() ? " `hgros list` shows what there is." : "?");
}

int Info::Run(Surroundings& surroundings) {
  Robot robot(options_, surroundings);
  const AllCounters counters = robot.Counters();
  const KnownRobot known{counters, robot.Channels(true), options_.style};
  bool first = true;
  int code = kDone;
  for (const std::string& thing : things_) {
    const std::vector<Sheet> sheets = Find(known, thing);
    if (sheets.empty()) {
      surroundings.console.Say(NothingCalled(known, thing));
      code = kFailed;
    }
    for (const Sheet& sheet : sheets) {
      if (!first && !options_.style.json) surroundings.console.Write("\n");
      first = false;
      sheet.Write(surroundings.console, options_.style);
    }
  }
  return code;
}

}  // namespace

std::unique_ptr<Command> MakeInfo() { return std::make_unique<Info>(); }

}  // namespace hgros::cli
