#include <algorithm>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "commands/commands.hpp"
#include "commands/robots/robot_reading.hpp"
#include "hgros/base/names.hpp"
#include "hgros/config/config.hpp"
#include "hgros/placement/robot_file.hpp"
#include "hgros/session/session.hpp"
#include "hosting/service_process.hpp"
#include "launch/detached.hpp"
#include "launch/host_networks.hpp"
#include "launch/robot_check.hpp"
#include "launch/robot_graph.hpp"
#include "launch/starter.hpp"
#include "remote/remote_units.hpp"
#include "terminal/console.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

class RunCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"FILE", "", "The robot file", ValueKind::kFile, {}, true}, file_);
    arguments.Option("--set", "PATH=VALUE", set_, "Replace a value of the file, such as mapper.params.cell_size_m=0.1");
    arguments.Option("--only", "NAME", only_, "Start only this component, process or program");
    arguments.Option("--except", "NAME", except_, "Do not start this component, process or program");
    arguments.Option("--host", "HOST", host_, "Start only what runs on this host of the file, which is this one");
    arguments.Option("--name", "ROBOT", options_.name, "Its name for other commands; otherwise that of the file");
    arguments.Option("--process", "NAME", process_,
                     "Run one process in this one, without a starter, as `hgros export` has it");
    arguments.Flag("-d,--detach", detach_, "Return once everything runs; `hgros logs` and `hgros stop` reach it");
    arguments.Flag("-v,--verbose", options_.verbose, "Also log lines of the level debug");
    arguments.Flag("--json", options_.json, "One JSON object per line");
  }
  [[nodiscard]] std::string Description() const override {
    return "Checks the file and its components first. Then starts the processes, waits until all are ready, lets them "
           "run, and shows their log. What has another host is started there over ssh. Ctrl-C ends the robot, a second "
           "one at once. The robot also ends when everything "
           "in it has ended. The exit code is 1 if something has failed. docs/robot-file.md describes the file.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros run robot.yaml", "Runs a robot until Ctrl-C."},
            {"hgros run robot.yaml --set mapper.params.cell_size_m=0.1 --except camera",
             "Runs it with another parameter, and without one of its components."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  void Select(RobotFile& robot) const;
  // Throws if something is wrong.
  [[nodiscard]] static std::vector<ComponentDescription> Try(const RobotFile& robot, const ComponentCatalog& catalog,
                                                             Surroundings& surroundings);

  std::string file_;
  std::vector<std::string> set_;
  std::string host_;
  std::vector<std::string> only_;
  std::vector<std::string> except_;
  std::string process_;
  StarterOptions options_;
  bool detach_ = false;
};

// Leaves what was asked for.
void RunCommand::Select(RobotFile& robot) const {
  std::vector<std::string> names;
  for (const RobotComponent& one : robot.components) names.push_back(one.setup.name);
  for (const RobotProcess& one : robot.processes) names.push_back(one.name);
  for (const RobotProgram& one : robot.programs) names.push_back(one.name);
  for (const std::vector<std::string>* list : {&only_, &except_}) {
    for (const std::string& name : *list) {
      if (std::ranges::find(names, name) != names.end()) continue;
      const std::string nearest = NearestName(name, names);
      throw UsageError("The robot has no component, process or program \"" + name + "\"." +
                       (nearest.empty() ? "" : " Did you mean \"" + nearest + "\"?"));
    }
  }
  const auto listed = [](const std::vector<std::string>& list, const std::string& name) {
    return std::ranges::find(list, name) != list.end();
  };
  const auto starts = [&](const std::string& name, const std::string& process) {
    if (listed(except_, name) || listed(except_, process)) return false;
    return only_.empty() || listed(only_, name) || listed(only_, process);
  };
  std::erase_if(robot.components, [&](const RobotComponent& one) { return !starts(one.setup.name, one.process); });
  std::erase_if(robot.programs, [&](const RobotProgram& one) { return !starts(one.name, one.name); });
  std::erase_if(robot.processes, [&](RobotProcess& process) {
    if (process.components.empty()) return !starts(process.name, process.name);
    std::erase_if(process.components, [&](const std::string& one) { return robot.FindComponent(one) == nullptr; });
    return process.components.empty();
  });
  if (robot.processes.empty() && robot.programs.empty()) throw UsageError("Nothing of the robot is left to start.");
}

std::vector<ComponentDescription> RunCommand::Try(const RobotFile& robot, const ComponentCatalog& catalog,
                                                  Surroundings& surroundings) {
  CheckedRobot checked = CheckRobot(robot, catalog, surroundings.pause);
  std::string last;
  for (const RobotFinding& one : checked.findings) {
    if (!one.fault) {
      surroundings.console.Say("warning: " + Visible(one.Text()));
      continue;
    }
    if (!last.empty()) surroundings.console.Say(Visible(last));
    last = one.Text();
  }
  if (!last.empty()) throw Error(last);
  return std::move(checked.descriptions);
}

// A session that was killed has left its file. The next session of its domain removes it.
void RemoveWhatWasLeft(const RobotFile& robot) {
  std::set<std::string> domains;
  for (const RobotProcess& process : robot.processes) {
    if (process.config.discovery.local) domains.insert(process.config.discovery.domain);
  }
  for (const std::string& domain : domains) {
    try {
      Config config = Config::Parse("discovery: {lan: false}");
      config.discovery.domain = domain;
      const Session session(config, {.name = {}, .log = [](LogLevel, std::string_view) {}});
      (void)session.Channels();        // It looks for other sessions from here on.
    } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): others will do it.
    }
  }
}

int RunCommand::Run(Surroundings& surroundings) {
  const bool more =
      detach_ || options_.json || options_.verbose || !options_.name.empty() || !only_.empty() || !except_.empty();
  if (!process_.empty() && more) throw UsageError("--process takes no other options than --set and --host.");
  const RobotFileOptions options = WithSet(set_, {.host = host_});
  RobotFile whole = ReadRobot(surroundings.console, file_, options);
  Select(whole);
  RequireHost(whole, host_);
  const ComponentCatalog catalog;
  if (!process_.empty()) return RunAsService(whole, process_, catalog, surroundings.pause);
  const std::vector<ComponentDescription> descriptions = Try(whole, catalog, surroundings);
  const RobotGraph graph(whole, descriptions);
  const std::map<std::string, std::string> networks = HostNetworks(whole, graph);
  const RobotFile robot = PartOfHost(whole, host_, networks);
  options_.on_placed = [&whole](const std::string& component, const std::string& process) {
    whole.Place(component, process);
  };
  std::optional<RemoteUnits> remote;
  if (host_.empty() && !whole.hosts.empty()) {
    options_.remote = &remote.emplace(whole, RobotFile::Assemble(file_, options), networks, descriptions, catalog);
  }
  options_.keeps_report = detach_;
  if (options_.name.empty()) options_.name = std::filesystem::path(file_).stem().string();
  const auto run = [&] {
    const int code = Starter(robot, graph, catalog, surroundings, options_).Run();
    RemoveWhatWasLeft(robot);
    return code;
  };
  if (detach_) {
    return RunDetached(surroundings.pause, [&](const std::function<void()>& on_running) {
      options_.on_running = on_running;
      return run();
    });
  }
  return run();
}

}  // namespace

std::unique_ptr<Command> MakeRun() { return std::make_unique<RunCommand>(); }

}  // namespace hgros::cli
