#include "commands/commands.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "hgros/base/names.hpp"

namespace hgros::cli {
namespace {

constexpr std::string_view kSee = "See";
constexpr std::string_view kCheck = "Check";
constexpr std::string_view kSteer = "Steer";
constexpr std::string_view kRun = "Run";
constexpr std::string_view kThis = "This program";

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
    CommandEntry{"tf", "Show the frames of a robot and their transforms", kSee, nullptr},
    CommandEntry{"tf tree", "Show the tree of all frames", kSee, MakeTfTree},
    CommandEntry{"tf echo", "Show the pose of one frame in another", kSee, MakeTfEcho},
    CommandEntry{"tf watch", "Say when transforms appear, are late or disappear", kSee, MakeTfWatch},
    CommandEntry{"tf svg", "Draw the tree of frames as an image", kSee, MakeTfSvg},

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

    CommandEntry{"run", "Start a robot: the components and programs of a robot file", kRun, MakeRun},
    CommandEntry{"ps", "List the components and programs of running robots", kRun, MakePs},
    CommandEntry{"logs", "Show the log of a running robot", kRun, MakeLogs},
    CommandEntry{"restart", "Start a process or program of a robot again", kRun, MakeRestart},
    CommandEntry{"move", "Move a component to another process or host", kRun, MakeMove},
    CommandEntry{"stop", "End a robot", kRun, MakeStop},
    CommandEntry{"wait", "Wait until a robot has ended", kRun, MakeWait},
    CommandEntry{"export", "Write a robot file for other starters", kRun, nullptr},
    CommandEntry{"export systemd", "Write units of systemd", kRun, MakeExportSystemd},
    CommandEntry{"export compose", "Write a file for Docker Compose", kRun, MakeExportCompose},
    CommandEntry{"export kubernetes", "Write a Job or Deployment of Kubernetes", kRun, MakeExportKubernetes},
    CommandEntry{"components", "Show component types with their channels and parameters", kRun, MakeComponents},

    CommandEntry{"help", "Explain a command", kThis, MakeHelp},
    CommandEntry{"completion", "Print a script that completes commands in a shell", kThis, MakeCompletion},
    CommandEntry{"__complete", "Complete a command line", kThis, MakeComplete},
    CommandEntry{"__hosted", "Run a process of a robot of another host", kThis, MakeHosted},
    CommandEntry{"__man", "Write manual pages", kThis, MakeManual},
};

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
  const bool member = first != nullptr && first->family() && words.size() > 1 && !words[1].starts_with('-');
  return member ? take(words[0] + " " + words[1], 2) : take(std::string(words.front()), 1);
}

}  // namespace hgros::cli
