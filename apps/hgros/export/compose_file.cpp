#include "export/compose_file.hpp"

#include <algorithm>
#include <string_view>

#include "hgros/base/error.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::string_view kNetwork = "hgros-network";

void CheckServiceName(const RobotUnit& unit) {
  const auto fits = [](char it) {
    return (it >= 'a' && it <= 'z') || (it >= 'A' && it <= 'Z') || (it >= '0' && it <= '9') || it == '_' || it == '-';
  };
  if (std::ranges::all_of(unit.name, fits) && unit.name != kNetwork) return;
  throw Error("\"" + Visible(unit.name) + "\" cannot be the name of a service of Compose.", unit.at.ToString(),
              "Rename it: letters of ASCII, digits, \"_\" and \"-\".");
}

std::string_view RestartOf(RestartPolicy policy) {
  switch (policy) {
    case RestartPolicy::kNever: return "\"no\"";
    case RestartPolicy::kOnFailure: return "on-failure";
    case RestartPolicy::kAlways: return "always";
  }
  return "\"no\"";
}

std::string ServiceText(const ExportedRobot& exported, const ContainerOptions& options, const Container& container) {
  const RobotUnit& unit = *container.unit;
  CheckServiceName(unit);
  std::string text = "  " + EngineText(unit.name) + ":\n    image: " + EngineText(options.image) +
                     "\n    entrypoint: " + EngineList(container.command) +
                     "\n    working_dir: " + EngineText(exported.file.parent_path().string()) +
                     "\n    network_mode: \"service:" + std::string(kNetwork) +
                     "\"\n    volumes: [\"tmp:/tmp\"]\n    init: true\n    stop_grace_period: 2s\n    restart: " +
                     std::string(RestartOf(unit.restart)) + "\n";
  if (unit.memory_bytes > 0) text += "    mem_limit: " + std::to_string(unit.memory_bytes) + "b\n";
  if (!unit.cpus.empty()) text += "    cpuset: \"" + CpuList(unit.cpus) + "\"\n";
  if (NeedsNice(unit)) text += "    cap_add: [SYS_NICE]\n";
  if (unit.priority > 0) text += "    ulimits: {rtprio: 99}\n";
  std::string before(kNetwork);
  if (container.program) {
    for (const RobotProcess* one : exported.Processes()) before += ", " + EngineText(one->name);
  }
  text += "    depends_on: [" + before + "]\n";
  const std::map<std::string, std::string> variables = exported.VariablesOf(unit);
  if (!variables.empty()) text += "    environment:\n";
  for (const auto& [name, value] : variables) text += "      " + EngineText(name) + ": " + EngineText(value) + "\n";
  return text;
}

}  // namespace

ExportedFile ComposeFile(const ExportedRobot& exported, const ContainerOptions& options) {
  std::string text = "# Written by hgros export from " + Visible(exported.file.string()) +
                     "\nservices:\n"
                     "  # Owns the network namespace of the others, so that they may start again.\n  " +
                     std::string(kNetwork) + ":\n    image: " + EngineText(options.image) +
                     "\n    entrypoint: [sleep, infinity]\n    init: true\n    stop_grace_period: 2s\n"
                     "    restart: always\n";
  for (const Container& one : ContainersOf(exported, options)) text += ServiceText(exported, options, one);
  text +=
      "volumes:\n"
      "  # Sessions find each other here.\n"
      "  tmp: {driver_opts: {type: tmpfs, device: tmpfs, o: \"mode=1777\"}}\n";
  return {"compose.yaml", text};
}

}  // namespace hgros::cli
