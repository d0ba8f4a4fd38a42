#include "commands/commands.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/names.hpp"

namespace hgros::cli {
namespace {

constexpr std::string_view kSee = "See";
constexpr std::string_view kCheck = "Check";
constexpr std::string_view kSteer = "Steer";
constexpr std::string_view kRun = "Run";
constexpr std::string_view kRecordings = "Recordings";
constexpr std::string_view kThis = "This program";

constexpr std::string_view kKeepMessages =
    "`hgros echo --json` to keep messages and `hgros pub --file` to publish them again";

constexpr std::array kCommands{
    CommandEntry{"list", "List channels, sessions, nodes, services, parameters or frames", kSee, MakeList},
    CommandEntry{"info", "Show everything about a channel, session, node or service", kSee, MakeInfo},
    CommandEntry{"echo", "Show the messages of channels", kSee, MakeEcho},
    CommandEntry{"hz", "Show how often messages are published", kSee, MakeHz},
    CommandEntry{"bw", "Show how many bytes per second are published", kSee, MakeBw},
    CommandEntry{"delay", "Show how long messages take to their receivers", kSee, MakeDelay},
    CommandEntry{"path", "Show the way of data between two channels, and its time", kSee, MakePath},
    CommandEntry{"trace", "Record what all nodes do, for Perfetto", kSee, MakeTrace},
    CommandEntry{"schema", "Show the fields of a type", kSee, MakeSchema},
    CommandEntry{"graph", "Draw the hypergraph: processes, nodes and their channels", kSee, MakeGraph},
    CommandEntry{"top", "Show what sessions, nodes and channels do now, once a second", kSee, MakeTop},
    CommandEntry{"tf", "Show and send the transforms between frames", kSee, nullptr},
    CommandEntry{"tf tree", "Show the tree of all frames", kSee, MakeTfTree},
    CommandEntry{"tf echo", "Show the pose of one frame in another", kSee, MakeTfEcho},
    CommandEntry{"tf watch", "Say when transforms appear, are late or disappear", kSee, MakeTfWatch},
    CommandEntry{"tf svg", "Draw the tree of frames as an image", kSee, MakeTfSvg},
    CommandEntry{"tf static", "Send the pose of a frame that never changes", kSee, MakeTfStatic},

    CommandEntry{"doctor", "Say what is wrong, or soon will be, and how to fix it", kCheck, MakeDoctor},
    CommandEntry{"check", "Check configuration files before anything runs", kCheck, MakeCheck},

    CommandEntry{"pub", "Publish messages on a channel", kSteer, MakePub},
    CommandEntry{"call", "Call a service", kSteer, MakeCall},
    CommandEntry{"param", "Show and change the parameters of sessions", kSteer, nullptr},
    CommandEntry{"param list", "List parameters with their values", kSteer, MakeParamList},
    CommandEntry{"param get", "Show the value of a parameter, or of all below a path", kSteer, MakeParamGet},
    CommandEntry{"param describe", "Show what a parameter means and which values it can have", kSteer,
                 MakeParamDescribe},
    CommandEntry{"param watch", "Show parameters as they change", kSteer, MakeParamWatch},
    CommandEntry{"param set", "Change parameters, all or none", kSteer, MakeParamSet},
    CommandEntry{"param save", "Write all parameters of a session as YAML", kSteer, MakeParamSave},
    CommandEntry{"param load", "Set parameters to the values of a YAML file, all or none", kSteer, MakeParamLoad},
    CommandEntry{"control", "Change sessions while they run", kSteer, nullptr},
    CommandEntry{"control close", "Keep a channel from the nodes of the session that publishes it", kSteer,
                 MakeControlClose},
    CommandEntry{"control open", "Open a channel that was closed", kSteer, MakeControlOpen},
    CommandEntry{"control allow", "Let a channel leave and enter sessions", kSteer, MakeControlAllow},
    CommandEntry{"control forbid", "Keep a channel inside sessions", kSteer, MakeControlForbid},
    CommandEntry{"control log", "Set the level of the log", kSteer, MakeControlLog},
    CommandEntry{"control stop", "End programs", kSteer, MakeControlStop},

    CommandEntry{"new", "Write a package with a component that builds", kRun, MakeNew},
    CommandEntry{"run", "Start a robot: the components and programs of a robot file", kRun, MakeRun},
    CommandEntry{"ps", "List the components and programs of running robots", kRun, MakePs},
    CommandEntry{"logs", "Show the log of a running robot", kRun, MakeLogs},
    CommandEntry{"restart", "Start a process or program of a robot again", kRun, MakeRestart},
    CommandEntry{"move", "Move a component to another process or host", kRun, MakeMove},
    CommandEntry{"stop", "End a robot", kRun, MakeStop},
    CommandEntry{"wait", "Wait until a robot has ended, or until a service is there", kRun, MakeWait},
    CommandEntry{"export", "Write a robot file for other starters", kRun, nullptr},
    CommandEntry{"export systemd", "Write units of systemd", kRun, MakeExportSystemd},
    CommandEntry{"export compose", "Write a file for Docker Compose", kRun, MakeExportCompose},
    CommandEntry{"export kubernetes", "Write a Job or Deployment of Kubernetes", kRun, MakeExportKubernetes},
    CommandEntry{"components", "Show component types with their channels and parameters", kRun, MakeComponents},

    CommandEntry{"bag", "Show, check and repair recordings: MCAP files", kRecordings, nullptr},
    CommandEntry{"bag info", "Show what is in a recording", kRecordings, MakeBagInfo},
    CommandEntry{"bag check", "List what is damaged in a recording", kRecordings, MakeBagCheck},
    CommandEntry{"bag recover", "Write what can be read of a damaged recording into a new one", kRecordings,
                 MakeBagRecover},

    CommandEntry{"help", "Explain a command", kThis, MakeHelp},
    CommandEntry{"completion", "Print a script that completes commands in a shell", kThis, MakeCompletion},
    CommandEntry{"__complete", "Complete a command line", kThis, MakeComplete},
    CommandEntry{"__hosted", "Run a process of a robot of another host", kThis, MakeHosted},
    CommandEntry{"__man", "Write manual pages", kThis, MakeManual},
};

// What users of ROS type, and what they look for. A longer name comes before its beginning.
constexpr std::array<std::pair<std::string_view, std::string_view>, 20> kElsewhere{{
    {"topic list", "`hgros list`"},      {"topic echo", "`hgros echo`"},
    {"topic hz", "`hgros hz`"},          {"topic bw", "`hgros bw`"},
    {"topic delay", "`hgros delay`"},    {"topic info", "`hgros info`"},
    {"topic pub", "`hgros pub`"},        {"topic", "`hgros list`"},
    {"node info", "`hgros info`"},       {"node", "`hgros list nodes`"},
    {"service call", "`hgros call`"},    {"service", "`hgros list services`"},
    {"component", "`hgros components`"}, {"interface", "`hgros schema`"},
    {"msg", "`hgros schema`"},           {"launch", "`hgros run FILE`"},
    {"bag record", kKeepMessages},       {"rosbag", kKeepMessages},
    {"bag play", kKeepMessages},         {"rviz", "the program hgros-viewer"},
}};

// In place of a command of ROS; empty: it is none.
std::string_view InsteadOf(const std::vector<std::string>& words) {
  const std::string two = words.size() > 1 ? words[0] + " " + words[1] : words[0];
  const auto found =
      std::ranges::find_if(kElsewhere, [&](const auto& one) { return one.first == two || one.first == words.front(); });
  return found == kElsewhere.end() ? std::string_view() : found->second;
}

std::string UnknownCommand(std::string_view name) {
  std::vector<std::string> names;
  for (const CommandEntry& entry : kCommands) {
    if (!entry.hidden()) names.emplace_back(entry.name);
  }
  const std::string nearest = NearestName(name, names);
  return "There is no command \"" + std::string(name) + "\"." +
         (nearest.empty() ? " `hgros help` lists all." : " Did you mean " + nearest + "?");
}

}  // namespace

std::span<const CommandEntry> Commands() noexcept { return kCommands; }

const CommandEntry* FindCommand(std::string_view name) noexcept {
  const auto found = std::ranges::find(kCommands, name, &CommandEntry::name);
  return found == kCommands.end() ? nullptr : &*found;
}

const CommandEntry& TakeCommand(std::vector<std::string>& words) {
  const auto take = [&words](std::string_view name, std::ptrdiff_t count) -> const CommandEntry& {
    const CommandEntry* entry = FindCommand(name);
    if (entry == nullptr) throw UsageError(UnknownCommand(name));
    words.erase(words.begin(), words.begin() + count);
    return *entry;
  };
  const CommandEntry* first = FindCommand(words.front());
  const std::string_view instead = first == nullptr || first->family() ? InsteadOf(words) : "";
  if (!instead.empty()) {
    const std::string name = first == nullptr ? words[0] : words[0] + " " + words[1];
    throw UsageError("There is no command \"" + name + "\". Use " + std::string(instead) + ".");
  }
  if (words.front() == "run" && words.size() > 2 && !words[1].starts_with('-') && !words[2].starts_with('-')) {
    throw UsageError("`hgros run` takes one robot file. `hgros components` lists what a robot file can start.");
  }
  const bool member = first != nullptr && first->family() && words.size() > 1 && !words[1].starts_with('-');
  return member ? take(words[0] + " " + words[1], 2) : take(std::string(words.front()), 1);
}

}  // namespace hgros::cli
