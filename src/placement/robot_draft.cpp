#include "placement/robot_draft.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/config/check.hpp"
#include "hgros/config/config_sections.hpp"
#include "hgros/config/setting_readers.hpp"
#include "hgros/params/param_codec.hpp"
#include "hgros/params/param_error.hpp"
#include "hgros/params/param_view.hpp"
#include "hgros/params/params_of_document.hpp"
#include "hgros/yaml/quoted.hpp"

namespace hgros {
namespace {

using yaml::Field;
using yaml::Section;
using yaml::Value;

constexpr std::string_view kMain = "main";
constexpr std::string_view kComponents = "components";
constexpr std::string_view kComponentsShape = "a map from names to components";
constexpr std::size_t kMostArguments = 1000;
constexpr char kNul = '\0';

void CheckName(const Field& field, std::string_view what) {
  std::string fault = ChannelNameFault(field.key);
  if (fault.empty() && field.key.find_first_of("/.") != std::string::npos) fault = "it has a slash or a dot";
  if (fault.empty()) return;
  throw ConfigError(yaml::Quoted(field.key) + " cannot be the name of a " + std::string(what) + ": " + fault + ".",
                    field.key_position, "Use letters, digits, \"_\" and \"-\".");
}

std::map<std::string, std::string> ReadTexts(const Value& map, std::string_view wanted, std::string_view text) {
  std::map<std::string, std::string> texts;
  for (const Field& field : map.Map(wanted)) {
    field.value.faults().Attempt([&] { texts[field.key] = field.value.Text(text); });
  }
  return texts;
}

// For the system, a text ends there.
const std::string& WithoutNul(const std::string& text, const Value& value) {
  if (text.find(kNul) != std::string::npos) value.Fail("has a byte 0, which a program cannot get", "Remove it.");
  return text;
}

std::map<std::string, std::string> ReadEnvironment(const Value& map) {
  for (const Field& field : map.Map("a map from variables of the environment to their values")) {
    if (!field.key.empty() && field.key.find_first_of(std::string{'=', ' ', kNul}) == std::string::npos) continue;
    throw ConfigError(yaml::Quoted(field.key) + " cannot be the name of a variable.", field.key_position,
                      "Use letters, digits and \"_\".");
  }
  std::map<std::string, std::string> env = ReadTexts(map, "a map", "a text");
  for (const Field& field : map.Map({})) {
    if (const auto read = env.find(field.key); read != env.end()) (void)WithoutNul(read->second, field.value);
  }
  return env;
}

std::vector<std::string> ReadNames(const Value& list) {
  std::vector<std::string> names;
  for (const Value& one : list.List("a list of names")) {
    const std::string& name = one.Text("a name");
    if (const std::string fault = ChannelNameFault(name); !fault.empty()) {
      one.Fail("is " + yaml::Quoted(name) + ", which is no name: " + fault,
               "Use visible characters without spaces, such as \"robot1/scan\".");
    }
    names.push_back(name);
  }
  return names;
}

std::map<std::string, std::string> ReadRemap(const Value& map) {
  std::map<std::string, std::string> remap =
      ReadTexts(map, "a map from the component's names of channels and services to the robot's", "a name");
  for (const Field& field : map.Map({})) {
    const auto to = remap.find(field.key);
    if (to == remap.end()) continue;
    for (const std::string& name : {field.key, to->second}) {
      if (const std::string fault = ChannelNameFault(name); !fault.empty()) {
        field.value.Fail("has the name " + yaml::Quoted(name) + ", which no channel can have: " + fault,
                         "Use visible characters without spaces, such as \"robot1/scan\".");
      }
    }
  }
  return remap;
}

constexpr std::string_view kComponentShape =
    "a map with type, params, remap, nodes, restart, checkpoint, deadline and essential";
Duration ReadDuration(const Value& value, Duration least, const std::string& fix) {
  constexpr std::string_view kWanted = "a duration such as 500ms or 1s";
  const std::string& text = value.Text(kWanted);
  const bool has_unit = text.empty() || (text.back() != '.' && (text.back() < '0' || text.back() > '9'));
  if (!has_unit) value.FailType(kWanted);
  Duration duration{};
  try {
    duration = ParamView(std::make_shared<const ParamNode>(ParamNode::Text(text, false))).as<Duration>();
  } catch (const ParamError&) {
    value.FailType(kWanted);
  }
  if (duration < least) value.Fail("is too short", fix);
  return duration;
}

constexpr std::array<std::string_view, 8> kUnitKeys{"host",     "env",    "cpus",    "nice",
                                                    "priority", "memory", "restart", "essential"};
constexpr std::uint64_t kLeastMemoryBytes = 1 << 20;
constexpr std::uint64_t kMostMemoryBytes = std::uint64_t{1} << 50;

std::vector<std::string_view> KnownSections() {
  std::vector<std::string_view> known(kConfigSections.begin(), kConfigSections.end());
  known.insert(known.end(), RobotSections().begin(), RobotSections().end());
  return known;
}

std::vector<std::string_view> WithUnitKeys(std::initializer_list<std::string_view> more) {
  std::vector<std::string_view> keys(more);
  keys.insert(keys.end(), kUnitKeys.begin(), kUnitKeys.end());
  return keys;
}

}  // namespace

const std::vector<std::string>& RobotSections() {
  static const auto& sections = *new std::vector<std::string>{"components", "processes", "programs", "hosts"};
  return sections;
}

bool IsNearComponents(std::string_view key) {
  const std::vector<std::string_view> known = KnownSections();
  if (key.size() > kMaxChannelNameLength || std::ranges::find(known, key) != known.end()) return false;
  return NearestName(key, std::vector<std::string>(known.begin(), known.end())) == kComponents;
}

RobotFile RobotDraft::Read(bool read_key_files, std::string_view host) {
  const Section top(Value(document_, faults_), "a map with components", KnownSections());
  const auto read_all = [&](std::string_view key, std::string_view wanted, auto read) {
    top.Read(key, [&](const Value& map) {
      const std::vector<Field> fields = map.Map(wanted);
      for (const Field& field : fields) faults_.Attempt([&] { read(field); });
    });
  };
  if (!top.Find(kComponents) && std::ranges::any_of(document_.root().entries, [](const yaml::Node::Entry& one) {
        return IsNearComponents(one.key->text);
      })) {
    return {};  // The misspelled key is reported.
  }
  const std::optional<Value> components = top.Find(kComponents);
  const std::optional<Value> programs = top.Find("programs");
  if (!components && (!programs || programs->node().entries.empty())) {
    top.value().Fail("has no \"components\" and no \"programs\"",
                     "Add some: `components: {NAME: {type: PACKAGE/TYPE}}`.");
  }
  if (components && components->Map(kComponentsShape).empty()) {
    components->Fail("has no component", "Add one: `NAME: {type: PACKAGE/TYPE}`.");
  }
  read_all(kComponents, kComponentsShape, [this](const Field& field) { ReadComponent(field); });
  read_all("hosts", "a map from names to hosts", [this](const Field& field) { ReadHost(field); });
  CheckHosts();
  read_all("processes", "a map from names to processes", [this](const Field& field) { ReadProcess(field); });
  read_all("programs", "a map from names to programs", [this](const Field& field) { ReadProgram(field); });
  PlaceOthers();
  CheckNames();
  CheckPorts();
  const RobotHost* home = robot_.FindHost({});
  const std::string_view here = home != nullptr && home->name == host ? std::string_view() : host;
  std::array<const RobotProcess*, 2> of_robot{};  // Without sections of their own: their faults are reported once.
  for (RobotProcess& process : robot_.processes) {
    const bool read_keys = read_key_files && process.host == here;
    const auto own = sections_.find(process.name);
    const RobotProcess*& same = of_robot[read_keys ? 1 : 0];
    if (own != sections_.end()) {
      process.config = ConfigOf(&own->second, read_keys);
    } else if (same != nullptr) {
      process.config = same->config;
    } else {
      process.config = ConfigOf(nullptr, read_keys);
      same = &process;
    }
  }
  return std::move(robot_);
}

void RobotDraft::ReadComponent(const Field& field) {
  CheckName(field, "component");
  const Section section(field.value, kComponentShape,
                        {"type", "params", "remap", "nodes", "restart", "checkpoint", "deadline", "essential"});
  RobotComponent component;
  component.setup.name = field.key;
  component.at = field.key_position;
  component.setup.type = section.Require("type").Text("the name of a component type, such as slam2d/Mapper");
  section.Read("params", [&](const Value& params) {
    (void)params.Map("a map of parameters");
    component.setup.params.section = ParamsOf(document_.At(params.node()));
  });
  section.Read("remap", [&](const Value& remap) { component.setup.remap = ReadRemap(remap); });
  section.Read("nodes", [&](const Value& nodes) { component.setup.nodes = ReadNodeOverrides(nodes); });
  section.Read("restart", [&](const Value& restart) {
    component.restart =
        static_cast<ComponentRestart>(restart.Choice({"never", "on-failure", "on-exception", "on-deadline"}));
  });
  section.Read("checkpoint", [&](const Value& checkpoint) {
    component.checkpoint = ReadDuration(checkpoint, std::chrono::milliseconds(10), "The shortest is 10ms.");
  });
  section.Read("deadline", [&](const Value& deadline) {
    component.setup.deadline = ReadDuration(deadline, std::chrono::milliseconds(1), "The shortest is 1ms.");
  });
  if (component.restart == ComponentRestart::kOnDeadline && component.setup.deadline.count() == 0) {
    section.value().Fail("has restart: on-deadline, but no deadline", "Add one, such as `deadline: 50ms`.");
  }
  section.Read("essential", [&](const Value& essential) { component.essential = essential.Boolean(); });
  robot_.components.push_back(std::move(component));
}

void RobotDraft::ReadUnit(const Field& field, const Section& section, RobotUnit& unit) {
  unit.name = field.key;
  unit.at = field.key_position;
  ReadHostOf(section, unit);
  section.Read("env", [&](const Value& env) { unit.env = ReadEnvironment(env); });
  section.Read("cpus", [&](const Value& cpus) { unit.cpus = ReadCpus(cpus); });
  section.Read("nice", [&](const Value& nice) { unit.nice = static_cast<int>(nice.Integer(-20, 19)); });
  section.Read("priority", [&](const Value& priority) { unit.priority = static_cast<int>(priority.Integer(0, 99)); });
  section.Read("memory",
               [&](const Value& memory) { unit.memory_bytes = memory.SizeBytes(kLeastMemoryBytes, kMostMemoryBytes); });
  section.Read("restart", [&](const Value& restart) {
    unit.restart = static_cast<RestartPolicy>(restart.Choice({"never", "on-failure", "always"}));
  });
  section.Read("essential", [&](const Value& essential) { unit.essential = essential.Boolean(); });
}

void RobotDraft::ReadProcess(const Field& field) {
  CheckName(field, "process");
  std::vector<std::string_view> keys = WithUnitKeys({"components"});
  keys.insert(keys.end(), kConfigSections.begin(), kConfigSections.end());
  const Section section(field.value, "a map with components", keys);
  RobotProcess process;
  ReadUnit(field, section, process);
  section.Read("components", [&](const Value& list) { ReadPlaces(list, process); });
  if (std::ranges::any_of(kConfigSections, [&](std::string_view key) { return section.Find(key).has_value(); })) {
    sections_.emplace(field.key, document_.At(field.value.node()).Only(kConfigSections));
  }
  robot_.processes.push_back(std::move(process));
}

void RobotDraft::ReadPlaces(const Value& list, RobotProcess& process) {
  const std::vector<Value> names = list.List("a list of components");
  for (const Value& one : names) {
    faults_.Attempt([&] {
      const std::string& name = one.Text("the name of a component");
      const auto found = std::ranges::find(
          robot_.components, name, [](const RobotComponent& it) -> const std::string& { return it.setup.name; });
      if (found == robot_.components.end()) {
        const std::string nearest = NearestName(name, ComponentNames());
        one.Fail("is " + yaml::Quoted(name) + ", which is no component of the robot",
                 nearest.empty() ? "Add it to components." : "Did you mean \"" + nearest + "\"?");
      }
      const auto [first, fresh] = places_.emplace(name, one.position());
      if (!fresh) {
        one.Fail("is " + yaml::Quoted(name) + ", which is placed already at " + first->second.ToString(),
                 "Keep one of them.");
      }
      found->process = process.name;
      process.components.push_back(name);
    });
  }
}

void RobotDraft::ReadProgram(const Field& field) {
  CheckName(field, "program");
  const Section section(field.value, "a map with command",
                        WithUnitKeys({"command", "publishes", "subscribes", "serves", "calls"}));
  RobotProgram program;
  ReadUnit(field, section, program);
  const Value command = section.Require("command");
  for (const Value& part : command.List("a list of the program and its arguments")) {
    program.command.push_back(WithoutNul(part.Text("a text"), part));
  }
  if (program.command.empty() || program.command.front().empty()) command.Fail("names no program", "Name one.");
  if (program.command.size() > kMostArguments) command.Fail("has more than 1000 arguments", "Write a script for it.");
  section.Read("publishes", [&](const Value& list) { program.publishes = ReadNames(list); });
  section.Read("subscribes", [&](const Value& list) { program.subscribes = ReadNames(list); });
  section.Read("serves", [&](const Value& list) { program.serves = ReadNames(list); });
  section.Read("calls", [&](const Value& list) { program.calls = ReadNames(list); });
  robot_.programs.push_back(std::move(program));
}

void RobotDraft::PlaceOthers() {
  std::vector<std::string> others;
  for (RobotComponent& component : robot_.components) {
    if (!component.process.empty()) continue;
    component.process = kMain;
    others.push_back(component.setup.name);
  }
  if (others.empty()) return;
  auto main = std::ranges::find(robot_.processes, kMain, &RobotProcess::name);
  if (main == robot_.processes.end()) {
    main = robot_.processes.insert(robot_.processes.end(), RobotProcess());
    main->name = kMain;
    main->at = robot_.components.front().at;
  }
  main->components.insert(main->components.end(), others.begin(), others.end());
}

// A name that means two things could not be given to a command. Only a process and its component may share one.
void RobotDraft::CheckNames() const {
  const auto refuse = [this](const std::string& name, const std::string& by, const FilePosition& first,
                             const FilePosition& second) {
    faults_.Report(
        ConfigError("The name " + yaml::Quoted(name) + " is taken by " + by + " at " + first.ToString() + ".", second,
                    "Rename one of them."));
  };
  const auto is_in_file = [this](const RobotProcess& process) {
    return std::ranges::none_of(robot_.components,
                                [&](const RobotComponent& one) { return one.at.ToString() == process.at.ToString(); });
  };
  for (const RobotProcess& process : robot_.processes) {
    const RobotComponent* same = robot_.FindComponent(process.name);
    if (same == nullptr || same->process == process.name) continue;
    refuse(process.name, "the component", same->at, process.at);
  }
  for (const RobotProgram& program : robot_.programs) {
    if (const RobotComponent* same = robot_.FindComponent(program.name)) {
      refuse(program.name, "the component", same->at, program.at);
    }
    if (const RobotProcess* same = robot_.FindProcess(program.name)) {
      refuse(program.name, is_in_file(*same) ? "the process" : "the process of components without one, such as that",
             same->at, program.at);
    }
  }
}

Config RobotDraft::ConfigOf(const yaml::Document* process, bool read_key_files) const {
  const yaml::Document whole = document_.Only(kConfigSections);
  CheckedConfig checked = process == nullptr
                              ? CheckConfig(whole, {{}, read_key_files})
                              : CheckConfig(yaml::Document::Merged(whole, *process), {{}, read_key_files});
  for (const ConfigError& fault : checked.faults) faults_.Report(fault);
  return std::move(checked.config);
}

std::vector<std::string> RobotDraft::ComponentNames() const {
  std::vector<std::string> names;
  for (const RobotComponent& component : robot_.components) names.push_back(component.setup.name);
  return names;
}

}  // namespace hgros
