#include "commands/commands.hpp"

#include <algorithm>
#include <array>

namespace hgros::cli {
namespace {

constexpr std::string_view kSee = "See";
constexpr std::string_view kCheck = "Check";
constexpr std::string_view kThis = "This program";

constexpr std::array kCommands{
    CommandEntry{"list", "List channels, sessions, nodes, services, parameters or frames", kSee, MakeList},
    CommandEntry{"echo", "Show the messages of channels", kSee, MakeEcho},

    CommandEntry{"graph", "Draw the hypergraph: processes, nodes and the channels between them", kSee, MakeGraph},
    CommandEntry{"doctor", "Say what is wrong, or soon will be, and how to mend it", kCheck, MakeDoctor},
    CommandEntry{"help", "Explain a command", kThis, MakeHelp},
};

}  // namespace

std::span<const CommandEntry> Commands() noexcept { return kCommands; }

const CommandEntry* FindCommand(std::string_view name) noexcept {
  const auto found = std::ranges::find(kCommands, name, &CommandEntry::name);
  return found == kCommands.end() ? nullptr : &*found;
}

}  // namespace hgros::cli
