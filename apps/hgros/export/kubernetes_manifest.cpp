#include "export/kubernetes_manifest.hpp"

#include <algorithm>
#include <map>
#include <string_view>

#include "hgros/base/error.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kMostNameBytes = 63;

// A label of RFC 1123: small letters and digits, "-" between them. Empty: there is none.
std::string LabelOf(std::string_view name) {
  std::string label;
  for (const char letter : name) {
    const bool fits = (letter >= 'a' && letter <= 'z') || (letter >= '0' && letter <= '9');
    const bool large = letter >= 'A' && letter <= 'Z';
    label += fits ? letter : large ? static_cast<char>(letter - 'A' + 'a') : '-';
  }
  const std::size_t first = label.find_first_not_of('-');
  if (first == std::string::npos || label.size() > kMostNameBytes) return {};
  return label.substr(first, label.find_last_not_of('-') - first + 1);
}

std::string ContainerText(const ExportedRobot& exported, const ContainerOptions& options, const Container& container,
                          const std::string& name) {
  const RobotUnit& unit = *container.unit;
  std::vector<std::string> command = container.command;
  if (!unit.cpus.empty()) command.insert(command.begin(), {"taskset", "--cpu-list", CpuList(unit.cpus)});
  std::string text = "        - name: \"" + name + "\"\n          image: " + EngineText(options.image) +
                     "\n          command: " + EngineList(command) +
                     "\n          workingDir: " + EngineText(exported.file.parent_path().string()) +
                     "\n          volumeMounts: [{name: tmp, mountPath: /tmp}]\n";
  if (unit.memory_bytes > 0) {
    text += "          resources: {limits: {memory: \"" + std::to_string(unit.memory_bytes) + "\"}}\n";
  }
  if (NeedsNice(unit)) text += "          securityContext: {capabilities: {add: [SYS_NICE]}}\n";
  const std::map<std::string, std::string> variables = exported.VariablesOf(unit);
  if (!variables.empty()) text += "          env:\n";
  for (const auto& [variable, value] : variables) {
    text += "            - {name: " + EngineText(variable) + ", value: " + EngineText(value) + "}\n";
  }
  return text;
}

}  // namespace

ExportedFile KubernetesManifest(const ExportedRobot& exported, const ContainerOptions& options) {
  const std::string robot = LabelOf(exported.name);
  if (robot.empty()) {
    throw Error("\"" + Visible(exported.name) + "\" cannot be a name in Kubernetes.", {},
                "Give another one with --name: letters of ASCII, digits and \"-\", at most 63.");
  }
  std::string containers;
  std::map<std::string, const RobotUnit*> names;
  auto policy = RestartPolicy::kNever;
  for (const Container& one : ContainersOf(exported, options)) {
    const std::string name = LabelOf(one.unit->name);
    const auto [same, fresh] = names.emplace(name, one.unit);
    if (name.empty() || !fresh) {
      throw Error("\"" + Visible(one.unit->name) + "\" cannot be the name of a container in Kubernetes" +
                      (fresh ? "." : ", beside \"" + Visible(same->second->name) + "\"."),
                  one.unit->at.ToString(),
                  "Rename it: letters of ASCII, digits and \"-\", at most 63; large letters become small.");
    }
    policy = std::max(policy, one.unit->restart);
    containers += ContainerText(exported, options, one, name);
  }
  std::string text = "# Written by hgros export from " + Visible(exported.file.string()) + "\n";
  const std::string label = "{hgros-robot: \"" + robot + "\"}";
  if (policy == RestartPolicy::kAlways) {
    text += "apiVersion: apps/v1\nkind: Deployment\nmetadata: {name: \"" + robot +
            "\"}\nspec:\n  replicas: 1\n  selector: {matchLabels: " + label + "}\n";
  } else {
    text += "apiVersion: batch/v1\nkind: Job\nmetadata: {name: \"" + robot +
            "\"}\nspec:\n  backoffLimit: " + (policy == RestartPolicy::kNever ? "0" : "5") + "\n";
  }
  // One network namespace, too, as all pods have it. Without the shared process namespace, each program would be the
  // first process of its container, and signals would not end it.
  text += "  template:\n    metadata: {labels: " + label + "}\n    spec:\n      restartPolicy: " +
          (policy == RestartPolicy::kNever       ? "Never"
           : policy == RestartPolicy::kOnFailure ? "OnFailure"
                                                 : "Always") +
          "\n      terminationGracePeriodSeconds: 2\n      shareProcessNamespace: true\n"
          "      volumes: [{name: tmp, emptyDir: {}}]\n      containers:\n" +
          containers;
  return {robot + ".yaml", text};
}

}  // namespace hgros::cli
