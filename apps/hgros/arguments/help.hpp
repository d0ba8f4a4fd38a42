#pragma once

#include <span>
#include <string>

#include "arguments/command.hpp"

namespace hgros::cli {

class Console;

/// The list of all commands, for `hgros help`.
[[nodiscard]] std::string HelpOfAll(const Console& console, std::span<const CommandEntry> commands);
/// The help of one command of all, or of a family.
[[nodiscard]] std::string HelpOf(const Console& console, const CommandEntry& entry,
                                 std::span<const CommandEntry> commands);
/// "-n, --count N", or "CHANNEL..." of a positional argument.
[[nodiscard]] std::string NamesOf(const Argument& argument);
/// Its text with the choices.
[[nodiscard]] std::string TextOf(const Argument& argument);
/// "hgros echo CHANNEL... [OPTIONS]".
[[nodiscard]] std::string UsageOf(const CommandEntry& entry, const Arguments& arguments);

}  // namespace hgros::cli
