#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "arguments/command.hpp"

namespace hgros::cli {

/// All commands, in the order of `hgros help`.
[[nodiscard]] std::span<const CommandEntry> Commands() noexcept;
/// Null if there is none.
[[nodiscard]] const CommandEntry* FindCommand(std::string_view name) noexcept;

/// The error for a command that there is not, with the nearest one.
[[nodiscard]] std::string UnknownCommand(std::string_view name);

// One for each file of this folder.
std::unique_ptr<Command> MakeDoctor();
std::unique_ptr<Command> MakeEcho();
std::unique_ptr<Command> MakeGraph();
std::unique_ptr<Command> MakeHelp();
std::unique_ptr<Command> MakeList();

}  // namespace hgros::cli
