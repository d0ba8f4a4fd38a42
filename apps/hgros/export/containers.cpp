#include "export/containers.hpp"

#include "hgros/base/error.hpp"
#include "terminal/json.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

Container ContainerOf(const RobotUnit& unit, bool program, const std::vector<std::string>& command) {
  Container container{&unit, program, {}};
  if (unit.nice != 0) container.command = {"nice", "-n", std::to_string(unit.nice)};
  if (unit.priority > 0) {
    container.command.insert(container.command.end(), {"chrt", "--fifo", std::to_string(unit.priority)});
  }
  container.command.insert(container.command.end(), command.begin(), command.end());
  return container;
}

}  // namespace

std::vector<Container> ContainersOf(const ExportedRobot& exported, const ContainerOptions& options) {
  if (exported.file.string().starts_with("/tmp/")) {
    throw Error("Containers cannot read " + Visible(exported.file.string()) + ": they share a /tmp of their own.", {},
                "Say with --path where the file is in the image.");
  }
  std::vector<Container> containers;
  for (const RobotProcess* one : exported.Processes()) {
    containers.push_back(ContainerOf(*one, false, exported.CommandOf(*one, options.command)));
  }
  for (const RobotProgram& one : exported.robot.programs) containers.push_back(ContainerOf(one, true, one.command));
  return containers;
}

bool NeedsNice(const RobotUnit& unit) { return unit.nice < 0 || unit.priority > 0; }

std::string EngineText(std::string_view text) {
  std::string doubled;
  for (const char letter : text) doubled += letter == '$' ? "$$" : std::string(1, letter);
  Json json;
  json.Value(doubled);
  return std::string(json.text());
}

std::string EngineList(const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& one : texts) list += (list.empty() ? "" : ", ") + EngineText(one);
  return "[" + list + "]";
}

std::string CpuList(const std::vector<int>& cpus) {
  std::string list;
  for (const int cpu : cpus) list += (list.empty() ? "" : ",") + std::to_string(cpu);
  return list;
}

}  // namespace hgros::cli
