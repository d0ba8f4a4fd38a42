#include "hgros/placement/robot_file.hpp"

#include <algorithm>
#include <fstream>
#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/config/config_sections.hpp"
#include "hgros/params/param_error.hpp"
#include "hgros/params/param_path.hpp"
#include "hgros/yaml/quoted.hpp"
#include "placement/robot_draft.hpp"

namespace hgros {
namespace {

bool IsRobotKey(const std::string& key, const std::vector<std::string>& sections_of_program) {
  if (std::ranges::find(sections_of_program, key) != sections_of_program.end()) return false;
  return std::ranges::find(RobotSections(), key) != RobotSections().end() || IsNearComponents(key);
}

// Of a file that cannot be read as YAML: whether a line begins with such a key, or with one that names other files.
bool LooksLikeRobot(const std::filesystem::path& file, const std::vector<std::string>& sections_of_program) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    const std::string key = line.substr(0, colon);
    if (key == "include" || IsRobotKey(key, sections_of_program)) return true;
  }
  return false;
}

std::vector<std::string> KeysBelow(const yaml::Node& map, std::string_view key) {
  std::vector<std::string> keys;
  for (const yaml::Node::Entry& entry : map.entries) {
    if (entry.key->text != key) continue;
    for (const yaml::Node::Entry& below : entry.value->entries) keys.push_back(below.key->text);
  }
  return keys;
}

// The keys that lead to an overridden value, from the top of the file.
std::vector<std::string> KeysOf(const ParamOverride& one, const yaml::Document& document) {
  const FilePosition said{one.said, 0, 0};
  std::vector<std::string> keys;
  try {
    const ParamPath path = ParamPath::Parse(one.path);
    for (const ParamPath::Step& step : path.steps()) {
      const std::string* key = std::get_if<std::string>(&step);
      if (key == nullptr) throw ConfigError("An item of a list cannot be replaced.", said, "Give the whole list.");
      keys.push_back(*key);
    }
  } catch (const ParamError& error) {
    throw ConfigError(error.what(), said);
  }
  if (keys.empty()) throw ConfigError("The path is empty.", said, "Write COMPONENT.params.NAME=VALUE.");
  std::vector<std::string> known = KeysBelow(document.root(), "components");
  if (std::ranges::find(known, keys.front()) != known.end()) {
    keys.insert(keys.begin(), "components");
    return keys;
  }
  known.insert(known.end(), kConfigSections.begin(), kConfigSections.end());
  known.insert(known.end(), RobotSections().begin(), RobotSections().end());
  if (std::ranges::find(known, keys.front()) != known.end()) return keys;
  const std::string nearest = NearestName(keys.front(), known);
  throw ConfigError("There is no component and no section " + yaml::Quoted(keys.front()) + ".", said,
                    nearest.empty() ? "Write COMPONENT.params.NAME=VALUE." : "Did you mean \"" + nearest + "\"?");
}

yaml::Document WithOverrides(yaml::Document document, const std::vector<ParamOverride>& overrides) {
  for (const ParamOverride& one : overrides) {
    const std::vector<std::string> keys = KeysOf(one, document);
    document = yaml::Document::Merged(document, yaml::Document::ParseArgument(one.value, one.said).Below(keys));
  }
  return document;
}

}  // namespace

RobotFile RobotFile::Load(const std::filesystem::path& file, const RobotFileOptions& options) {
  CheckedRobotFile checked = Check(file, options);
  if (!checked.faults.empty()) throw checked.faults.front();
  return std::move(checked.robot);
}

CheckedRobotFile RobotFile::Check(const std::filesystem::path& file, const RobotFileOptions& options) {
  CheckedRobotFile checked;
  const yaml::Faults faults(checked.faults);
  faults.Attempt([&] { checked = Check(Assemble(file, options), options); });
  return checked;
}

yaml::Document RobotFile::Assemble(const std::filesystem::path& file, const RobotFileOptions& options) {
  return WithOverrides(yaml::Document::Assemble(file, options.variables), options.overrides);
}

CheckedRobotFile RobotFile::Check(const yaml::Document& document, const RobotFileOptions& options) {
  CheckedRobotFile checked;
  const yaml::Faults faults(checked.faults);
  faults.Attempt([&] { checked.robot = RobotDraft(document, faults).Read(options.read_key_files, options.host); });
  return checked;
}

bool RobotFile::Is(const std::filesystem::path& file, const std::vector<std::string>& sections_of_program) {
  try {
    const auto any = [](const std::string&) { return std::optional<std::string>("x"); };
    const yaml::Document document = yaml::Document::Assemble(file, any);
    return std::ranges::any_of(document.root().entries, [&](const yaml::Node::Entry& one) {
      return IsRobotKey(one.key->text, sections_of_program);
    });
  } catch (const ConfigError&) {
    return LooksLikeRobot(file, sections_of_program);
  }
}

void RobotFile::Place(std::string_view component, std::string_view process) {
  for (RobotProcess& one : processes) {
    std::erase(one.components, component);
    if (one.name == process) one.components.emplace_back(component);
  }
  for (RobotComponent& one : components) {
    if (one.setup.name == component) one.process = process;
  }
}

const RobotComponent* RobotFile::FindComponent(std::string_view name) const {
  const auto found = std::ranges::find_if(components, [name](const auto& one) { return one.setup.name == name; });
  return found == components.end() ? nullptr : &*found;
}

const RobotProcess* RobotFile::FindProcess(std::string_view name) const {
  const auto found = std::ranges::find_if(processes, [name](const auto& one) { return one.name == name; });
  return found == processes.end() ? nullptr : &*found;
}

const RobotHost* RobotFile::FindHost(std::string_view name) const {
  const auto found =
      std::ranges::find_if(hosts, [name](const auto& one) { return name.empty() ? one.home : one.name == name; });
  return found == hosts.end() ? nullptr : &*found;
}

}  // namespace hgros
